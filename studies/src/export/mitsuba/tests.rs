//! Conversions whose errors would only show in Mitsuba's pictures.

use super::*;
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{GgxParameters, Parameters},
    camera::{Camera, Lens},
    environment::{Environment, direction_from_uv},
    image::Image,
    lights::Emission,
    material::{BrdfModel, Material, MaterialMaps},
    test_scenes,
    texture::{Texels, Texture, TextureSlot},
};
use lapidary_interchange::image;
use std::sync::Arc;

/// Mitsuba's lookup: columns as here, rows from pole to pole with the first and last on the poles (`envmap.cpp`).
fn as_mitsuba_interpolates(map: &Image, uv: Vec2) -> Vec3 {
    let (width, height) = (map.width(), map.height());
    let x = (uv.x - 0.5 / width as f32).rem_euclid(1.0) * width as f32;
    let y = uv.y * (height - 1) as f32;
    let (column, row) = ((x as usize).min(width - 1), (y as usize).min(height - 2));
    let (fx, fy) = (x - column as f32, y - row as f32);
    let line = |row| map.at(column, row).lerp(map.at((column + 1) % width, row), fx);
    line(row).lerp(line(row + 1), fy)
}

#[test]
fn the_map_is_the_same_function_on_both_grids() {
    for size in [[8, 4], [1, 1], [2, 3]] {
        let map = Image::from_fn(size, |x, y| Vec3::new(((x * 5 + y * 3) % 7) as f32, y as f32, 1.0));
        let ours = Environment::new("test".into(), map);
        let exported = emitters::environment_map(&ours.map);
        let mut plain = 0.0_f32;
        for i in 0..500 {
            let uv = Vec2::new((i as f32 * 0.754_877_67).fract(), (i as f32 + 0.5) / 500.0);
            let expected = ours.radiance(direction_from_uv(uv));
            assert!((as_mitsuba_interpolates(&exported, uv) - expected).length() < 2e-3, "{size:?} {uv}");
            if size[1] > 1 {
                plain = plain.max((as_mitsuba_interpolates(&ours.map, uv) - expected).length());
            }
        }
        assert!(size[1] == 1 || plain > 0.3, "negative control: the rows as they are, {plain}");
    }
}

#[test]
fn a_rectangle_lies_where_it_is_and_faces_its_target() {
    let light = Light {
        emission: Emission::Rectangle { width: 2.0, height: 1.0 },
        position: Vec3::new(0.0, 3.0, 1.0),
        target: Vec3::new(0.0, 0.0, 1.0),
        intensity: Vec3::new(1.0, 2.0, 3.0),
        ..Default::default()
    };
    let text = emitters::local(&light).unwrap();
    let rows = text.split("matrix value=\"").nth(1).unwrap().split('"').next().unwrap();
    let rows: Vec<f32> = rows.split(' ').map(|x| x.parse().unwrap()).collect();
    let placed = |v: [f32; 4]| Vec3::from_array([0, 1, 2].map(|row| (0..4).map(|i| rows[4 * row + i] * v[i]).sum()));
    assert_eq!(placed([0.0, 0.0, 0.0, 1.0]), light.position);
    assert!((placed([0.0, 0.0, 1.0, 0.0]) - Vec3::NEG_Y).length() < 1e-6, "its normal");
    let (x, y) = (placed([1.0, 0.0, 0.0, 0.0]), placed([0.0, 1.0, 0.0, 0.0]));
    assert!((x.length() - 1.0).abs() < 1e-6 && (y.length() - 0.5).abs() < 1e-6);
    assert!((x.cross(y).normalize() - Vec3::NEG_Y).length() < 1e-6, "right-handed");
    assert!(text.contains("1, 2, 3") && text.contains("radiance"));
}

/// Corners and normals of a PLY file of one triangle, in the order of its face.
fn triangle_of(ply: &[u8]) -> [[Vec3; 3]; 2] {
    let header = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let number = |i: usize| f32::from_le_bytes(ply[header + 4 * i..header + 4 * i + 4].try_into().unwrap());
    let corner = |v: usize, first: usize| Vec3::from_array([0, 1, 2].map(|i| number(8 * v + first + i)));
    let face = &ply[header + 4 * 8 * 3 + 1..];
    let order = [0, 1, 2].map(|i| u32::from_le_bytes(face[4 * i..4 * i + 4].try_into().unwrap()) as usize);
    [order.map(|v| corner(v, 0)), order.map(|v| corner(v, 3))]
}

#[test]
fn what_shines_on_both_sides_has_a_mesh_before_each() {
    let mut dataset = test_scenes::dataset(&["lamp"], &[]);
    let mesh = dataset.scene.mesh.clone();
    assert_eq!(meshes::parts(&dataset, |_| true).len(), 1, "a surface of one side");
    dataset.two_sided[0] = true;
    assert_eq!(meshes::parts(&dataset, |_| false).len(), 1, "a surface that does not shine");
    let parts = meshes::parts(&dataset, |_| true);
    let sides: Vec<[Vec3; 2]> = parts
        .iter()
        .map(|part| {
            let [[a, b, c], normals] = triangle_of(&part.ply(&mesh));
            let normal = (b - a).cross(c - a).normalize();
            assert_eq!(normals, [normal; 3], "smooth normals are on the same side");
            [normal, a]
        })
        .collect();
    let [[up, front], [down, back]] = sides[..] else { panic!("{sides:?}") };
    assert_eq!([up, down], [Vec3::Y, Vec3::NEG_Y]);
    assert!(front.y > 5e-6 && front.y < 1e-4 && back.y == -front.y, "{front} {back}");
    assert_ne!(parts[0].file(), parts[1].file());
}

#[test]
fn surfaces_send_the_light_of_their_maps() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("textures")).unwrap();
    let textures = [Arc::new(Texture::new("t", [1, 1], Texels::F32(vec![[0.5, 0.25, 2.0, 1.0]])))];
    let mut writer = TextureFolder::new(folder.path(), &textures);
    let parameters =
        Parameters::default().with("emission_luminance", 4.0).with("emission_color", Vec3::new(1.0, 0.5, 1.0));
    let mut text_of = |index: u32, maps: &[&'static str]| {
        let mut material = Material { parameters: parameters.clone(), ..Default::default() };
        maps.iter().for_each(|&map| material.maps.set(map, Some(TextureSlot::default())));
        let text = emitters::surface(&material, index, &mut writer).unwrap();
        let file = folder.path().join(format!("textures/material-{index}-emission.exr"));
        (text, image::read(&file).ok().map(|image| image.pixels[0]), emitters::remarks_of_surface(&material, false))
    };
    let (text, picture, remarks) = text_of(0, &[]);
    assert!(text.contains("\"radiance\" value=\"4, 2, 4\"") && picture.is_none() && remarks.is_empty(), "{text}");
    let color = Vec3::new(2.0, 0.5, 4.0);
    let (text, picture, remarks) = text_of(1, &["emission_color"]);
    assert!(text.contains("<texture type=\"bitmap\" name=\"radiance\">"), "{text}");
    assert!((picture.unwrap() - color).length() < 1e-5 && remarks.len() == 1, "clamped to one: {remarks:?}");
    let (_, picture, _) = text_of(2, &["emission_luminance"]);
    assert!((picture.unwrap() - Vec3::new(2.0, 1.0, 2.0)).length() < 1e-5, "{picture:?}");
    let (_, picture, remarks) = text_of(3, &["emission_color", "emission_luminance"]);
    assert!((picture.unwrap() - color).length() < 1e-5, "{picture:?}");
    assert!(remarks[0].contains("luminance is left out"), "{remarks:?}");
}

#[test]
fn maps_are_multiplied_by_their_parameters_and_differences_are_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("textures")).unwrap();
    let texels = Texels::F32(vec![[0.5, 0.25, -1.0, 1.0]]);
    let textures = [Arc::new(Texture::new("t", [1, 1], texels))];
    let kinds = ["roughness", "normal", "bump", "ior"];
    let maps = MaterialMaps::from(kinds.map(|kind| (kind, TextureSlot::default())));
    let parameters = GgxParameters { roughness: 0.6, anisotropy: -0.5, ..Default::default() };
    let material = Material { parameters: parameters.into(), maps, ..Default::default() };
    let mut writer = TextureFolder::new(folder.path(), &textures);
    let text = bsdf::bsdfs(&material, 3, [true, true], bsdf::Models::Exact, &mut writer).unwrap();
    let read =
        |name: &str| image::read(&folder.path().join(format!("textures/material-3-{name}.exr"))).unwrap().pixels[0];
    assert!((read("roughness") - 0.3).length() < 1e-6);
    assert!((read("ior") - 0.25).length() < 1e-6, "half of what 1.5 has above 1");
    assert!((read("normal") - Vec3::new(0.5, 0.25, -1.0)).length() < 1e-6);
    for part in ["lapidary_ggx", "twosided", "bumpmap", "normalmap", "material-3\"", "material-3-both-sides\""] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(text.matches("<bsdf").count(), text.matches("</bsdf").count());
    let remarks = bsdf::remarks(&material).join("\n");
    assert!(remarks.contains("across") && remarks.contains("index of refraction"), "{remarks}");
    let ward = Material { model: BrdfModel::Ward, ..Default::default() };
    assert!(bsdf::remarks(&ward)[0].contains("lacks its model"));
    let coated = Material {
        model: BrdfModel::OpenPbr,
        parameters: Parameters::default().with("coat_weight", 0.5),
        ..Default::default()
    };
    let text = bsdf::bsdfs(&coated, 0, [true, false], bsdf::Models::Nearest, &mut writer).unwrap();
    assert!(text.contains("\"clearcoat\" value=\"0.5\""), "{text}");
    assert!(bsdf::remarks(&Material::default()).is_empty());
}

#[test]
fn what_a_layered_material_says_is_applied_or_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("textures")).unwrap();
    let texels = Texels::F32(vec![[0.5, 0.25, 1.0, 1.0]]);
    let textures = [Arc::new(Texture::new("t", [1, 1], texels))];
    let mut writer = TextureFolder::new(folder.path(), &textures);
    let parameters = Parameters::default()
        .with("base_color", Vec3::splat(0.8))
        .with("base_weight", 0.5)
        .with("specular_color", Vec3::new(1.0, 0.5, 0.5))
        .with("coat_weight", 0.5)
        .with("coat_roughness", 0.5)
        .with("fuzz_weight", 0.5)
        .with("fuzz_color", Vec3::splat(0.5));
    let maps = MaterialMaps::from(
        ["coat_weight", "coat_roughness", "specular_color"].map(|map| (map, TextureSlot::default())),
    );
    let material = Material { model: BrdfModel::OpenPbr, parameters, maps, ..Default::default() };
    let text = bsdf::bsdfs(&material, 7, [true, false], bsdf::Models::Nearest, &mut writer).unwrap();
    assert!(text.contains("\"base_color\" value=\"0.4, 0.4, 0.4\""), "{text}");
    assert!(text.contains("\"sheen\" value=\"0.25\""), "{text}");
    let read =
        |name: &str| image::read(&folder.path().join(format!("textures/material-7-{name}.exr"))).unwrap().pixels[0].x;
    assert!((read("coat-weight") - 0.25).abs() < 1e-6 && (read("coat-gloss") - 0.75).abs() < 1e-6);
    let told = bsdf::remarks(&material).join("\n");
    assert!(told.contains("without its color") && told.contains("clear one of index 1.5"), "{told}");
    assert!(!told.contains("base weight") && !told.contains("sheen"), "{told}");
}

#[test]
fn what_is_stored_and_not_rendered_is_told() {
    let mut material = Material { model: BrdfModel::OpenPbr, ..Default::default() };
    const TOLD: &str = "what it stores and does not render is left out";
    let is_told = |material: &Material| bsdf::remarks(material).iter().any(|remark| remark.ends_with(TOLD));
    assert!(!is_told(&material), "negative control");
    material.parameters.set("transmission_weight", 0.5);
    assert!(is_told(&material));
}

#[test]
fn values_that_a_model_does_not_have_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = TextureFolder::new(folder.path(), &[]);
    let stale = Parameters::default().with("anisotropy", -0.75).with("edge_color", Vec3::ZERO).with("coat_weight", 1.0);
    let of = |parameters: Parameters, writer: &mut TextureFolder| {
        let material = Material { model: BrdfModel::BlinnPhong, parameters, ..Default::default() };
        let text = bsdf::bsdfs(&material, 0, [true, false], bsdf::Models::Nearest, writer).unwrap();
        (text, bsdf::remarks(&material))
    };
    assert_eq!(of(stale, &mut writer), of(Parameters::default(), &mut writer));
    let own = Parameters::default().with("roughness", 0.75);
    assert_ne!(of(own, &mut writer).0, of(Parameters::default(), &mut writer).0, "negative control");
}

#[test]
fn a_lens_has_the_radius_and_focus_of_its_camera_and_a_shift_moves_positions_on_the_film() {
    let value = |text: &str, name: &str| -> Option<f32> {
        let after = text.split(&format!("name=\"{name}\" value=\"")).nth(1)?;
        after.split('"').next()?.parse().ok()
    };
    let pinhole = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 40.0);
    let open = Lens { f_number: Some(2.0), focus: Some(3.0), ..Lens::default() };
    let text = sensor::aperture(&Camera { lens: open, ..pinhole.clone() });
    let radius = 0.012 / 20_f32.to_radians().tan() / 2.0 / 2.0;
    assert!((value(&text, "aperture_radius").unwrap() / radius - 1.0).abs() < 1e-4, "{text}");
    assert_eq!(value(&text, "focus_distance"), Some(3.0));
    assert_eq!(
        (sensor::aperture(&pinhole), sensor::shift(&View::new(pinhole.clone(), [200, 100]))),
        Default::default()
    );
    let shifted = Camera { lens: Lens { shift: Vec2::new(0.1, 0.3), ..Lens::default() }, ..pinhole };
    let view = View::new(shifted.clone(), [200, 100]);
    let text = sensor::shift(&view);
    let offset = [value(&text, "principal_point_offset_x").unwrap(), value(&text, "principal_point_offset_y").unwrap()];
    // Mitsuba casts the ray of a place on the film plus this offset, both in its widths and heights (`perspective.cpp`).
    let straight = Camera { lens: Lens::default(), ..shifted }.projection(view.size);
    for share in [Vec2::new(0.5, 0.5), Vec2::new(0.2, 0.9)] {
        let size = Vec2::new(200.0, 100.0);
        let (ours, theirs) =
            (view.projection().ray(share * size).1, straight.ray((share + Vec2::from(offset)) * size).1);
        assert!(ours.distance(theirs) < 1e-5, "{share}: {ours} {theirs}");
    }
    let both = View { camera: Camera { lens: Lens { shift: Vec2::X, ..open }, ..view.camera.clone() }, ..view };
    assert_eq!(sensor::shift(&both), "", "a thin lens of Mitsuba has none, and a remark says so");
}
