//! Exports read back unchanged.

use super::*;
use crate::{
    image::{Layer, LayeredImage, Metadata, encode_png_pixels},
    import::{import, load_material},
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    brdf::{BrdfModel, Value},
    image::Image,
    material::{BUMP, Material, NORMAL},
    scene::{Mesh, Object},
    texture::{Channel, ColorSpace, Texels, Texture, TextureSlot, UvSet, Wrap},
};
use std::{fs, path::PathBuf, sync::Arc};

/// A picture of 2 x 2 texels.
fn texture(name: &str, texels: [[u8; 4]; 4]) -> Arc<Texture> {
    let encoded = encode_png_pixels([2, 2], &texels).into();
    Texture { encoded, ..Texture::new(name, [2, 2], Texels::U8(texels.into())) }.into()
}

fn material(name: &str, model: BrdfModel, values: &[(&'static str, Value)]) -> Material {
    let mut material = Material { name: name.into(), model, ..Default::default() };
    values.iter().for_each(|(name, value)| material.parameters.set(*name, *value));
    material
}

fn stretched_metal() -> Material {
    let values = [
        ("base_color", Vec3::new(0.9, 0.6, 0.3).into()),
        ("roughness", 0.35.into()),
        ("metalness", 0.75.into()),
        ("specular", 0.6.into()),
        ("ior", 1.7.into()),
        ("anisotropy", 0.5.into()),
    ];
    material("metal", BrdfModel::Ggx, &values)
}

/// A coat that glTF and MTL can express.
fn lacquer() -> Material {
    let values = [
        ("base_color", Vec3::new(0.5, 0.1, 0.05).into()),
        ("specular_roughness", 0.4.into()),
        ("specular_roughness_anisotropy", 0.25.into()),
        ("coat_weight", 0.75.into()),
        ("coat_roughness", 0.125.into()),
        ("coat_ior", 1.5.into()),
        ("coat_darkening", 0.0.into()),
        ("specular_ior", 1.5.into()),
    ];
    material("red lacquer", BrdfModel::OpenPbr, &values)
}

/// Two triangles of two materials and two objects.
fn scene(materials: Vec<Material>, textures: Vec<Arc<Texture>>) -> Scene {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)];
    let mesh = Mesh {
        normals: vec![Vec3::Z; 6],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 6],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ZERO, Vec2::X, Vec2::Y],
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        triangle_material: vec![0, materials.len() as u32 - 1],
        triangle_object: vec![0, 1],
        positions,
        ..Default::default()
    };
    let objects = ["front", "back"].map(|name| Object { name: name.into() }).into();
    Scene { mesh, materials, textures, objects, ..Default::default() }
}

/// The largest difference of a parameter of `model`, and its name.
fn difference(a: &Material, b: &Material, model: BrdfModel) -> (f32, &'static str) {
    let of = |p: &'static lapidary_core::brdf::Parameter| {
        let [x, y] = [a, b].map(|material| material.parameters.value(p).color());
        ((x - y).abs().max_element(), p.name)
    };
    let all = model.parameters().iter().map(of);
    all.fold((0.0, ""), |most, next| if next.0 > most.0 { next } else { most })
}

fn assert_close(read: &Material, written: &Material) {
    let (most, name) = difference(read, written, written.model);
    assert_eq!((read.model, &read.name), (written.model, &written.name));
    assert!(most < 1e-6, "{name} of {}: {:?} {:?}", read.name, read.parameters.get(name), written.parameters.get(name));
    let mut other = written.clone();
    let roughness = written.model.parameter_for("roughness").map_or("", |p| p.name);
    other.parameters.set(roughness, written.parameters.number(roughness) + 2e-6);
    assert!(difference(read, &other, written.model).0 > 1e-6, "negative control");
}

fn export(scene: &Scene, path: &Path) -> Exported {
    write_materials(scene, path, &ExportOptions::default()).unwrap()
}

#[test]
fn a_library_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.mtl");
    let mut across = stretched_metal();
    across.name = "across".into();
    across.parameters.set("anisotropy", -0.5);
    let slot = |channel, color_space| TextureSlot {
        channel,
        color_space,
        scale: Vec2::new(2.0, 3.0),
        offset: Vec2::new(0.25, 0.5),
        ..Default::default()
    };
    let mut mapped = lacquer();
    mapped.name = "mapped".into();
    mapped.maps.set("base_color", Some(slot(Channel::R, ColorSpace::Srgb)));
    mapped.maps.set("coat_roughness", Some(slot(Channel::B, ColorSpace::Linear)));
    mapped.maps.set(BUMP, Some(TextureSlot { strength: 0.004, ..slot(Channel::G, ColorSpace::Linear) }));
    let written = scene(
        vec![stretched_metal(), across, lacquer(), mapped],
        vec![texture("a/wood grain.png", [[200, 100, 50, 255], [9, 9, 9, 255], [0, 0, 0, 255], [1, 2, 3, 255]])],
    );
    let exported = export(&written, &path);
    assert_eq!((exported.materials, exported.files.len()), (4, 2), "{exported:?}");
    assert!(folder.path().join("scene-maps/wood_grain.png").is_file());
    let told = exported.remarks.join("\n");
    assert!(told.contains("coat ior, coat darkening"), "{told}");
    let obj = folder.path().join("scene.obj");
    let names = written.materials.iter().map(|m| format!("usemtl {}\nf 1 2 3\n", m.name)).collect::<String>();
    fs::write(&obj, format!("mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{names}")).unwrap();
    let read = import(&obj).unwrap().scene;
    for (read, written) in read.materials.iter().zip(&written.materials) {
        // Parameters that MTL lacks become the model's defaults.
        let mut held = written.clone();
        for name in ["coat_ior", "coat_darkening"].into_iter().filter(|_| written.model == BrdfModel::OpenPbr) {
            let default = BrdfModel::OpenPbr.parameter(name).map(|p| p.default).unwrap();
            held.parameters.set(name, default);
        }
        assert_close(read, &held);
        assert_eq!(read.maps, written.maps, "{}", read.name);
    }
}

#[test]
fn a_color_space_that_a_library_cannot_say_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let texels = [[200, 100, 50, 255]; 4];
    let told = |map, color_space| {
        let mut mapped = material("mapped", BrdfModel::Ggx, &[]);
        mapped.maps.set(map, Some(TextureSlot { color_space, ..Default::default() }));
        let path = folder.path().join("a.mtl");
        export(&scene(vec![mapped], vec![texture("a.png", texels)]), &path).remarks.join("\n")
    };
    for (map, key, right) in [("base_color", "map_Kd", ColorSpace::Srgb), ("roughness", "map_Pr", ColorSpace::Linear)] {
        for space in ColorSpace::ALL {
            let remarks = told(map, space);
            assert_eq!(remarks.contains(&format!("the picture of {key} is taken for")), space != right, "{remarks}");
        }
    }
}

#[test]
fn a_file_of_its_own_has_the_meshes_materials_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let mut mapped = stretched_metal();
    mapped.name = "mapped".into();
    let at = |channel| TextureSlot { channel, rotation: 0.5, scale: Vec2::new(2.0, 4.0), ..Default::default() };
    mapped.parameters.set("anisotropy", 0.0);
    mapped.maps.set("base_color", Some(TextureSlot { color_space: ColorSpace::Srgb, ..at(Channel::R) }));
    mapped.maps.set("roughness", Some(at(Channel::R)));
    mapped.maps.set("metalness", Some(TextureSlot { texture: 1, ..at(Channel::G) }));
    mapped.maps.set(NORMAL, Some(TextureSlot { strength: 0.5, flip_y: true, ..Default::default() }));
    mapped.double_sided = true;
    let mut across = stretched_metal();
    across.parameters.set("anisotropy", -0.5);
    across.name = "across".into();
    let textures = vec![
        texture("a", [[255, 100, 50, 255], [128, 9, 9, 255], [64, 0, 0, 255], [1, 2, 3, 255]]),
        texture("b", [[0, 10, 0, 255], [0, 20, 0, 255], [0, 30, 0, 255], [0, 255, 0, 255]]),
    ];
    let written = scene(vec![lacquer(), stretched_metal(), across, mapped], textures);
    for name in ["own.glb", "own.gltf"] {
        let path = folder.path().join(name);
        assert_eq!(export(&written, &path).remarks, [""; 0]);
        let imported = import(&path).unwrap();
        let read = imported.scene;
        assert_eq!(imported.report.warnings, [""; 0]);
        assert_eq!((read.mesh.triangles.len(), read.mesh.positions.len()), (2, 6));
        assert_eq!(read.mesh.positions, written.mesh.positions);
        assert_eq!((&read.mesh.uvs, &read.mesh.normals), (&written.mesh.uvs, &written.mesh.normals));
        assert_eq!(read.mesh.triangle_material, written.mesh.triangle_material);
        assert_eq!(read.objects, written.objects);
        read.materials.iter().zip(&written.materials).for_each(|(read, written)| assert_close(read, written));
        let last = &read.materials[3];
        assert!(last.double_sided && !read.materials[0].double_sided);
        let texel = |map: &str| {
            let slot = last.maps.get(map).unwrap();
            (read.textures[slot.texture as usize].texel(0, 1, slot.color_space)[slot.channel as usize], slot)
        };
        // Red of one and green of the other became green and blue of a third.
        assert!(
            (texel("roughness").0 - 64.0 / 255.0).abs() < 1e-6 && (texel("metalness").0 - 30.0 / 255.0).abs() < 1e-6
        );
        assert_eq!((texel("roughness").1.rotation, texel("roughness").1.scale), (0.5, Vec2::new(2.0, 4.0)));
        let normal = last.maps.get(NORMAL).unwrap();
        assert_eq!((normal.strength, normal.flip_y), (0.5, false), "green was turned");
        let green = read.textures[normal.texture as usize].texel(0, 0, ColorSpace::Linear).y;
        assert!((green - 155.0 / 255.0).abs() < 1e-6, "{green}");
    }
}

/// A glTF file with members unknown to this program.
fn original(folder: &Path, binary: bool) -> PathBuf {
    let data: Vec<u8> =
        [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let picture = encode_png_pixels([2, 2], &[[10, 20, 30, 255]; 4]);
    fs::write(folder.join("picture.png"), picture).unwrap();
    fs::write(folder.join("data.bin"), &data).unwrap();
    let buffer = if binary { "" } else { r#", "uri": "data.bin""# };
    let json = format!(
        r#"{{ "asset": {{"version": "2.0", "extras":   {{"by": "hand"}}}}, "extensionsUsed": ["ACME_unknown"],
        "extensions": {{"ACME_unknown": {{"a": [1.50, 2e1]}}}},
        "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0,   "extras": 1.0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}, {{"attributes": {{"POSITION": 0}}, "material": 1}}]}}],
        "buffers": [{{"byteLength": 36{buffer}}}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}],
        "samplers": [{{"magFilter": 9729}}], "images": [{{"uri": "picture.png"}}], "textures": [{{"source": 0, "sampler": 0}}],
        "materials": [
            {{"name": "kept",   "pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}, "roughnessFactor": 0.50}}}},
            {{"name": "edited", "extras": {{"shop": 7}}, "extensions": {{"ACME_unknown": {{"b": 3}}}},
              "pbrMetallicRoughness": {{"metallicFactor": 0, "metallicRoughnessTexture": {{"index": 0}}}}}}]}}"#
    );
    let path = folder.join(if binary { "original.glb" } else { "original.gltf" });
    let bytes = if binary { gltf::glb_of(&json, data) } else { json.into_bytes() };
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn second_texture_coordinates_wraps_and_colors_of_vertices_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let slot = |uv_set, wrap| TextureSlot { color_space: ColorSpace::Srgb, uv_set, wrap, ..Default::default() };
    let mut materials = ["first", "second"].map(|name| material(name, BrdfModel::Ggx, &[]));
    materials[0].maps.set("base_color", Some(slot(UvSet::Second, [Wrap::Mirror, Wrap::Clamp])));
    materials[1].maps.set("base_color", Some(slot(UvSet::First, [Wrap::Repeat; 2])));
    materials[1].vertex_colors = true;
    let picture = texture("a", [[255, 100, 50, 255], [128, 9, 9, 255], [64, 0, 0, 255], [1, 2, 3, 255]]);
    let mut written = scene(materials.into(), vec![picture]);
    written.mesh.second_uvs = written.mesh.uvs.iter().map(|uv| Vec2::ONE - *uv).collect();
    written.mesh.colors = [Vec3::X, Vec3::Y, Vec3::Z].repeat(2);
    let path = folder.path().join("own.glb");
    assert_eq!(export(&written, &path).remarks, [""; 0]);
    let mut read = import(&path).unwrap().scene;
    assert_eq!(read.mesh.second_uvs, written.mesh.second_uvs);
    assert_eq!(read.mesh.colors, [&[Vec3::ONE; 3], &written.mesh.colors[3..]].concat(), "of the second alone");
    for (read, written) in read.materials.iter().zip(&written.materials) {
        assert_eq!(
            (read.vertex_colors, read.maps.get("base_color")),
            (written.vertex_colors, written.maps.get("base_color"))
        );
    }
    // An edited file has the new edges, and keeps the colors.
    let slot = read.materials[0].maps.get_mut("base_color").unwrap();
    (slot.uv_set, slot.wrap) = (UvSet::First, [Wrap::Clamp; 2]);
    read.materials[1].vertex_colors = false;
    let edited = folder.path().join("edited.glb");
    let options = ExportOptions { original: Some(&path), ..Default::default() };
    let remarks = write_materials(&read, &edited, &options).unwrap().remarks.join("\n");
    assert!(remarks.contains("\"second\": the colors of its vertices stay"), "{remarks}");
    let again = import(&edited).unwrap().scene;
    let places = |scene: &Scene| {
        let slots = scene.materials.iter().filter_map(|material| material.maps.get("base_color"));
        slots.map(|slot| (slot.uv_set, slot.wrap)).collect::<Vec<_>>()
    };
    assert_eq!(places(&again), places(&read));
    assert_ne!(places(&again), places(&written), "negative control");
}

#[test]
fn an_original_brings_the_file_of_a_layer_along() {
    let [folder, other] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let original = original(folder.path(), false);
    let half = Layer::color("Half", &Image::filled([1, 1], Vec3::splat(0.5)));
    let layers = vec![Layer::color("", &Image::filled([1, 1], Vec3::ONE)), half];
    let picture = LayeredImage { size: [1, 1], layers, metadata: Metadata::default() };
    picture.write(&folder.path().join("maps.exr")).unwrap();
    let text = fs::read_to_string(&original).unwrap().replace("picture.png", "maps.exr#Half");
    fs::write(&original, text).unwrap();
    let scene = import(&original).unwrap().scene;
    let path = other.path().join("copy.gltf");
    write_materials(&scene, &path, &ExportOptions { original: Some(&original), ..Default::default() }).unwrap();
    assert!(other.path().join("maps.exr").is_file());
    let read = import(&path).unwrap();
    assert_eq!(read.report.unread, [""; 0]);
    let shown = |scene: &Scene| scene.textures[0].texel(0, 0, ColorSpace::Linear).truncate();
    assert_eq!([shown(&read.scene), shown(&scene)], [Vec3::splat(0.5); 2]);
}

#[test]
fn an_original_keeps_all_but_the_materials_that_changed() {
    let folder = tempfile::tempdir().unwrap();
    let other = tempfile::tempdir().unwrap();
    for binary in [false, true] {
        let original = original(folder.path(), binary);
        let mut scene = import(&original).unwrap().scene;
        let edited = Material { maps: scene.materials[1].maps.clone(), name: "edited".into(), ..lacquer() };
        scene.materials[1] = edited;
        scene.materials[1].maps =
            [("coat_roughness", TextureSlot { channel: Channel::G, ..Default::default() })].into();
        let path = other.path().join(original.file_name().unwrap());
        let options = ExportOptions { original: Some(&original), ..Default::default() };
        let exported = write_materials(&scene, &path, &options).unwrap();
        assert_eq!(exported.remarks, [""; 0]);
        assert!(other.path().join("picture.png").is_file() && (binary || other.path().join("data.bin").is_file()));
        let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
        for kept in [
            r#""extras":   {"by": "hand"}"#,
            r#"{"a": [1.50, 2e1]}"#,
            r#"[{"mesh": 0,   "extras": 1.0}]"#,
            r#"{"name": "kept",   "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.50}}"#,
            r#""shop":7"#,
            r#""ACME_unknown":{"b":3}"#,
            r#"[{"source": 0, "sampler": 0}]"#,
        ] {
            assert!(text.contains(kept), "{kept} is not in {text}");
        }
        assert!(
            text.contains("KHR_materials_clearcoat") && text.contains("\"clearcoatRoughnessTexture\":{\"index\":0}")
        );
        if binary {
            let data = |path: &Path| fs::read(path).unwrap().split_off(fs::read(path).unwrap().len() - 44);
            assert_eq!(data(&path), data(&original), "the chunk of data");
        }
        let read = import(&path).unwrap().scene;
        assert_close(&read.materials[1], &scene.materials[1]);
        assert_eq!(read.materials[0], import(&original).unwrap().scene.materials[0]);
        assert_ne!(
            read.materials[1].parameters,
            import(&original).unwrap().scene.materials[1].parameters,
            "negative control"
        );
    }
}

/// The original after a change of its text, edited and written: what the file shows afterwards.
fn edited(change: impl Fn(&[u8]) -> Vec<u8>, binary: bool) -> (Material, Material) {
    let folder = tempfile::tempdir().unwrap();
    let original = original(folder.path(), binary);
    fs::write(&original, change(&fs::read(&original).unwrap())).unwrap();
    let mut scene = import(&original).unwrap().scene;
    scene.materials[0].parameters.set("roughness", 0.75);
    let path = folder.path().join(if binary { "out.glb" } else { "out.gltf" });
    write_materials(&scene, &path, &ExportOptions { original: Some(&original), ..Default::default() }).unwrap();
    (import(&path).unwrap().scene.materials.swap_remove(0), scene.materials.swap_remove(0))
}

#[test]
fn an_edited_material_of_specular_color_and_glossiness_shows_the_edit() {
    let plain = r#""pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.50}"#;
    let glossy = r#""extensions": {"KHR_materials_pbrSpecularGlossiness": {"glossinessFactor": 0.9,
        "specularFactor": [0.04, 0.04, 0.04]}}"#;
    let change = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        assert!(text.contains(plain));
        text.replace(plain, glossy).into_bytes()
    };
    let (read, written) = edited(change, false);
    assert!((read.parameters.number("roughness") - 0.75).abs() < 1e-6, "{:?}", read.parameters);
    assert_eq!(written.parameters.number("roughness"), 0.75);
}

#[test]
fn a_binary_original_with_wrong_padding_is_written_right() {
    // Its JSON is padded with zeros in place of spaces.
    let change = |bytes: &[u8]| {
        let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let padded = [&bytes[..end], &[0; 4], &bytes[end..]].concat();
        let length = (padded.len() as u32).to_le_bytes();
        let json = (end as u32 - 20 + 4).to_le_bytes();
        [&padded[..8], &length, &json, &padded[16..]].concat()
    };
    let (read, _) = edited(change, true);
    assert!((read.parameters.number("roughness") - 0.75).abs() < 1e-6, "{:?}", read.parameters);
}

#[test]
fn an_original_that_cannot_be_used_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let original = original(folder.path(), true);
    let scene = import(&original).unwrap().scene;
    let with = |scene: &Scene, name: &str, original: &Path| {
        let options = ExportOptions { original: Some(original), ..Default::default() };
        write_materials(scene, &folder.path().join(name), &options).unwrap_err().to_string()
    };
    assert!(with(&scene, "a.gltf", &original).contains("end the name in .glb"));
    assert!(with(&scene, "a.glb", Path::new("gone.glb")).contains("gone.glb"));
    let mut fewer = scene.clone();
    fewer.materials.truncate(1);
    assert!(with(&fewer, "a.glb", &original).contains("2 materials, more than the 1"));
    assert!(with(&scene, "a.fbx", &original).contains(".mtlx, .mtl"));
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("picture.png"), "another").unwrap();
    let options = ExportOptions { original: Some(&original), ..Default::default() };
    let refused = write_materials(&scene, &place.path().join("b.glb"), &options).unwrap_err().to_string();
    assert!(refused.contains("another file") && refused.contains("picture.png"), "{refused}");
}

#[test]
fn a_document_has_all_materials_and_their_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.mtlx");
    let mut mapped = lacquer();
    mapped.name = "mapped".into();
    mapped.maps.set("base_color", Some(TextureSlot { color_space: ColorSpace::Srgb, ..Default::default() }));
    mapped.maps.set("coat_weight", Some(TextureSlot { texture: 1, ..Default::default() }));
    let mut textures = vec![texture("../a.png", [[200, 100, 50, 255]; 4]), texture("A.png", [[1, 100, 50, 255]; 4])];
    textures.push(Arc::new(Texture::missing("gone.png")));
    let mut gone = lacquer();
    gone.name = "gone".into();
    gone.maps.set("base_color", Some(TextureSlot { texture: 2, ..Default::default() }));
    let written = scene(vec![lacquer(), mapped, gone], textures);
    let exported = export(&written, &path);
    assert_eq!(exported.files.len(), 3, "names that differ in case alone are told apart");
    assert!(exported.remarks.iter().any(|remark| remark.contains("gone.png")), "{:?}", exported.remarks);
    for material in &written.materials {
        let mut scene = Scene::default();
        let named = PathBuf::from(format!("{}#{}", path.display(), material.name));
        let read = load_material(&named, &mut scene, &Default::default()).unwrap().0;
        assert_close(&read, material);
        let pictures = if material.name == "mapped" { 2 } else { 0 };
        assert_eq!(scene.textures.len(), pictures);
        if pictures > 0 {
            assert_eq!(scene.textures[0].encoded, written.textures[0].encoded);
        }
    }
}

#[test]
fn new_pictures_join_those_of_an_original() {
    let folder = tempfile::tempdir().unwrap();
    let original = original(folder.path(), true);
    let mut scene = import(&original).unwrap().scene;
    scene.textures.push(texture("new.png", [[50, 60, 70, 255]; 4]));
    let slot = |texture, channel| TextureSlot { texture, channel, ..Default::default() };
    let material = &mut scene.materials[1];
    material.parameters.set("metalness", 0.5);
    material.maps.set("metalness", Some(slot(1, Channel::R)));
    material.maps.set("roughness", Some(slot(0, Channel::B)));
    material.maps.set(NORMAL, Some(slot(1, Channel::R)));
    let path = folder.path().join("more.glb");
    let options = ExportOptions { original: Some(&original), ..Default::default() };
    write_materials(&scene, &path, &options).unwrap();
    let read = import(&path).unwrap();
    // The original's unknown extension is still there.
    assert!(read.report.warnings.iter().all(|warning| warning.contains("ACME_unknown")), "{:?}", read.report.warnings);
    assert_eq!(read.scene.textures.len(), 3);
    let texel = |map: &str| {
        let slot = read.scene.materials[1].maps.get(map).unwrap();
        let texel = read.scene.textures[slot.texture as usize].texel(1, 1, slot.color_space);
        (255.0 * texel[slot.channel as usize]).round()
    };
    assert_eq!(
        (texel("roughness"), texel("metalness"), texel(NORMAL)),
        (30.0, 50.0, 50.0),
        "blue of one, red of the other"
    );
}

#[test]
fn brdfs_of_files_become_the_nearest_and_maps_of_no_light_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut paint = material("paint", BrdfModel::Merl, &[("tint", Vec3::new(0.9, 0.8, 0.7).into())]);
    paint.file = lapidary_core::brdf::example_file(BrdfModel::Merl);
    let encoded = TextureSlot { color_space: ColorSpace::Srgb, ..Default::default() };
    paint.maps.set("tint", Some(encoded.clone()));
    let mut dark = lacquer();
    dark.name = "dark".into();
    dark.maps.set("emission_color", Some(encoded));
    let mut bright = dark.clone();
    bright.name = "bright".into();
    bright.parameters.set("emission_luminance", 2.0);
    let written = scene(vec![paint.clone(), dark, bright], vec![texture("a.png", [[200, 100, 50, 255]; 4])]);
    let exported = export(&written, &folder.path().join("all.mtl"));
    let told = exported.remarks.join("\n");
    assert!(told.contains("material \"paint\": its measured BRDF becomes the nearest"), "{told}");
    assert!(told.contains("material \"dark\": a map of its emission") && !told.contains("material \"bright\": a map"));
    let text = fs::read_to_string(folder.path().join("all.mtl")).unwrap();
    assert_eq!((text.matches("map_Ke").count(), text.matches("map_Kd").count()), (1, 1), "{text}");
    let path = folder.path().join("all.mtlx");
    let exported = export(&written, &path);
    assert!(exported.remarks.iter().any(|remark| remark.contains("its measured BRDF")), "{:?}", exported.remarks);
    let named = PathBuf::from(format!("{}#paint", path.display()));
    let read = load_material(&named, &mut Scene::default(), &Default::default()).unwrap().0;
    let brdf = paint.plain_brdf();
    let (albedo, width) = (brdf.as_brdf().albedo(), brdf.as_brdf().narrowest_lobe().unwrap());
    let (color, roughness) = (read.parameters.color("base_color"), read.parameters.number("specular_roughness"));
    assert!((color - albedo).length() < 1e-5 && (roughness - width.sqrt()).abs() < 1e-5, "{color} {roughness}");
    assert!((color - 1.05 * albedo).length() > 1e-5, "negative control");
    assert!(read.maps.get("base_color").is_some());
}

#[test]
fn pictures_that_were_missing_are_none_but_an_original_keeps_its_entry() {
    let folder = tempfile::tempdir().unwrap();
    let mut gone = lacquer();
    gone.maps.set("base_color", Some(TextureSlot { color_space: ColorSpace::Srgb, ..Default::default() }));
    let path = folder.path().join("own.glb");
    let exported = export(&scene(vec![gone], vec![Texture::missing("gone.png").into()]), &path);
    assert!(exported.remarks.iter().any(|remark| remark.contains("gone.png")), "{:?}", exported.remarks);
    assert!(import(&path).unwrap().scene.textures.is_empty());
    let original = original(folder.path(), false);
    fs::remove_file(folder.path().join("picture.png")).unwrap();
    let mut scene = import(&original).unwrap().scene;
    scene.materials[0].parameters.set("roughness", 0.25);
    let path = folder.path().join("changed.gltf");
    let options = ExportOptions { original: Some(&original), ..Default::default() };
    let exported = write_materials(&scene, &path, &options).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(r#""baseColorTexture":{"index":0}"#) && !text.contains("data:image"), "{text}");
    assert!(exported.remarks.iter().all(|remark| !remark.contains("missing")), "{:?}", exported.remarks);
}

#[test]
fn what_is_stored_and_not_rendered_is_told_by_every_format_without_a_place_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut glass = Material { name: "glass".into(), model: BrdfModel::OpenPbr, ..Default::default() };
    let told = |material: &Material, file: &str| {
        export(&scene(vec![material.clone()], Vec::new()), &folder.path().join(file)).remarks.join("\n")
    };
    for file in ["a.mtl", "a.glb", "a.mtlx"] {
        assert!(!told(&glass, file).contains("transmission"), "negative control");
    }
    glass.parameters.set("transmission_weight", 1.0);
    assert!(told(&glass, "b.mtl").contains("MTL has no place for its transmission weight"));
    assert!(
        told(&glass, "b.glb").contains("parameters that are stored but not rendered are left out: transmission weight")
    );
    assert_eq!(told(&glass, "b.mtlx"), "");
    let text = fs::read_to_string(folder.path().join("b.mtlx")).unwrap();
    assert!(text.contains("name=\"transmission_weight\" type=\"float\" value=\"1\""), "{text}");
}
