//! The surfaces of MaterialX, and the correspondence of their inputs to parameters of `openpbr`.

use glam::Vec3;
use lapidary_core::brdf::{BrdfModel, Parameter, Value};
use serde::{Deserialize, Serialize};

/// A shading model of MaterialX.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Surface {
    /// `open_pbr_surface`: all parameters of the model `openpbr`, by the same names.
    #[default]
    OpenPbr,
    /// `standard_surface` (Autodesk).
    StandardSurface,
    /// `gltf_pbr`.
    GltfPbr,
}

/// An input that corresponds to a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Name of the input.
    pub input: &'static str,
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Value of a missing input.
    pub default: Value,
    /// The parameter is the input to this power.
    pub power: f32,
}

/// Fuzz follows Zeltner in OpenPBR, and Conty in Standard Surface. The power is from the published translation.
const SHEEN_POWER: f32 = 0.4;

impl Row {
    /// The input with a parameter's own name.
    const fn of(p: &Parameter) -> Self {
        Self { input: p.name, parameter: p.name, default: p.default, power: 1.0 }
    }

    const fn number(input: &'static str, parameter: &'static str, default: f32) -> Self {
        Self { input, parameter, default: Value::Number(default), power: 1.0 }
    }

    const fn color(input: &'static str, parameter: &'static str, default: f32) -> Self {
        Self { default: Value::Color(Vec3::splat(default)), ..Self::number(input, parameter, 0.0) }
    }

    const fn to_the(self, power: f32) -> Self {
        Self { power, ..self }
    }
}

const STANDARD_SURFACE: [Row; 21] = [
    Row::number("base", "base_weight", 1.0),
    Row::color("base_color", "base_color", 0.8),
    Row::number("diffuse_roughness", "base_diffuse_roughness", 0.0),
    Row::number("metalness", "base_metalness", 0.0),
    Row::number("specular", "specular_weight", 1.0),
    Row::color("specular_color", "specular_color", 1.0),
    Row::number("specular_roughness", "specular_roughness", 0.2),
    Row::number("specular_IOR", "specular_ior", 1.5),
    Row::number("specular_anisotropy", "specular_roughness_anisotropy", 0.0),
    Row::number("coat", "coat_weight", 0.0),
    Row::color("coat_color", "coat_color", 1.0),
    Row::number("coat_roughness", "coat_roughness", 0.1),
    Row::number("coat_anisotropy", "coat_roughness_anisotropy", 0.0),
    Row::number("coat_IOR", "coat_ior", 1.5),
    Row::number("coat_affect_color", "coat_darkening", 0.0),
    Row::number("sheen", "fuzz_weight", 0.0),
    Row::color("sheen_color", "fuzz_color", 1.0),
    Row::number("sheen_roughness", "fuzz_roughness", 0.3).to_the(SHEEN_POWER),
    Row::number("emission", "emission_luminance", 0.0),
    Row::color("emission_color", "emission_color", 1.0),
    Row::number("opacity", "geometry_opacity", 1.0),
];

const GLTF_PBR: [Row; 14] = [
    Row::color("base_color", "base_color", 1.0),
    Row::number("metallic", "base_metalness", 1.0),
    Row::number("roughness", "specular_roughness", 1.0),
    Row::number("anisotropy_strength", "specular_roughness_anisotropy", 0.0),
    Row::number("specular", "specular_weight", 1.0),
    Row::color("specular_color", "specular_color", 1.0),
    Row::number("ior", "specular_ior", 1.5),
    Row::number("clearcoat", "coat_weight", 0.0),
    Row::number("clearcoat_roughness", "coat_roughness", 0.0),
    Row::color("sheen_color", "fuzz_color", 0.0),
    Row::number("sheen_roughness", "fuzz_roughness", 0.0).to_the(2.0),
    Row::color("emissive", "emission_color", 0.0),
    Row::number("emissive_strength", "emission_luminance", 1.0),
    Row::number("alpha", "geometry_opacity", 1.0),
];

/// An input that is not rendered.
pub(crate) struct Lost {
    /// Name of the input.
    pub input: &'static str,
    /// The lost feature.
    pub what: &'static str,
    /// The number without effect.
    pub without_effect: f32,
}

const fn lost(input: &'static str, what: &'static str) -> Lost {
    Lost { input, what, without_effect: 0.0 }
}

const LOST_OF_OPEN_PBR: [Lost; 3] = [
    lost("geometry_tangent", "the direction of the highlight"),
    lost("geometry_coat_tangent", "the direction of the coat's highlight"),
    lost("geometry_coat_normal", "the normal of the coat"),
];

const LOST_OF_STANDARD_SURFACE: [Lost; 8] = [
    lost("transmission", "transmission"),
    lost("subsurface", "subsurface scattering"),
    lost("thin_film_thickness", "the thin film"),
    lost("specular_rotation", "the turn of the highlight"),
    lost("coat_rotation", "the turn of the coat's highlight"),
    lost("tangent", "the direction of the highlight"),
    lost("coat_normal", "the normal of the coat"),
    lost("coat_affect_roughness", "how much the coat blurs the base"),
];

const LOST_OF_GLTF_PBR: [Lost; 8] = [
    lost("transmission", "transmission"),
    lost("iridescence", "iridescence"),
    lost("dispersion", "dispersion"),
    lost("thickness", "absorption inside"),
    lost("anisotropy_rotation", "the turn of the highlight"),
    lost("tangent", "the direction of the highlight"),
    lost("clearcoat_normal", "the normal of the coat"),
    Lost { input: "occlusion", what: "occlusion, which is computed here", without_effect: 1.0 },
];

/// Further inputs of Standard Surface: those about its lost features.
const OTHERS_OF_STANDARD_SURFACE: [&str; 11] = [
    "transmission_color",
    "transmission_depth",
    "transmission_scatter",
    "transmission_scatter_anisotropy",
    "transmission_dispersion",
    "transmission_extra_roughness",
    "subsurface_color",
    "subsurface_radius",
    "subsurface_scale",
    "subsurface_anisotropy",
    "thin_film_IOR",
];

/// Further inputs of glTF's surface: those of its opacity, and about its lost features.
const OTHERS_OF_GLTF_PBR: [&str; 6] = [
    "alpha_mode",
    "alpha_cutoff",
    "iridescence_ior",
    "iridescence_thickness",
    "attenuation_distance",
    "attenuation_color",
];

impl Surface {
    /// All surfaces.
    pub const ALL: [Self; 3] = [Self::OpenPbr, Self::StandardSurface, Self::GltfPbr];

    /// The category of its node.
    pub const fn node(self) -> &'static str {
        match self {
            Self::OpenPbr => "open_pbr_surface",
            Self::StandardSurface => "standard_surface",
            Self::GltfPbr => "gltf_pbr",
        }
    }

    /// The surface of a node's category.
    pub(super) fn of(node: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|surface| surface.node() == node)
    }

    /// Its inputs that correspond to parameters.
    pub(super) fn rows(self) -> Vec<Row> {
        match self {
            Self::OpenPbr => {
                let own = BrdfModel::OpenPbr.parameters().iter();
                own.filter(|p| p.name != OPACITY_CUTOFF).map(Row::of).collect()
            }
            Self::StandardSurface => STANDARD_SURFACE.into(),
            Self::GltfPbr => GLTF_PBR.into(),
        }
    }

    /// Its inputs that materials store but never render.
    pub(super) fn stored_rows(self) -> Vec<Row> {
        match self {
            Self::OpenPbr => BrdfModel::OpenPbr.stored_parameters().iter().map(Row::of).collect(),
            Self::StandardSurface | Self::GltfPbr => Vec::new(),
        }
    }

    /// Its inputs that are lost.
    pub(crate) const fn lost(self) -> &'static [Lost] {
        match self {
            Self::OpenPbr => &LOST_OF_OPEN_PBR,
            Self::StandardSurface => &LOST_OF_STANDARD_SURFACE,
            Self::GltfPbr => &LOST_OF_GLTF_PBR,
        }
    }

    /// The input of its normal.
    pub(super) const fn normal(self) -> &'static str {
        if matches!(self, Self::OpenPbr) { "geometry_normal" } else { "normal" }
    }

    /// The input for two-sided surfaces, if it has one.
    pub(super) const fn thin_walled(self) -> Option<&'static str> {
        match self {
            Self::OpenPbr => Some("geometry_thin_walled"),
            Self::StandardSurface => Some("thin_walled"),
            Self::GltfPbr => None,
        }
    }

    /// Its further inputs: those that are read elsewhere, and those about lost features.
    const fn others(self) -> &'static [&'static str] {
        match self {
            Self::OpenPbr => &[],
            Self::StandardSurface => &OTHERS_OF_STANDARD_SURFACE,
            Self::GltfPbr => &OTHERS_OF_GLTF_PBR,
        }
    }

    /// Whether it has an input of this name.
    pub(super) fn knows(self, input: &str) -> bool {
        self.rows().iter().chain(&self.stored_rows()).any(|row| row.input == input)
            || self.lost().iter().any(|lost| lost.input == input)
            || self.others().contains(&input)
            || self.normal() == input
            || self.thin_walled() == Some(input)
    }
}

/// The parameter for the opacity below which a surface is cut out.
pub(super) const OPACITY_CUTOFF: &str = "opacity_cutoff";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_name_parameters_of_the_model() {
        let is_known = |name: &str| BrdfModel::OpenPbr.parameter(name).is_some();
        for surface in Surface::ALL {
            let rows = surface.rows();
            assert!(rows.len() > 12 && rows.iter().all(|row| is_known(row.parameter)), "{surface:?}");
            assert!(rows.iter().all(|row| surface.knows(row.input)) && !surface.knows("base_colour"));
            assert_eq!(Surface::of(surface.node()), Some(surface));
        }
        assert!(!is_known("base"), "negative control");
    }

    #[test]
    fn a_surface_knows_its_own_inputs_and_no_others() {
        use Surface::{GltfPbr, OpenPbr, StandardSurface};
        for (input, known) in [
            ("normal", [false, true, true]),
            ("geometry_normal", [true, false, false]),
            ("thin_walled", [false, true, false]),
            ("geometry_thin_walled", [true, false, false]),
            ("alpha_mode", [false, false, true]),
            ("geometry_opacity", [true, false, false]),
            ("emission_color", [true, true, false]),
            ("emission_colour", [false; 3]),
            ("transmission_depth", [true, true, false]),
            ("transmission_dept", [false; 3]),
            ("attenuation_color", [false, false, true]),
            ("iridescence_ior", [false, false, true]),
        ] {
            assert_eq!([OpenPbr, StandardSurface, GltfPbr].map(|surface| surface.knows(input)), known, "{input}");
        }
    }
}
