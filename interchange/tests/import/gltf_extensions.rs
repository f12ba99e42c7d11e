//! Extensions of glTF: unknown required ones, variants, and extensions of materials.

use super::{
    gltf::{Gltf, QUAD},
    *,
};
use lapidary_core::{
    brdf::{BrdfModel, OpenPbrParameters, widths},
    parts::{Part, PartVariants, Variants},
};

/// A quad with a material, whose JSON is `material`, and the picture `a.png`.
fn with_material(material: &str) -> Imported {
    let rest = format!(
        r#", "images": [{{"uri": "a.png"}}], "textures": [{{"source": 0}}], "materials": [{{"name": "m", {material}}}]"#
    );
    let scene = Gltf { primitive: r#""indices": 1, "material": 0"#, rest: Box::leak(rest.into_boxed_str()), ..QUAD };
    let files = Files::new();
    files.add_png("a.png", [0.25; 3]);
    import(&files.add("a.gltf", scene.embedded())).unwrap()
}

#[test]
fn an_extension_that_is_needed_and_not_known_is_named() {
    let files = Files::new();
    let refused = |name: &str| {
        let rest = format!(r#", "extensionsUsed": ["{name}"], "extensionsRequired": ["KHR_materials_ior", "{name}"]"#);
        let scene = Gltf { rest: Box::leak(rest.into_boxed_str()), ..QUAD };
        import(&files.add("needy.gltf", scene.embedded())).err().map(|error| error.to_string())
    };
    let message = refused("ACME_magic").unwrap();
    assert!(
        message.contains("needs the glTF extensions \"ACME_magic\"") && message.ends_with("needy.gltf)"),
        "{message}"
    );
    assert!(message.contains("needy.gltf") && !message.contains("KHR_materials_ior"), "{message}");
    for known in ["KHR_materials_variants", "KHR_materials_transmission", "KHR_materials_emissive_strength"] {
        assert_eq!(refused(known), None, "negative control");
    }
}

#[test]
fn variants_are_listed_and_chosen_by_name() {
    let scene = Gltf {
        primitive: r#""indices": 1, "material": 0, "extensions": {"KHR_materials_variants": {"mappings": [
            {"material": 1, "variants": [0, 2]}, {"material": 9, "variants": [1]}]}}"#,
        rest: r#", "extensionsUsed": ["KHR_materials_variants"],
            "extensions": {"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "broken"}, {"name": "blue"}]}},
            "materials": [{"name": "first"}, {"name": "other"}]"#,
        ..QUAD
    };
    let files = Files::new();
    let path = files.add("shoe.gltf", scene.embedded());
    let shown = |variant: Option<&str>| {
        let options = ImportOptions { variant: variant.map(str::to_owned), ..Default::default() };
        import_with(&path, &options).map(|imported| {
            let material = imported.scene.mesh.triangle_material[0] as usize;
            (imported.scene.materials[material].name.clone(), imported.report)
        })
    };
    let (first, report) = shown(None).unwrap();
    assert_eq!((first.as_str(), report.variants.len()), ("first", 3));
    assert!(report.warnings[0].contains("\"red\", \"broken\", \"blue\"; none is chosen"), "{:?}", report.warnings);
    assert_eq!(shown(Some("red")).unwrap().0, "other");
    assert_eq!(shown(Some("blue")).unwrap().0, "other");
    assert_eq!(shown(Some("broken")).unwrap().0, "first", "a material that is not there");
    let refused = shown(Some("green")).unwrap_err().to_string();
    assert!(
        refused.contains("no material variant \"green\"; it has \"red\"") && refused.contains("shoe.gltf"),
        "{refused}"
    );
    let other = files.add("a.ply", "ply\n");
    let options = ImportOptions { variant: Some("red".into()), ..Default::default() };
    assert!(import_with(&other, &options).unwrap_err().to_string().contains("it has none"));
}

/// Two primitives of one material; only the first changes with the variant.
#[test]
fn parts_know_their_material_in_every_variant_whichever_is_chosen() {
    let scene = Gltf {
        primitive: r#""indices": 1, "material": 0, "extensions": {"KHR_materials_variants": {"mappings": [
            {"material": 1, "variants": [1]}]}}}, {"attributes": {"POSITION": 0}, "indices": 1, "material": 0"#,
        rest: r#", "extensionsUsed": ["KHR_materials_variants"],
            "extensions": {"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "blue"}]}},
            "materials": [{"name": "first"}, {"name": "other"}]"#,
        ..QUAD
    };
    let files = Files::new();
    let path = files.add("shoe.gltf", scene.embedded());
    for (chosen, own) in [(None, 0), (Some("red"), 0), (Some("blue"), 1)] {
        let options = ImportOptions { variant: chosen.map(str::to_owned), ..Default::default() };
        let scene = import_with(&path, &options).unwrap().scene;
        let part = Part { object: 0, material: own };
        let expected = PartVariants { part, plain: 0, in_variants: vec![0, 1] };
        assert_eq!(scene.variants, Variants { names: vec!["red".into(), "blue".into()], parts: vec![expected] });
        let shown = |variant| scene.variants.shown(variant).collect::<Vec<_>>();
        assert_eq!([shown(None), shown(Some(0)), shown(Some(1))], [vec![(part, 0)], vec![(part, 0)], vec![(part, 1)]]);
        let parts: Vec<_> = (0..scene.mesh.triangles.len()).filter_map(|t| Part::of_triangle(&scene.mesh, t)).collect();
        let fixed = Part { object: if own == 0 { 1 } else { 0 }, material: 0 };
        assert!(parts.contains(&part) && parts.contains(&fixed), "{parts:?}");
        assert_eq!(scene.objects.len(), if own == 0 { 2 } else { 1 }, "they are told apart by object or material");
    }
}

#[test]
fn a_stretched_highlight_is_kept_with_a_texture_of_roughness_and_below_a_coat() {
    let stretch = r#""KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 0}"#;
    let with_factor = |factor: f32| {
        let texture = format!(r#"{{"roughnessFactor": {factor}, "metallicRoughnessTexture": {{"index": 0}}}}"#);
        with_material(&format!(r#""extensions": {{{stretch}}}, "pbrMetallicRoughness": {texture}"#))
    };
    let mapped = with_factor(0.5);
    assert_eq!(mapped.report.warnings, [""; 0]);
    let material = &mapped.scene.materials[0];
    let slot = material.maps.get("roughness").unwrap();
    let texel = mapped.scene.textures[0].texel(0, 0, slot.color_space).y;
    let parameters = &material.parameters;
    let found = widths(parameters.number("roughness") * texel, parameters.number("anisotropy"));
    let across = (0.5 * texel).powi(2);
    let expected = [across + (1.0 - across) * 0.36, across];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?} {expected:?}");
    let of_factor = widths(parameters.number("roughness"), parameters.number("anisotropy"));
    assert!((of_factor[0] - expected[0]).abs() > 0.1, "negative control: the lobe of the factor");
    // The factor alone leaves no room for a stretch, but the lobe has one.
    let widest = with_factor(1.0);
    let parameters = &widest.scene.materials[0].parameters;
    assert!(parameters.number("anisotropy") > 0.4 && parameters.number("roughness") == 1.0);
    assert!(widest.report.warnings[0].contains("narrower than meant"), "{:?}", widest.report.warnings);

    let coat = r#""KHR_materials_clearcoat": {"clearcoatFactor": 1}"#;
    let coated = with_material(&format!(
        r#""extensions": {{{stretch}, {coat}}}, "pbrMetallicRoughness": {{"roughnessFactor": 0.5}}"#
    ));
    let p = OpenPbrParameters::from(&coated.scene.materials[0].parameters);
    let short = 1.0 - p.specular_roughness_anisotropy;
    let along = p.specular_roughness.powi(2) * (2.0 / (1.0 + short * short)).sqrt();
    assert!((along - (0.25 + 0.75 * 0.36)).abs() < 1e-5 && (along * short - 0.25).abs() < 1e-5, "{p:?}");
    assert_eq!(coated.report.warnings, [""; 0]);
    let turned = stretch.replace("\"anisotropyRotation\": 0", "\"anisotropyRotation\": 1.5707963");
    let turned = with_material(&format!(r#""extensions": {{{turned}, {coat}}}"#));
    assert_eq!(turned.scene.materials[0].parameters.number("specular_roughness_anisotropy"), 0.0);
    assert!(turned.report.warnings[0].contains("across the tangent below a coat"), "{:?}", turned.report.warnings);
}

#[test]
fn what_extensions_say_and_is_not_kept_is_told() {
    let imported = with_material(
        r#""extensions": {
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": {"index": 0}},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0}},
            "KHR_materials_transmission": {"transmissionFactor": 0.5}}"#,
    );
    let told = imported.report.warnings.join("\n");
    for part in ["have maps of anisotropy", "have normal maps of their coats", "transmit light"] {
        assert!(told.contains(&format!("\"m\" {part}")), "{part}: {told}");
    }
    assert_eq!(
        with_material(r#""extensions": {"KHR_materials_transmission": {"transmissionFactor": 0}}"#).report.warnings,
        [""; 0]
    );
    assert_eq!(imported.scene.materials[0].parameters.number("geometry_opacity"), 0.5);
}

#[test]
fn extensions_are_left_out_with_what_that_means() {
    let told = |rest: &'static str| {
        let file = Gltf { rest, ..QUAD };
        import_alone("a.gltf", file.embedded()).unwrap().report.warnings.join("\n")
    };
    let volume = told(r#", "extensionsUsed": ["KHR_materials_volume", "EXT_new", "KHR_materials_ior", "KHR_xmp"]"#);
    for (name, what) in [("KHR_materials_volume", "bodies show as thin sheets"), ("EXT_new", "may look different")] {
        let sentence = format!("the glTF extensions \"{name}\" are not supported and were left out; ");
        assert!(volume.contains(&sentence) && volume.contains(what), "{volume}");
    }
    assert!(!volume.contains("_ior") && !volume.contains("_xmp"), "negative control: {volume}");
}

#[test]
fn an_extension_with_a_wrong_value_is_left_out_by_its_field() {
    let told = |strength: &str| {
        let extension = r#""KHR_materials_emissive_strength": {"emissiveStrength": STRENGTH}"#;
        let material = format!("\"extensions\": {{{}}}", extension.replace("STRENGTH", strength));
        with_material(&material).report.warnings.join("\n")
    };
    let wrong = told("\"high\"");
    assert!(wrong.contains("\"m\" have a KHR_materials_emissive_strength that was left out"), "{wrong}");
    assert!(wrong.contains(r#""emissiveStrength" is "high", where a number is needed"#), "{wrong}");
    assert_eq!(told("2"), "", "negative control");
}

#[test]
fn a_transform_with_a_wrong_value_is_left_out_by_its_field() {
    let of = |transform: &str, material: &str| {
        let texture = format!(r#"{{"index": 0, "extensions": {{"KHR_texture_transform": {transform}}}}}"#);
        let imported = with_material(&material.replace("TEXTURE", &texture));
        let scales = imported.scene.materials[0].maps.slots().map(|slot| slot.scale).collect::<Vec<_>>();
        (scales, imported.report.warnings.join("\n"))
    };
    let remark = r#""m" have a KHR_texture_transform that was left out, because "scale"#;
    for material in [
        r#""normalTexture": TEXTURE"#,
        r#""extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": TEXTURE}}"#,
    ] {
        let (scales, told) = of(r#"{"scale": "big"}"#, material);
        assert!(scales == [Vec2::ONE] && told.contains(remark), "{scales:?} {told}");
        let negative_control = of(r#"{"scale": [2, 3]}"#, material);
        assert_eq!(negative_control, (vec![Vec2::new(2.0, 3.0)], String::new()));
    }
}

#[test]
fn alpha_counts_where_the_material_says_so() {
    let with_alpha = |mode: &str, alpha: f32, left: u8| {
        let material = format!(
            r#""materials": [{{"name": "m", {mode} "pbrMetallicRoughness": {{"baseColorFactor": [1, 1, 1, {alpha}],
                "baseColorTexture": {{"index": 0}}}}}}]"#
        );
        let rest = format!(r#", "images": [{{"uri": "a.png"}}], "textures": [{{"source": 0}}], {material}"#);
        let scene =
            Gltf { primitive: r#""indices": 1, "material": 0"#, rest: Box::leak(rest.into_boxed_str()), ..QUAD };
        let files = Files::new();
        files.add_rgba("a.png", [2, 1], &[9, 9, 9, left, 9, 9, 9, 255]);
        let imported = import(&files.add("a.gltf", scene.embedded())).unwrap();
        assert_eq!(imported.report.warnings, [""; 0]);
        let material = &imported.scene.materials[0];
        let number = |name: &str| material.parameters.number(name);
        let channel = material.maps.get("geometry_opacity").map(|slot| slot.channel);
        (number("geometry_opacity"), number("opacity_cutoff"), channel)
    };
    let map = Some(Channel::A);
    assert_eq!(with_alpha("", 0.5, 0), (1.0, 0.0, None), "opaque unless it says otherwise");
    assert_eq!(with_alpha(r#""alphaMode": "BLEND","#, 0.5, 7), (0.5, 0.0, map));
    assert_eq!(with_alpha(r#""alphaMode": "BLEND","#, 0.5, 255), (0.5, 0.0, None), "a picture without alpha");
    assert_eq!(with_alpha(r#""alphaMode": "MASK","#, 1.0, 7), (1.0, 0.5, map));
    assert_eq!(with_alpha(r#""alphaMode": "MASK", "alphaCutoff": 0.25,"#, 1.0, 7), (1.0, 0.25, map));
    assert_eq!(with_alpha(r#""alphaMode": "MASK", "alphaCutoff": 0,"#, 0.5, 7), (1.0, 0.0, None), "cuts nothing");
}

#[test]
fn a_colored_highlight_becomes_openpbr_and_a_gray_one_keeps_its_grazing_reflection() {
    let of = |color: &str| {
        let specular =
            format!(r#""KHR_materials_specular": {{"specularFactor": 0.5, "specularColorFactor": {color}}}"#);
        let plastic = r#""pbrMetallicRoughness": {"metallicFactor": 0}"#;
        with_material(&format!(r#"{plastic}, "extensions": {{{specular}}}"#)).scene.materials.remove(0)
    };
    let colored = of("[1, 0.5, 0.25]");
    assert_eq!((colored.model, colored.parameters.number("specular_weight")), (BrdfModel::OpenPbr, 0.5));
    assert_eq!(colored.parameters.color("specular_color"), Vec3::new(1.0, 0.5, 0.25));
    let dark = of("[0.5, 0.25, 0.125]");
    assert_eq!(dark.parameters.color("specular_color"), Vec3::new(1.0, 0.5, 0.25), "the hue");
    // Schlick's mean is F0 + (1 - F0) / 21, and F0 alone is scaled.
    let mean = |ior: f32| {
        2.0 * (0..1000).map(|k| (k as f32 + 0.5) / 1000.0).map(|c| c * fresnel(c, ior)).sum::<f32>() / 1000.0
    };
    for (scale, color) in [(1.0, "[1, 1, 1]"), (0.5, "[0.5, 0.5, 0.5]"), (0.0, "[0, 0, 0]")] {
        let gray = of(color);
        let (weight, ior) = (gray.parameters.number("specular"), gray.parameters.number("ior"));
        assert!(gray.model == BrdfModel::Ggx && weight == 0.5, "{weight}");
        let expected = mean(1.5) - 0.04 * (1.0 - scale) * 20.0 / 21.0;
        assert!((mean(ior) - expected).abs() < 0.004, "{scale}: {} {expected}", mean(ior));
        assert!(fresnel(0.1, ior) > 0.25, "the grazing reflection stays: {}", fresnel(0.1, ior));
        assert!(fresnel(1.0, ior) < 0.02 + 0.04 * scale, "{scale}: {}", fresnel(1.0, ior));
    }
}

#[test]
fn a_dark_specular_color_is_told_where_its_reflection_differs_visibly() {
    let warnings = |color: &str, metalness: f32, weight: f32| {
        let specular =
            format!(r#""KHR_materials_specular": {{"specularFactor": {weight}, "specularColorFactor": {color}}}"#);
        let plastic = format!(r#""pbrMetallicRoughness": {{"metallicFactor": {metalness}}}"#);
        with_material(&format!(r#"{plastic}, "extensions": {{{specular}}}"#)).report.warnings
    };
    // Black shows 1.5 % toward the normal in place of 0, and blue alone 0 in place of Schlick's 1/21 in red.
    for color in ["[0, 0, 0]", "[0, 0, 1]"] {
        let said = warnings(color, 0.0, 1.0);
        assert!(said.len() == 1 && said[0].contains("\"m\" have a dark or strong specular color"), "{said:?}");
        assert_eq!(warnings(color, 1.0, 1.0), [""; 0], "a metal has none");
        assert_eq!(warnings(color, 0.0, 0.1), [""; 0], "a faint highlight");
    }
    for color in ["[1, 1, 1]", "[0.5, 0.5, 0.5]", "[1, 0.9, 0.8]"] {
        assert_eq!(warnings(color, 0.0, 1.0), [""; 0], "negative control");
    }
}

#[test]
fn the_weight_of_a_highlight_leaves_metals_below_a_coat() {
    let of = |metalness: f32, coat: &str| {
        let specular = r#""KHR_materials_specular": {"specularFactor": 0.5}"#;
        let material =
            format!(r#""pbrMetallicRoughness": {{"metallicFactor": {metalness}}}, "extensions": {{{coat}{specular}}}"#);
        with_material(&material).scene.materials.remove(0)
    };
    let coated = of(0.5, r#""KHR_materials_sheen": {}, "#);
    let p = &coated.parameters;
    assert_eq!((coated.model, p.number("specular_weight")), (BrdfModel::OpenPbr, 1.0));
    assert!((fresnel(1.0, p.number("specular_ior")) - 0.02).abs() < 1e-6, "half of 0.04");
    assert_eq!(of(0.0, r#""KHR_materials_sheen": {}, "#).parameters.number("specular_weight"), 0.5, "negative control");
    assert_eq!(of(0.5, "").parameters.number("specular"), 0.5, "GGX means the dielectric alone");
}

#[test]
fn textures_and_extensions_of_materials_that_are_not_rendered_are_told_once_by_name() {
    let warnings = |material: &str| with_material(material).report.warnings;
    let occlusion = warnings(r#""occlusionTexture": {"index": 0}"#);
    assert!(occlusion.len() == 1 && occlusion[0].contains("\"m\" have an occlusion texture"), "{occlusion:?}");
    for name in ["volume", "dispersion", "iridescence", "diffuse_transmission", "unlit"] {
        let said = warnings(&format!(r#""extensions": {{"KHR_materials_{name}": {{}}}}"#));
        let expected = format!("the glTF extensions \"KHR_materials_{name}\" are not supported");
        assert!(said.len() == 1 && said[0].starts_with(&expected), "{said:?}");
    }
    for (name, wrong) in [
        ("clearcoat", r#""clearcoatFactor": "much""#),
        ("sheen", r#""sheenColorFactor": 1"#),
        ("anisotropy", r#""anisotropyStrength": []"#),
        ("transmission", r#""transmissionFactor": {}"#),
        ("emissive_strength", r#""emissiveStrength": "much""#),
    ] {
        let said = warnings(&format!(r#""extensions": {{"KHR_materials_{name}": {{{wrong}}}}}"#));
        let expected = format!("have a KHR_materials_{name} that was left out, because \"");
        assert!(said.len() == 1 && said[0].contains(&expected), "{said:?}");
    }
    for rendered in [
        r#""extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 0}, "clearcoatRoughnessTexture": {"index": 0}}}"#,
        r#""extensions": {"KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenColorTexture": {"index": 0}}}"#,
        r#""extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}"#,
        r#""extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_emissive_strength": {"emissiveStrength": 2}}"#,
    ] {
        assert_eq!(warnings(rendered), [""; 0], "negative control");
    }
}

/// Fresnel's reflectance of a dielectric.
fn fresnel(cosine: f32, ior: f32) -> f32 {
    let root = (ior * ior - 1.0 + cosine * cosine).sqrt();
    let [across, along] =
        [(cosine - root) / (cosine + root), (ior * ior * cosine - root) / (ior * ior * cosine + root)];
    0.5 * (across * across + along * along)
}

#[test]
fn colors_and_coordinates_that_are_not_rendered_are_told_once_by_name() {
    let told = |attributes: &str, targets: &str| {
        let json = QUAD
            .embedded()
            .replace(r#"[{"mesh": 0}]"#, r#"[{"mesh": 0, "name": "Sign"}]"#)
            .replace(r#""POSITION": 0,"#, &format!(r#""POSITION": 0,{attributes}"#))
            .replace(r#""indices": 1"#, &format!(r#""indices": 1, "targets": [{targets}]"#));
        import_alone("a.gltf", json).unwrap().report.warnings
    };
    let targets = "the objects \"Sign\" have morph targets of colors and texture coordinates, which are left out; ";
    for target in [r#"{"POSITION": 0, "COLOR_0": 0}"#, r#"{"POSITION": 0}, {"TEXCOORD_0": 2}"#] {
        let warnings = told("", target);
        assert!(warnings.len() == 1 && warnings[0].starts_with(targets), "{target}: {warnings:?}");
    }
    let further = "the objects \"Sign\" have further sets of colors of vertices, which are left out; ";
    let warnings = told(r#""COLOR_0": 0, "COLOR_1": 0,"#, "");
    assert!(warnings.len() == 1 && warnings[0].starts_with(further), "{warnings:?}");
    assert_eq!(told(r#""COLOR_0": 0,"#, r#"{"POSITION": 0}"#), [""; 0], "negative control");
}
