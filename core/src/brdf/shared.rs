//! Declarations of parameters shared by several models.

use super::{Parameter, parameter::parameters};
use glam::Vec3;

/// Diffuse albedo, or the reflectance of a metal.
pub const BASE_COLOR: Parameter = Parameter::color(
    "Base color",
    [0.8; 3],
    "Diffuse albedo of a dielectric, reflectance at normal incidence of a metal. The hex is sRGB; the value is kept \
     linear, 0 to 1.",
);

/// Perceptual roughness.
pub const ROUGHNESS: Parameter = Parameter::number(
    "Roughness",
    [0.0, 1.0],
    0.5,
    "Width of the highlight, 0 (mirror) to 1 (dull). Perceptual: the microfacet width alpha is its square.",
);

/// Metalness.
pub const METALNESS: Parameter = Parameter::number(
    "Metalness",
    [0.0, 1.0],
    0.0,
    "0 for a dielectric, 1 for a metal. Values between are for transitions in maps.",
);

/// Stretch of the highlight.
pub const ANISOTROPY: Parameter = Parameter::number(
    "Anisotropy",
    [-1.0, 1.0],
    0.0,
    "How far the highlight is stretched: along the tangent (positive, to 1) or across it (negative, to -1). A map goes \
     from 0 (black) to this value (white).",
);

/// Index of refraction.
pub const IOR: Parameter = Parameter::number(
    "IOR",
    [1.0, 10.0],
    1.5,
    "Index of refraction of a dielectric: water 1.33, most plastics and glass 1.5, diamond 2.42. A map goes from 1 \
     (black) to this value (white).",
)
.with_slider([1.0, 3.0])
.above_one();

/// Weight of the specular lobe.
pub const SPECULAR: Parameter = Parameter::number(
    "Specular",
    [0.0, 1.0],
    1.0,
    "Weight of a dielectric's highlight, 0 (none) to 1 (all that its index of refraction gives).",
);

/// Roughness of a diffuse surface.
pub const DIFFUSE_ROUGHNESS: Parameter = Parameter::number(
    "Roughness",
    [0.0, 1.0],
    0.5,
    "Roughness of the diffuse surface: 0 is Lambertian, 1 is flat and dusty as clay or the moon.",
);

/// Tint of a metal toward grazing angles.
pub const EDGE_COLOR: Parameter = Parameter::color(
    "Edge color",
    [0.9; 3],
    "How bright a metal becomes toward grazing angles (Gulbrandsen 2014): lower dips before the edge, as iron and chrome do.",
);

parameters! {
    /// Parameters of a glossy lobe without the colors of a metal's edge, over a diffuse base.
    pub struct GlossyParameters {
        base_color: Vec3 = BASE_COLOR,
        roughness: f32 = ROUGHNESS,
        metalness: f32 = METALNESS,
        specular: f32 = SPECULAR,
        ior: f32 = IOR,
        anisotropy: f32 = ANISOTROPY,
    }
}
