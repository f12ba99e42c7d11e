//! The weight of a highlight means the dielectric's alone in Standard Surface and glTF, and the metal's too in the model here.

use super::*;

/// Reflectance toward the normal of the dielectric below the coat, and weight of the metal.
fn shares(material: &MaterialFile) -> [f32; 2] {
    let number = |name: &str| material.parameters.number(name);
    let ratio = number("specular_ior") / (1.0 + (number("coat_ior") - 1.0) * number("coat_weight"));
    let f0 = ((ratio - 1.0) / (ratio + 1.0)).powi(2);
    [number("specular_weight") * f0, number("specular_weight") * number("base_metalness")]
}

fn of(surface: &str, inputs: &[(&str, f32)]) -> ReadMaterial {
    let inputs: String = inputs
        .iter()
        .map(|(name, value)| format!("<input name=\"{name}\" type=\"float\" value=\"{value}\"/>"))
        .collect();
    read(&document(&format!("<{surface} name=\"s\" type=\"surfaceshader\">{inputs}</{surface}>")), None).unwrap()
}

fn close(found: [f32; 2], expected: [f32; 2]) -> bool {
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn the_weight_of_a_highlight_leaves_the_metal_of_a_mixture() {
    for (surface, metalness, roughness) in
        [("standard_surface", "metalness", "specular_roughness"), ("gltf_pbr", "metallic", "roughness")]
    {
        for (weight, metal) in [(0.0, 0.5), (0.5, 0.25), (1.0, 0.5), (0.0, 1.0)] {
            let ReadMaterial { material, remarks } =
                of(surface, &[("specular", weight), (metalness, metal), (roughness, 0.4)]);
            let dielectric = if metal < 1.0 { weight * 0.04 } else { 0.04 };
            assert!(
                close(shares(&material), [dielectric, metal]),
                "{surface} {weight} {metal}: {:?}",
                shares(&material)
            );
            assert_eq!(remarks, [""; 0]);
        }
        let plastic = of(surface, &[("specular", 0.5), (metalness, 0.0)]).material;
        assert_eq!(plastic.parameters.number("specular_weight"), 0.5, "negative control: no metal, the exact weight");
    }
    // The coat's index is 1.5: that of the base relative to it is 1.8 / 1.5.
    let inputs = |specular| [("specular", specular), ("metalness", 0.5), ("coat", 1.0), ("specular_IOR", 1.8)];
    let below = |specular| shares(&of("standard_surface", &inputs(specular)).material)[0];
    assert!(below(0.0) < 1e-8 && (below(1.0) - (0.2_f32 / 2.2).powi(2)).abs() < 1e-5);
}

#[test]
fn a_map_of_metalness_keeps_its_metal_and_a_map_of_the_weight_is_told() {
    let nodes = r#"<image name="p" type="float"><input name="file" type="filename" value="a.png"/></image>"#;
    let with = |specular: &str| {
        let inputs = format!(
            r#"<input name="metalness" type="float" nodename="p"/><input name="specular" type="float" {specular}/>"#
        );
        read(&document(&format!("{nodes}<standard_surface name=\"s\">{inputs}</standard_surface>")), None).unwrap()
    };
    let ReadMaterial { material, remarks } = with("value=\"0\"");
    assert!(close(shares(&material), [0.0, 1.0]) && remarks.is_empty(), "{remarks:?}");
    let remarks = with("nodename=\"p\"").remarks;
    assert_eq!(remarks, ["\"specular\" also scales the reflection of its metal"]);
}

#[test]
fn a_gray_specular_color_of_gltf_leaves_the_grazing_reflection() {
    let of = |color: &str| {
        let inputs = format!(
            "<input name=\"metallic\" type=\"float\" value=\"0\"/><input name=\"specular_color\" type=\"color3\" value=\"{color}\"/>"
        );
        read(&document(&format!("<gltf_pbr name=\"s\" type=\"surfaceshader\">{inputs}</gltf_pbr>")), None).unwrap()
    };
    let ReadMaterial { material, remarks } = of("0.5, 0.5, 0.5");
    let p = &material.parameters;
    assert_eq!((p.number("specular_weight"), p.color("specular_color")), (1.0, Vec3::ONE));
    assert!(p.number("specular_ior") < 1.45 && p.number("specular_ior") > 1.3 && remarks.is_empty(), "{remarks:?}");
    let ReadMaterial { material, remarks } = of("0.5, 0.25, 0.5");
    assert_eq!(material.parameters.color("specular_color"), Vec3::new(1.0, 0.5, 1.0));
    assert!(remarks[0].contains("too dark at grazing angles"), "{remarks:?}");
    assert_eq!(of("1, 1, 1").material.parameters.number("specular_ior"), 1.5, "negative control");
}

#[test]
fn an_export_keeps_the_reflection_of_metal_and_dielectric_or_tells() {
    let of = |model: BrdfModel, weight: f32, metal: f32, surface: Surface| {
        let mut material = MaterialFile { name: "m".into(), model, ..Default::default() };
        let named = |quantity: &str| model.parameter_for(quantity).unwrap().name;
        material.parameters.set(named("metalness"), metal);
        material.parameters.set(named("specular"), weight);
        material.parameters.set(named("ior"), 1.5);
        let Written { text, remarks } = write(&[material], surface).unwrap();
        (read(&text, None).unwrap().material, remarks)
    };
    for surface in [Surface::StandardSurface, Surface::GltfPbr] {
        let (metal, remarks) = of(BrdfModel::OpenPbr, 0.5, 1.0, surface);
        let color = metal.parameters.number("base_weight") * metal.parameters.color("base_color").x;
        assert!((color - 0.4).abs() < 1e-6 && remarks.is_empty(), "{surface:?}: {color} {remarks:?}");
        let (_, remarks) = of(BrdfModel::OpenPbr, 0.5, 0.5, surface);
        assert!(remarks.len() == 1 && remarks[0].contains("scales the reflection of its metal"), "{remarks:?}");
        // GGX means the dielectric alone, as these surfaces do.
        assert!(close(shares(&of(BrdfModel::Ggx, 0.5, 0.5, surface).0), [0.02, 0.5]));
    }
    let (mixed, remarks) = of(BrdfModel::Ggx, 0.5, 0.5, Surface::OpenPbr);
    assert!(close(shares(&mixed), [0.02, 0.5]) && remarks.is_empty(), "{:?} {remarks:?}", shares(&mixed));
    let (own, remarks) = of(BrdfModel::OpenPbr, 0.5, 0.5, Surface::OpenPbr);
    assert!(close(shares(&own), [0.02, 0.25]) && remarks.is_empty(), "negative control: its own meaning");
}

#[test]
fn the_brightness_of_a_specular_color_is_a_weight_of_gltf() {
    let mut material = MaterialFile { name: "m".into(), model: BrdfModel::OpenPbr, ..Default::default() };
    material.parameters.set("specular_color", Vec3::new(0.5, 0.25, 0.5));
    material.parameters.set("specular_weight", 0.5);
    let text = write(&[material], Surface::GltfPbr).unwrap().text;
    assert!(text.contains(r#"name="specular" type="float" value="0.25""#), "{text}");
    assert!(text.contains(r#"name="specular_color" type="color3" value="1, 0.5, 1""#), "{text}");
}
