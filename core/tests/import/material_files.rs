//! Materials in files of their own.

use super::*;

#[test]
fn material_files_have_a_map_for_every_parameter() {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let keys = ["base_color", "roughness", "metalness", "specular", "anisotropy", "ior", "normal", "bump"];
    for key in keys {
        let json = format!(r#"{{"maps": {{"{key}": {{"file": "a.png", "channel": "b"}}}}}}"#);
        let maps = load_material(&files.add("one.json", &json), &mut Scene::default()).unwrap().maps;
        let read = serde_json::to_value(&maps).unwrap();
        for other in keys {
            assert_eq!(read[other].is_null(), other != key, "{key}, {other}");
        }
        let expected = if key == "base_color" { "srgb" } else { "linear" };
        assert_eq!((&read[key]["color_space"], &read[key]["channel"]), (&expected.into(), &"b".into()));
    }
    let misspelt = files.add("iro.json", r#"{"maps": {"iro": {"file": "a.png"}}}"#);
    assert!(load_material(&misspelt, &mut Scene::default()).is_err());
}

#[test]
fn material_files_bring_their_pictures_once() {
    let files = Files::new();
    files.add_png("maps/a.png", [0.5; 3]);
    let json = r#"{"model": "ward", "parameters": {"roughness": 0.25},
        "maps": {"base_color": {"file": "maps/a.png", "scale": [2, 2], "rotation_degrees": 90},
                 "roughness": {"file": "maps/a.png", "channel": "g"}}}"#;
    let path = files.add("gold.json", json);
    let mut scene = Scene::default();
    let material = load_material(&path, &mut scene).unwrap();
    assert_eq!(
        (material.name.as_str(), material.model, material.parameters.roughness),
        ("gold", BrdfModel::Ward, 0.25)
    );
    let (color, roughness) =
        (material.maps[MapKind::BaseColor].clone().unwrap(), material.maps[MapKind::Roughness].clone().unwrap());
    assert_eq!((color.color_space, roughness.color_space), (ColorSpace::Srgb, ColorSpace::Linear));
    assert_eq!((roughness.channel, color.scale), (Channel::G, Vec2::splat(2.0)));
    assert!((color.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    load_material(&path, &mut scene).unwrap();
    assert_eq!(scene.textures.len(), 1);

    for (name, bad) in
        [("typo.json", r#"{"rougness": 1}"#), ("gone.json", r#"{"maps": {"bump": {"file": "gone.png"}}}"#)]
    {
        assert!(load_material(&files.add(name, bad), &mut scene).is_err());
    }
    assert_eq!(scene.textures.len(), 1);
}
