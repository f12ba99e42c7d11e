//! Indices of refraction for reflectances of a dielectric.

use glam::Vec3;
use lapidary_core::{brdf::BrdfModel, material::MaterialOf};

/// Fresnel's mean over a hemisphere is `(n - 1) / (A + B n)` (Kulla and Conty 2017, *Revisiting physically based shading
/// at Imageworks*).
const A: f32 = 4.085_67;
const B: f32 = 1.000_71;

/// Largest index of refraction of the models.
const MOST_IOR: f32 = 10.0;

/// Reflectance toward the normal, F0, of an index of refraction.
fn reflectance(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

/// The index of refraction of a reflectance toward the normal.
fn ior_of(reflectance: f32) -> f32 {
    let root = reflectance.clamp(0.0, 1.0).sqrt();
    ((1.0 + root) / (1.0 - root)).min(MOST_IOR)
}

fn mean(ior: f32) -> f32 {
    (ior - 1.0) / (A + B * ior)
}

/// The index of refraction of a dielectric whose reflectance toward the normal, F0, is scaled and whose grazing reflectance, F90,
/// stays 1, as glTF's specular color asks for.
///
/// The models here have Fresnel's formula, not Schlick's F0 + (1 - F0)(1 - cos)^5, so F0 and F90 are not free of each other.
/// The index keeps the mean over a hemisphere: Schlick's changes by 20/21 of the change of F0. Keeping F0 instead would leave a
/// black color without any reflection, because an index of 1 has no surface.
fn scaled_ior(ior: f32, scale: f32) -> f32 {
    const MOST: f32 = 0.9;
    if scale == 1.0 || !(ior > 1.0) || !(scale >= 0.0) {
        return ior;
    }
    let normal = reflectance(ior);
    let change = ((scale * normal).min(1.0) - normal) * 20.0 / 21.0;
    let mean = (mean(ior) + change).clamp(0.0, MOST);
    (1.0 + A * mean) / (1.0 - B * mean)
}

/// By how much the reflection of a glTF dielectric with this specular color differs here, toward the normal or in the mean over
/// a hemisphere: the larger, for the worst of red, green and blue. In glTF the color scales F0 alone.
fn error_of_color(ior: f32, color: Vec3) -> f32 {
    let [shown, hue] = [Vec3::splat(scaled_ior(ior, color.max_element())), hue(color)];
    let right = (color * reflectance(ior)).min(Vec3::ONE);
    // White has the difference of Fresnel's formula and Schlick's, which is that of all dielectrics.
    let of_white = mean(ior) - mean_of_schlick(Vec3::splat(reflectance(ior))).x;
    let at_normal = hue * reflectance(shown.x) - right;
    let in_mean = hue * mean(shown.x) - mean_of_schlick(right) - of_white * hue;
    at_normal.abs().max_element().max(in_mean.abs().max_element())
}

fn mean_of_schlick(f0: Vec3) -> Vec3 {
    f0 + (1.0 - f0) / 21.0
}

/// A color over its largest component. Black has the hue of white.
fn hue(color: Vec3) -> Vec3 {
    let most = color.max_element();
    if most > 0.0 { color / most } else { Vec3::ONE }
}

/// Gives a material the specular color of glTF: the brightness of the color scales the index, see [`scaled_ior`], and in OpenPBR
/// its hue scales all of Fresnel's factor. Other models take gray colors only. Returns the loss if it is visible.
pub(crate) fn set_specular_color<S>(material: &mut MaterialOf<S>, color: Vec3) -> Option<&'static str> {
    let [ior_name, weight, metalness] = ["ior", "specular", "metalness"]
        .map(|quantity| material.model.parameter_for(quantity).map_or(quantity, |parameter| parameter.name));
    if material.maps.get(ior_name).is_some() {
        return None;
    }
    let ior = material.parameters.number(ior_name);
    material.parameters.set(ior_name, scaled_ior(ior, color.max_element()));
    if material.model == BrdfModel::OpenPbr {
        material.parameters.set("specular_color", hue(color));
    }
    let is_partly_metal = material.maps.get(metalness).is_some();
    let dielectric = if is_partly_metal { 1.0 } else { 1.0 - material.parameters.number(metalness) };
    visible_loss(material.parameters.number(weight) * dielectric * error_of_color(ior, color))
}

fn visible_loss(error: f32) -> Option<&'static str> {
    /// Share of the light.
    const VISIBLE: f32 = 0.01;
    (error > VISIBLE)
        .then_some("dark or strong specular color, which shows too bright from the front or too dark at grazing angles")
}

/// Makes a specular weight scale the highlight of the dielectric alone, as in Standard Surface and glTF: OpenPBR's model
/// here also scales the metal's reflection. Where there is metal, the dielectric's reflectance toward the normal is scaled by its
/// index of refraction instead, and the weight becomes 1. Returns whether it succeeded: maps of the weight or of the
/// index prevent it.
pub(crate) fn weigh_dielectric<S>(material: &mut MaterialOf<S>) -> bool {
    let (parameters, maps) = (&mut material.parameters, &material.maps);
    let [weight_map, ior_map, metal_map] =
        ["specular_weight", "specular_ior", "base_metalness"].map(|name| maps.get(name).is_some());
    let (weight, metalness) = (parameters.number("specular_weight"), parameters.number("base_metalness"));
    if material.model != BrdfModel::OpenPbr || !(metalness > 0.0) || weight == 1.0 && !weight_map {
        return true;
    }
    let is_all_metal = metalness >= 1.0 && !metal_map;
    if weight_map || ior_map && !is_all_metal {
        return false;
    }
    if !is_all_metal {
        // The base lies below the coat, and has the index relative to it.
        let above = 1.0 + (parameters.number("coat_ior") - 1.0) * parameters.number("coat_weight");
        let ior = parameters.number("specular_ior");
        parameters.set("specular_ior", above * ior_of(weight * reflectance(ior / above)));
    }
    parameters.set("specular_weight", 1.0);
    true
}
