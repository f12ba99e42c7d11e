use super::*;
use crate::image::{decode, decode_with, layer_of, layers_in, read_layer, with_layer};
use exr::prelude::WritableImage;
use lapidary_core::texture::Texture;

type Plane = (&'static str, f32);

/// A part of 2 x 2 pixels with one value per channel.
fn part(name: Option<&str>, channels: &[Plane]) -> openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>> {
    let plane = |&(name, value): &Plane| openexr::AnyChannel::new(name, openexr::FlatSamples::F32(vec![value; 4]));
    let attributes = name.map_or_else(Default::default, openexr::LayerAttributes::named);
    let channels = openexr::AnyChannels::sort(channels.iter().map(plane).collect());
    openexr::Layer::new((2, 2), attributes, openexr::Encoding::UNCOMPRESSED, channels)
}

fn written(parts: Vec<openexr::Layer<openexr::AnyChannels<openexr::FlatSamples>>>) -> Vec<u8> {
    let attributes = openexr::ImageAttributes::new(openexr::IntegerBounds::from_dimensions((2, 2)));
    let mut bytes = Cursor::new(Vec::new());
    let file = openexr::Image::from_layers(attributes, parts);
    file.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn read(bytes: &[u8]) -> Result<Texture, String> {
    decode(bytes, Path::new("a.exr")).map_err(|e| e.to_string())
}

fn first(bytes: &[u8]) -> [f32; 4] {
    read(bytes).unwrap().texel(0, 0, Default::default()).to_array()
}

/// A ramp of data at a position in a display window of 8 x 4 pixels whose first pixel is (100, -50).
fn windowed(position: [i32; 2], size: [usize; 2]) -> Vec<u8> {
    let channels = openexr::SpecificChannels::rgb(move |at: openexr::Vec2<usize>| {
        let [x, y] = [at.x() as i32 + position[0], at.y() as i32 + position[1]];
        let is_shown = (0..8).contains(&x) && (0..4).contains(&y);
        if is_shown { (x as f32, y as f32, 1.0) } else { (9.0, 9.0, 9.0) }
    });
    let mut image = openexr::Image::from_channels((size[0], size[1]), channels);
    image.layer_data.attributes.layer_position = openexr::Vec2(100 + position[0], position[1] - 50);
    image.attributes.display_window = openexr::IntegerBounds::new((100, -50), (8, 4));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn a_picture_has_its_display_window_and_is_black_outside_its_data() {
    let texture = read(&windowed([2, 1], [4, 2])).unwrap();
    assert_eq!(texture.size, [8, 4]);
    let Texels::F32(texels) = &texture.texels else { panic!("exr holds floats") };
    for (i, texel) in texels.iter().enumerate() {
        let [x, y] = [i % 8, i / 8];
        let is_inside = (2..6).contains(&x) && (1..3).contains(&y);
        let expected = if is_inside { [x as f32, y as f32, 1.0, 1.0] } else { [0.0; 4] };
        assert_eq!(*texel, expected, "{x} {y}");
    }
    assert_eq!(texels.iter().filter(|texel| texel[3] == 0.0).count(), 24, "negative control");
}

#[test]
fn overscan_is_cut_away_also_from_layers() {
    let bytes = windowed([-3, -2], [14, 9]);
    let texture = read(&bytes).unwrap();
    let Texels::F32(texels) = &texture.texels else { panic!("exr holds floats") };
    assert_eq!(texture.size, [8, 4]);
    let ramp = |i: usize| [(i % 8) as f32, (i / 8) as f32, 1.0, 1.0];
    assert!(texels.iter().enumerate().all(|(i, texel)| *texel == ramp(i)), "{texels:?}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, &bytes).unwrap();
    let layer = read_layer(&path, "beauty").unwrap();
    assert_eq!((layer.size, layer.at(7, 3)), ([8, 4], Vec3::new(7.0, 3.0, 1.0)));
    let whole = read(&windowed([0, 0], [8, 4])).unwrap();
    assert_eq!(whole.texels, texture.texels, "the same picture without overscan");
}

#[test]
fn the_layer_of_the_whole_picture_is_shown_whatever_its_name() {
    let rgb = |layer: &'static str, value: f32| -> Vec<Plane> {
        let names: [&str; 3] = match layer {
            "" => ["R", "G", "B"],
            "beauty" => ["beauty.R", "beauty.G", "beauty.B"],
            "ViewLayer.Combined" => ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"],
            "diffuse" => ["diffuse.r", "diffuse.g", "diffuse.b"],
            _ => ["albedo.R", "albedo.G", "albedo.B"],
        };
        names.map(|name| (name, value)).to_vec()
    };
    let order = ["", "beauty", "ViewLayer.Combined", "diffuse", "albedo"];
    for shown in 0..order.len() {
        let channels: Vec<Plane> = (shown..order.len()).rev().flat_map(|i| rgb(order[i], i as f32)).collect();
        let bytes = written(vec![part(None, &channels)]);
        assert_eq!(first(&bytes), [shown as f32, shown as f32, shown as f32, 1.0], "{}", order[shown]);
    }
}

#[test]
fn the_part_with_colours_is_read_and_a_usual_name_comes_first() {
    let depth = || part(Some("depth"), &[("Z", 7.0)]);
    let colors = |name, value| part(Some(name), &[("R", value), ("G", value), ("B", value), ("A", 0.5)]);
    let shown = |parts| first(&written(parts));
    assert_eq!(shown(vec![depth(), colors("left", 1.0), colors("right", 2.0)]), [1.0, 1.0, 1.0, 0.5]);
    assert_eq!(shown(vec![colors("left", 1.0), depth(), colors("rgba", 2.0)]), [2.0, 2.0, 2.0, 0.5]);
    let gray = |name, value| part(Some(name), &[("Y", value)]);
    assert_eq!(shown(vec![gray("height", 3.0), gray("mask", 4.0)]), [3.0, 3.0, 3.0, 1.0], "the first of grays");
    assert_eq!(shown(vec![gray("height", 3.0), colors("left", 1.0)]), [1.0, 1.0, 1.0, 0.5], "colors before grays");
}

#[test]
fn a_file_without_colours_shows_its_first_layer_and_tells_the_others() {
    let bytes = written(vec![part(Some("depth"), &[("Z", 7.0)]), part(Some("more"), &[("id", 1.0)])]);
    let mut remarks = Vec::new();
    let texture = decode_with(&bytes, Path::new("a.exr"), None, &mut remarks).unwrap();
    assert_eq!(texture.texel(0, 0, Default::default()).to_array(), [7.0, 7.0, 7.0, 1.0]);
    assert_eq!(remarks.len(), 1);
    assert!(remarks[0].contains("depth, more; depth is shown") && remarks[0].contains("#more"), "{remarks:?}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(layers_in(&path), ["depth", "more"]);
    let (image, told) = crate::image::read_in(&path, Default::default()).unwrap();
    assert_eq!((image.at(0, 0), told), (Vec3::splat(7.0), remarks));
    // A measurement takes no layer by chance.
    let refused = crate::image::read(&path).unwrap_err().to_string();
    assert!(refused.contains("depth, more; choose one") && refused.ends_with("/a.exr)"), "{refused}");
    assert!(crate::image::read(&with_layer(&path, "depth")).is_ok(), "negative control");
    let mut remarks = Vec::new();
    decode_with(&written(vec![part(None, &[("Y", 1.0)])]), Path::new("a.exr"), None, &mut remarks).unwrap();
    assert_eq!(remarks, [""; 0], "negative control: gray is a picture");
}

#[test]
fn twenty_thousand_channels_are_listed_in_no_time() {
    let names: Vec<String> =
        (0..20_000).map(|i| if i % 2 == 0 { format!("c{i}") } else { format!("l{i}.Z") }).collect();
    let channel = |name: &String| openexr::AnyChannel::new(name.as_str(), openexr::FlatSamples::F32(vec![1.0]));
    let channels = openexr::AnyChannels::sort(names.iter().map(channel).collect());
    let image = openexr::Image::from_channels((1, 1), channels);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let headers = headers(bytes.get_ref().as_slice(), Path::new("a.exr")).unwrap();
    let before = std::time::Instant::now();
    let all = choices::all(&headers);
    assert_eq!(all.len(), names.len());
    let missing = choices::find(&headers, "nothing").unwrap_err();
    assert!(missing.ends_with(" more") && missing.len() < 500, "{missing}");
    let taken = before.elapsed().as_secs_f32();
    assert!(taken < 2.0, "{taken} s");
}

#[test]
fn luminance_and_chroma_become_colours() {
    // R, G, B = 0.5, 0.25, 1.0 with the luminance of Rec. 709.
    let [r, g, b] = [0.5, 0.25, 1.0];
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let bytes = written(vec![part(None, &[("Y", y), ("RY", (r - y) / y), ("BY", (b - y) / y)])]);
    let found = Vec3::from_slice(&first(&bytes));
    assert!((found - Vec3::new(r, g, b)).abs().max_element() < 1e-3, "{found}");
    assert_eq!(first(&written(vec![part(None, &[("Y", y)])])), [y, y, y, 1.0], "negative control: gray");
}

/// Two parts with three layers and more channels, each with a value of its own.
fn rich() -> Vec<u8> {
    let colors = [
        ("R", 0.1),
        ("G", 0.2),
        ("B", 0.3),
        ("A", 0.4),
        ("Z", 9.0),
        ("Light.R", 1.1),
        ("Light.G", 1.2),
        ("Light.B", 1.3),
        ("Normal.X", -1.0),
        ("Normal.Y", 0.5),
        ("Normal.Z", 0.25),
        ("Mist.V", 4.0),
        ("id.one", 5.0),
        ("id.two", 6.0),
    ];
    let motion = [("Motion.U", 7.0), ("Motion.V", -7.0), ("Y", 8.0)];
    written(vec![part(Some("left"), &colors), part(Some("extra"), &motion)])
}

fn of_layer(bytes: &[u8], layer: &str) -> Result<Texture, ImageError> {
    decode_with(bytes, Path::new("a.exr"), Some(layer), &mut Vec::new())
}

/// The first texel of a layer.
fn chosen(bytes: &[u8], layer: &str) -> Result<[f32; 4], String> {
    let texture = of_layer(bytes, layer).map_err(|e| e.to_string())?;
    Ok(texture.texel(0, 0, Default::default()).to_array())
}

#[test]
fn each_picture_of_a_file_is_listed_once_and_the_shown_one_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, rich()).unwrap();
    let expected = [
        "left",
        "left.Z",
        "left.Light",
        "left.Mist",
        "left.Normal",
        "left.id.one",
        "left.id.two",
        "extra.Motion",
        "extra",
    ];
    let found = layers_in(&path);
    assert_eq!(found[0], "left");
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    assert_eq!(sorted(found), sorted(expected.map(str::to_owned).to_vec()));
    assert_eq!(layers_in(&with_layer(&path, "left.Z")).len(), expected.len(), "of the file");
    let one = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 1.0)];
    for (channels, names) in [
        (&one[..], &[][..]),
        (&[("Z", 1.0), one[0], one[1], one[2]][..], &["RGBA", "Z"]),
        (&[("X", 1.0), ("Y", 2.0), ("Z", 3.0)], &["Y", "XYZ"]),
        (&[("a.A", 1.0), ("mask", 2.0)], &["a", "mask"]),
    ] {
        std::fs::write(&path, written(vec![part(None, channels)])).unwrap();
        assert_eq!(layers_in(&path), names, "{channels:?}");
    }
    std::fs::write(&path, b"nonsense").unwrap();
    assert_eq!(layers_in(&path), [""; 0]);
    assert_eq!(layers_in(Path::new("gone.exr")), [""; 0]);
}

#[test]
fn a_layer_of_alpha_alone_is_a_mask_with_its_name() {
    let channels = [("R", 0.1), ("G", 0.2), ("B", 0.3), ("coverage.A", 0.5), ("glow.R", 0.6), ("glow.A", 0.7)];
    let bytes = written(vec![part(None, &channels)]);
    assert_eq!(chosen(&bytes, "coverage"), Ok([0.5, 0.5, 0.5, 1.0]));
    assert_eq!(chosen(&bytes, "glow"), Ok([0.6, 0.6, 0.6, 0.7]), "negative control: alpha beside another channel");
}

#[test]
fn colours_vectors_and_single_channels_are_chosen_by_name_in_any_case() {
    let bytes = rich();
    let default = [0.1, 0.2, 0.3, 0.4];
    assert_eq!(first(&bytes), default, "negative control: without a choice");
    for (layer, texel) in [
        ("left", default),
        ("LEFT.light", [1.1, 1.2, 1.3, 1.0]),
        ("left.Normal", [-1.0, 0.5, 0.25, 1.0]),
        ("left.Z", [9.0, 9.0, 9.0, 1.0]),
        ("left.Mist", [4.0, 4.0, 4.0, 1.0]),
        ("left.Mist.V", [4.0, 4.0, 4.0, 1.0]),
        ("left.Normal.X", [-1.0, -1.0, -1.0, 1.0]),
        ("left.id.two", [6.0, 6.0, 6.0, 1.0]),
        ("extra.Motion", [7.0, -7.0, 0.0, 1.0]),
        ("extra", [8.0, 8.0, 8.0, 1.0]),
        ("normal", [-1.0, 0.5, 0.25, 1.0]), // the last words of a name
        ("V", [4.0, 4.0, 4.0, 1.0]),        // also of a single channel
    ] {
        assert_eq!(chosen(&bytes, layer), Ok(texel), "{layer}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, &bytes).unwrap();
    for (named, whole) in [("normal", Some("left.Normal")), ("V", Some("left.Mist.V")), ("gone", None)] {
        assert_eq!(layer_of(&with_layer(&path, named)).as_deref(), whole);
    }
    assert_eq!(layer_of(&path), None);
    for wrong in ["nothing", "", "left.id", "ormal"] {
        let message = chosen(&bytes, wrong).unwrap_err();
        assert!(message.contains(&format!("\"{wrong}\"")) && message.ends_with("(a.exr)"), "{message}");
        assert!(["left", "left.Z", "extra.Motion"].iter().all(|name| message.contains(name)), "{message}");
    }
    let png = crate::image::encode_png(&lapidary_core::image::Image::filled([1, 1], Vec3::ONE));
    assert!(chosen(&png, "left").unwrap_err().contains("only exr files have layers"));
}

#[test]
fn only_colours_are_converted_from_the_primaries_of_the_file() {
    let mut image = openexr::Image::from_layers(
        openexr::ImageAttributes::new(openexr::IntegerBounds::from_dimensions((2, 2))),
        vec![part(None, &[("R", 0.5), ("G", 0.0), ("B", 0.0), ("N.X", 0.5), ("N.Y", 0.0), ("N.Z", 0.0)])],
    );
    // Red and green in the place of each other.
    let rec_709 = Primaries::REC_709;
    let swapped = Primaries { red: rec_709.green, green: rec_709.red, ..rec_709 };
    image.attributes.chromaticities = Some(primaries::chromaticities(&swapped));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let texel = |layer, space| {
        let texture = of_layer(bytes.get_ref(), layer).unwrap();
        // A dataset keeps the bytes and the name.
        let again = decode(&texture.encoded, Path::new(&texture.name)).unwrap();
        assert_eq!((&again.texels, &again.encoded), (&texture.texels, &texture.encoded), "{layer}");
        texture.texel(0, 0, space).truncate()
    };
    use lapidary_core::texture::ColorSpace::{Linear, Srgb};
    assert!((texel("RGBA", Srgb) - Vec3::new(0.0, 0.5, 0.0)).abs().max_element() < 1e-3);
    assert_eq!(texel("RGBA", Linear), Vec3::new(0.5, 0.0, 0.0));
    assert_eq!(texel("N", Srgb), Vec3::new(0.5, 0.0, 0.0));
}

#[test]
fn a_chosen_layer_is_kept_alone_and_found_again_with_and_without_its_name() {
    let bytes = rich();
    for layer in ["left", "left.Light", "normal", "left.Z", "left.Mist.V", "extra.Motion", "extra"] {
        let name = format!("a.exr#{layer}");
        let texture = of_layer(&bytes, layer).unwrap();
        assert_eq!(texture.name, name);
        for path in [&*name, "other.exr"] {
            let again = decode(&texture.encoded, Path::new(path)).unwrap();
            assert_eq!((&again.texels, &again.encoded), (&texture.texels, &texture.encoded), "{path}");
        }
        assert!(texture.encoded.len() < bytes.len(), "{layer}");
        let other = chosen(&texture.encoded, "left.id.one");
        assert!(other.is_err(), "negative control: {layer} is alone: {other:?}");
    }
    assert_eq!(*decode(&bytes, Path::new("a.exr")).unwrap().encoded, *bytes, "without a choice the file as it is");
}

#[test]
fn the_window_of_a_chosen_layer_stays() {
    let bytes = windowed([2, 1], [4, 2]);
    let texture = of_layer(&bytes, "G").unwrap();
    let again = decode(&texture.encoded, Path::new("b.exr")).unwrap();
    assert_eq!((again.size, &again.texels), ([8, 4], &texture.texels));
    assert_eq!(again.texel(3, 2, Default::default()).to_array(), [2.0, 2.0, 2.0, 1.0]);
    assert_eq!(again.texel(0, 0, Default::default()).to_array(), [0.0; 4]);
}
