//! Nearest material of another model, or for another surface.

use super::{
    estimate::without_file,
    stretch,
    surface::{OPACITY_CUTOFF, Surface},
};
use crate::fresnel::weigh_dielectric;
use glam::Vec3;
use lapidary_core::{brdf::BrdfModel, material::MaterialOf};

/// The parameters of `openpbr` that best express a material on a surface; `remarks` gets the losses.
pub(crate) fn nearest<S: Clone>(
    material: &MaterialOf<S>,
    surface: Surface,
    remarks: &mut Vec<String>,
) -> MaterialOf<S> {
    let mut nearest = as_openpbr(material, remarks);
    nearest.parameters = nearest.parameters.sanitized();
    weigh_metal(&mut nearest, material.model, surface, remarks);
    match surface {
        Surface::OpenPbr => {
            if nearest.parameters.number(OPACITY_CUTOFF) > 0.0 {
                remarks.push("OpenPBR has no opacity below which it is cut out; it is blended".into());
            }
        }
        Surface::StandardSurface => {
            unstretched(&mut nearest, ["specular_roughness", "specular_roughness_anisotropy"], stretch::to_burley);
            unstretched(&mut nearest, ["coat_roughness", "coat_roughness_anisotropy"], stretch::to_burley);
        }
        Surface::GltfPbr => {
            unstretched(&mut nearest, ["specular_roughness", "specular_roughness_anisotropy"], stretch::to_gltf);
            say_to_gltf(&mut nearest, remarks);
        }
    }
    if surface != Surface::OpenPbr {
        if nearest.maps.get("fuzz_roughness").is_some() {
            remarks.push("the map of its fuzz roughness is written as it is, without a change of its scale".into());
        }
        let stored: Vec<String> = nearest.stored().map(|p| p.label.to_lowercase()).collect();
        if !stored.is_empty() {
            remarks.push(format!("parameters that are stored but not rendered are left out: {}", stored.join(", ")));
        }
    }
    nearest
}

/// The specular weight of OpenPBR's model here scales metal and dielectric, that of other models and surfaces the dielectric alone.
fn weigh_metal<S>(nearest: &mut MaterialOf<S>, from: BrdfModel, surface: Surface, remarks: &mut Vec<String>) {
    const LOST: &str = "its specular weight scales the reflection of its metal otherwise";
    let number = |name| nearest.parameters.number(name);
    let (weight, metalness, base) = (number("specular_weight"), number("base_metalness"), number("base_weight"));
    let [weights, metals] = ["specular_weight", "base_metalness"].map(|name| nearest.maps.get(name).is_some());
    match (from == BrdfModel::OpenPbr, surface == Surface::OpenPbr) {
        (false, true) if !weigh_dielectric(nearest) => remarks.push(LOST.into()),
        (true, false) if metalness > 0.0 && (weight < 1.0 || weights) => {
            if metalness < 1.0 || metals || weights {
                return remarks.push(LOST.into());
            }
            nearest.parameters.set("base_weight", weight * base);
            nearest.parameters.set("specular_weight", 1.0);
        }
        _ => {}
    }
}

/// Adapts a material to the parts of glTF's surface without a row: weights are multiplied into colors.
fn say_to_gltf<S>(nearest: &mut MaterialOf<S>, remarks: &mut Vec<String>) {
    let p = &nearest.parameters;
    let (base, fuzz) = (p.number("base_weight"), p.number("fuzz_weight"));
    let (base_color, fuzz_color) = (base * p.color("base_color"), fuzz * p.color("fuzz_color"));
    let told = [
        (p.number("base_diffuse_roughness") > 0.0, "glTF has no roughness of the diffuse base"),
        (p.number("coat_weight") > 0.0 && p.color("coat_color") != Vec3::ONE, "glTF has no color of the coat"),
        (p.number("coat_weight") > 0.0 && p.number("coat_darkening") > 0.0, "glTF's coat does not darken"),
        (p.number("coat_weight") > 0.0 && (p.number("coat_ior") - 1.5).abs() > 1e-6, "glTF's coat has the index 1.5"),
        (p.number("coat_roughness_anisotropy") > 0.0, "glTF's coat is not stretched"),
    ];
    remarks.extend(told.into_iter().filter(|(lost, _)| *lost).map(|(_, text)| text.to_owned()));
    for weight in ["base_weight", "fuzz_weight", "base_diffuse_roughness", "coat_color", "coat_ior", "coat_darkening"] {
        if nearest.maps.get(weight).is_some() {
            remarks.push(format!("the map of its {} is left out", weight.replace('_', " ")));
        }
    }
    // The color of glTF scales the reflectance toward the normal alone, its weight all of it.
    let specular = p.color("specular_color");
    let (weight, most) = (p.number("specular_weight"), specular.max_element());
    nearest.parameters.set("specular_weight", weight * most);
    nearest.parameters.set("specular_color", if most > 0.0 { specular / most } else { Vec3::ONE });
    nearest.parameters.set("base_color", base_color);
    nearest.parameters.set("fuzz_color", fuzz_color);
}

/// Replaces OpenPBR's numbers by the other surface's, for the same lobe.
fn unstretched<S>(nearest: &mut MaterialOf<S>, names: [&'static str; 2], numbers: fn(stretch::Widths) -> [f32; 2]) {
    let [roughness, anisotropy] = names.map(|name| nearest.parameters.number(name));
    let is_mapped = names.iter().any(|name| nearest.maps.get(name).is_some());
    if anisotropy > 0.0 && !is_mapped {
        let lobe = numbers(stretch::of_openpbr(roughness, anisotropy));
        names.into_iter().zip(lobe).for_each(|(name, number)| nearest.parameters.set(name, number));
    }
}

/// Converts a material to `openpbr` with lobes of the same width; `remarks` gets the losses.
pub(crate) fn as_openpbr<S: Clone>(material: &MaterialOf<S>, remarks: &mut Vec<String>) -> MaterialOf<S> {
    let material = &*without_file(material, remarks);
    let mut nearest = material.own();
    if material.model == BrdfModel::OpenPbr {
        return nearest;
    }
    // A missing value is the default of its own model, not of the other.
    for parameter in material.model.parameters() {
        nearest.parameters.set(parameter.name, parameter.sanitized(material.parameters.value(parameter)));
    }
    nearest.change_model(BrdfModel::OpenPbr);
    // A name common to two models may have different defaults.
    if material.model.parameter_for("roughness").is_none() {
        nearest.parameters.set("specular_weight", 0.0);
        nearest.parameters.set("specular_roughness", 1.0);
    }
    let number = |quantity: &str| {
        material.model.parameter_for(quantity).map_or(0.0, |p| p.sanitized(material.parameters.value(p)).number())
    };
    let anisotropy = number("anisotropy");
    if anisotropy < 0.0 {
        remarks.push("its highlight is stretched across the tangent, which OpenPBR cannot say; it is round".into());
    }
    if anisotropy > 0.0 {
        let lobe = stretch::to_openpbr(stretch::of_burley(number("roughness"), 0.9 * anisotropy));
        nearest.parameters.set("specular_roughness", lobe[0]);
        nearest.parameters.set("specular_roughness_anisotropy", lobe[1]);
    }
    let edge = material.model.parameter("edge_color");
    if edge.is_some_and(|p| material.parameters.value(p) != p.default) && number("metalness") > 0.0 {
        remarks.push("the color of its metal toward the edge becomes that of OpenPBR".into());
    }
    nearest
}
