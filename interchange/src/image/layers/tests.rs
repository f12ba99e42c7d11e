use super::*;
use crate::image::{read, read_layer, write};
use exr::meta::{MetaData, attribute::AttributeValue};
use glam::{Mat4, Vec3};
use lapidary_core::camera::Camera;

const SIZE: [u32; 2] = [7, 5];

fn ramp(scale: f32) -> Image {
    Image::from_fn(SIZE, |x, y| scale * Vec3::new(x as f32 - 2.0, y as f32, 70_000.0))
}

fn layered() -> LayeredImage {
    let depth: Vec<f32> = (0..35).map(|i| i as f32).collect();
    let layers = vec![
        Layer::color("", &ramp(1.0)).with_alpha(&[0.5; 35]),
        Layer::color("environment", &ramp(2.0)),
        Layer::vectors("normal", &ramp(3.0)),
        Layer::scalar("merged_nodes", "Y", depth),
    ];
    LayeredImage { size: SIZE, layers, metadata: Metadata::default() }
}

fn written(image: LayeredImage) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    image.write(&path).unwrap();
    (folder, path)
}

fn header(path: &Path) -> exr::meta::header::Header {
    let meta = MetaData::read_from_file(path, true).unwrap();
    assert_eq!(meta.headers.len(), 1, "one part");
    meta.headers[0].clone()
}

#[test]
fn layers_are_prefixes_of_channels_in_one_part_and_are_read_back_exactly() {
    let (_folder, path) = written(layered());
    let names: Vec<String> = header(&path).channels.list.iter().map(|c| c.name.to_string()).collect();
    let expected = ["A", "B", "G", "R", "environment.B", "environment.G", "environment.R"];
    assert_eq!(names[..7], expected);
    assert_eq!(names[7..], ["merged_nodes.Y", "normal.X", "normal.Y", "normal.Z"]);
    assert_eq!(read(&path).unwrap(), ramp(1.0), "what every program shows");
    let layer = |name: &str| read_layer(&path, name).unwrap();
    assert_eq!(layer("beauty"), ramp(1.0));
    assert_eq!(layer("environment"), ramp(2.0));
    assert_eq!(layer("Normal"), ramp(3.0));
    assert_eq!(layer("merged-nodes").pixels[9], Vec3::splat(9.0));
}

#[test]
fn a_layer_that_is_not_there_is_an_error_that_lists_those_that_are() {
    let (folder, path) = written(layered());
    let message = read_layer(&path, "diffuse").unwrap_err().to_string();
    for word in ["diffuse", "RGBA", "environment", "normal", "merged_nodes", "a.exr"] {
        assert!(message.contains(word), "{message}");
    }
    let png = folder.path().join("a.png");
    write(&ramp(0.1), &png).unwrap();
    let message = read_layer(&png, "beauty").unwrap_err().to_string();
    assert!(message.contains("only exr files have layers"), "{message}");
    let io = read_layer(&folder.path().join("gone.exr"), "beauty").unwrap_err();
    assert!(matches!(io, ImageError::Io { action: "read", .. }));
}

#[test]
fn layers_of_other_programs_are_found_as_parts_and_by_the_end_of_their_names() {
    let image = |layers| LayeredImage { size: SIZE, layers, metadata: Metadata::default() };
    let blender =
        image(vec![Layer::color("ViewLayer.Combined", &ramp(1.0)), Layer::color("ViewLayer.DiffDir", &ramp(2.0))]);
    let (_folder, path) = written(blender);
    assert_eq!(read_layer(&path, "combined").unwrap(), ramp(1.0));
    assert_eq!(read_layer(&path, "ViewLayer.DiffDir").unwrap(), ramp(2.0));
    let (_folder, path) = written(image(vec![Layer::color("beauty", &ramp(4.0)), Layer::color("other", &ramp(2.0))]));
    assert_eq!(read(&path).unwrap(), ramp(4.0), "a layer called beauty is what is shown");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.exr");
    let part = |name: &str, scale: f32| {
        let pixels = ramp(scale);
        let at = move |at: openexr::Vec2<usize>| <(f32, f32, f32)>::from(pixels.at(at.x(), at.y()));
        let attributes = openexr::LayerAttributes::named(name);
        let encoding = openexr::Encoding::SMALL_LOSSLESS;
        openexr::Layer::new((7, 5), attributes, encoding, openexr::SpecificChannels::rgb(at))
    };
    let bounds = openexr::IntegerBounds::from_dimensions((7, 5));
    let attributes = openexr::ImageAttributes::new(bounds);
    let file = openexr::Image::empty(attributes).with_layer(part("left", 1.0)).with_layer(part("right", 2.0));
    file.write().to_file(&path).unwrap();
    assert_eq!(read_layer(&path, "right").unwrap(), ramp(2.0));
}

#[test]
fn the_file_says_what_colours_it_holds_and_what_it_was_made_with() {
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 6.0), Vec3::new(1.0, 2.0, 1.0), 90.0);
    let entries = vec![
        ("lapidary.environment".to_owned(), MetaValue::Text("夜.hdr".into())),
        ("lapidary.a_name_that_is_longer_than_31_bytes".to_owned(), MetaValue::Number(0.1)),
        ("lapidary.eye".to_owned(), MetaValue::Vector(Vec3::new(1.0, 2.0, 6.0))),
    ];
    let metadata = Metadata { software: Some("Lapidary 1".into()), camera: Some(camera.clone()), entries };
    let (_folder, path) = written(LayeredImage { metadata, ..layered() });
    let header = header(&path);
    assert_eq!(header.shared_attributes.chromaticities, Some(chromaticities(&Primaries::REC_709)));
    let own = &header.own_attributes;
    assert_eq!(own.software_name.as_ref().map(|s| s.to_string()).as_deref(), Some("Lapidary 1"));
    let other = |name: &str| own.other[&metadata::text(name)].clone();
    assert_eq!(other("lapidary.environment"), AttributeValue::Text(metadata::text("夜.hdr")));
    assert_eq!(other("lapidary.a_name_that_is_longer_than_31_bytes"), AttributeValue::F64(0.1));
    assert_eq!(other("lapidary.eye"), AttributeValue::FloatVec3((1.0, 2.0, 6.0)));
    assert!((own.vertical_field_of_view.unwrap() - 90.0).abs() < 1e-4);
    assert!((own.screen_window_width - 2.0 * 7.0 / 5.0).abs() < 1e-5);
    let camera_from_world = Mat4::from_cols_array(&own.world_to_camera.unwrap());
    assert!((camera_from_world.transform_point3(camera.target) - Vec3::new(0.0, 0.0, -5.0)).length() < 1e-5);
    assert!((camera_from_world.transform_point3(camera.eye + Vec3::X) - Vec3::X).length() < 1e-5);
}

#[test]
fn plain_pictures_say_their_colours_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.exr");
    write(&ramp(1.0), &path).unwrap();
    assert_eq!(header(&path).shared_attributes.chromaticities, Some(chromaticities(&Primaries::REC_709)));
}

#[test]
fn damaged_files_are_errors_and_never_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.exr");
    let whole = layered().encode().unwrap();
    let random = &mut fastrand::Rng::with_seed(3);
    for _ in 0..400 {
        let mut bytes = whole.clone();
        let at = random.usize(..bytes.len());
        bytes[at] = random.u8(..);
        bytes.truncate(if random.bool() { random.usize(..bytes.len()) } else { whole.len() });
        std::fs::write(&path, &bytes).unwrap();
        let _ = read_layer(&path, "normal");
    }
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(read_layer(&path, "normal").is_err());
}
