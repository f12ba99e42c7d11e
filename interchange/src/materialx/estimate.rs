//! Approximations of materials for formats that lack a part of them.

use crate::material_file::SlotFile;
use lapidary_core::{
    brdf::{BrdfModel, SurfaceParameters},
    material::{BUMP, Maps, MaterialOf, NORMAL},
};
use std::borrow::Cow;

/// Quantities whose maps scale the whole BRDF of a file.
const TINTS: [&str; 2] = ["base_color", "tint"];

/// A material with a BRDF file as a GGX material, or Lambert if it has no lobe, of the same albedo and width; `remarks`
/// gets a sentence.
pub(crate) fn without_file<'a, S: Clone>(
    material: &'a MaterialOf<S>,
    remarks: &mut Vec<String>,
) -> Cow<'a, MaterialOf<S>> {
    if !material.model.has_file() {
        return Cow::Borrowed(material);
    }
    let brdf = material.plain_brdf();
    let brdf = brdf.as_brdf();
    let width = brdf.narrowest_lobe();
    let model = if width.is_some() { BrdfModel::Ggx } else { BrdfModel::Lambert };
    let mut near = MaterialOf { model, file: None, ..material.clone() };
    let is_of_surface = |name: &str| SurfaceParameters::LIST.iter().any(|p| p.name == name);
    near.parameters = Default::default();
    for parameter in SurfaceParameters::LIST {
        near.parameters.set(parameter.name, material.parameters.value(parameter));
    }
    near.parameters.set("base_color", brdf.albedo());
    if let Some(width) = width {
        near.parameters.set("roughness", width.sqrt());
    }
    near.parameters = near.parameters.sanitized();
    near.maps.retain(|name, _| [NORMAL, BUMP].contains(&name) || is_of_surface(name));
    let mapped = material.own_parameters().iter().filter_map(|p| Some((p, material.maps.get(p.name)?)));
    for (parameter, slot) in mapped {
        if TINTS.contains(&parameter.quantity) {
            near.maps.set("base_color", Some(slot.clone()));
        } else {
            remarks.push(format!("the map of its {} is left out", parameter.label.to_lowercase()));
        }
    }
    let kind = if material.model == BrdfModel::Merl { "measured" } else { "written" };
    remarks.push(format!("its {kind} BRDF becomes the nearest of its color and of the width of its lobe"));
    Cow::Owned(near)
}

/// Leaves out the patterns of a material, which name no picture; `remarks` gets a sentence each.
pub(super) fn leave_out_patterns(maps: &mut Maps<SlotFile>, remarks: &mut Vec<String>) {
    maps.retain(|name, slot| {
        let is_picture = slot.procedural.is_none() && !slot.file.is_empty();
        if !is_picture {
            let what = name.replace('_', " ");
            remarks
                .push(format!("the pattern of its {what} is left out; an export of all materials makes it a picture"));
        }
        is_picture
    });
}
