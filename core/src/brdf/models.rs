//! The list of all models. A new model is a file beside this one, a file named by its key in `shaders/brdf/`, and a line here.

use super::{
    AshikhminShirley, Beckmann, BlinnPhong, Brdf, ContentKind, FilePart, Ggx, Lambert, LightsX8, Merl, Model, OpenPbr,
    OrenNayar, Parameter, SpreadX8, SurfaceParameters, Values, Ward, WardDuer, Wgsl, surface::with_surface, written,
};
use crate::simd::Vec3x8;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use wide::f32x8;

macro_rules! models {
    ($($(#[$attribute:meta])* $variant:ident($ty:ty) = $key:literal,)*) => {
        /// Reflectance model of a material.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum BrdfModel {
            $(#[doc = concat!("See [`", stringify!($variant), "`].")] $(#[$attribute])* #[serde(rename = $key)] $variant,)*
        }

        impl BrdfModel {
            /// All models, in the order of lists.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Its name in files and on the command line.
            pub const fn key(self) -> &'static str {
                match self { $(Self::$variant => $key,)* }
            }

            /// Its display name.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => <$ty as Model>::LABEL,)* }
            }

            /// Its description.
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$variant => <$ty as Model>::SUMMARY,)* }
            }

            /// The parameters of its reflectance.
            pub const fn own_parameters(self) -> &'static [Parameter] {
                match self { $(Self::$variant => <$ty as Model>::PARAMETERS,)* }
            }

            /// Parameters that its materials keep for other programs and that are never rendered.
            pub const fn stored_parameters(self) -> &'static [Parameter] {
                match self { $(Self::$variant => <$ty as Model>::STORED,)* }
            }

            /// The parameters of its materials: its own, then [`SurfaceParameters`].
            pub const fn parameters(self) -> &'static [Parameter] {
                match self {
                    $(Self::$variant => {
                        const ALL: &[Parameter] =
                            &with_surface::<{ <$ty as Model>::PARAMETERS.len() + SurfaceParameters::LIST.len() }>(
                                <$ty as Model>::PARAMETERS,
                            );
                        ALL
                    })*
                }
            }

            /// Its WGSL source; `shaders/brdf.wgsl` lists the required declarations.
            pub const fn wgsl(self) -> &'static str {
                match self { $(Self::$variant => include_str!(concat!("../../../shaders/brdf/", $key, ".wgsl")),)* }
            }

            /// Name of its type, here and in shaders.
            pub const fn type_name(self) -> &'static str {
                match self { $(Self::$variant => stringify!($variant),)* }
            }
        }

        /// A model of any kind, by value.
        #[derive(Clone, Debug)]
        pub enum SurfaceBrdf {
            $(#[doc = concat!("See [`", stringify!($variant), "`].")] $variant($ty),)*
        }

        impl SurfaceBrdf {
            /// Creates a model from its file and values in the order of its parameters, within their ranges.
            #[inline]
            pub fn new(model: BrdfModel, values: &Values, file: Option<FilePart>) -> Self {
                match model { $(BrdfModel::$variant => Self::$variant(<$ty as Model>::of_file(values, file)),)* }
            }

            /// The model behind the variant.
            #[inline(always)]
            pub fn as_brdf(&self) -> &dyn Brdf {
                match self { $(Self::$variant(brdf) => brdf,)* }
            }

            /// Calls the visitor with the concrete model, so it is compiled for each.
            #[inline(always)]
            pub fn visit<V: BrdfVisitor>(&self, visitor: V) {
                match self { $(Self::$variant(brdf) => visitor.visit(brdf),)* }
            }
        }
    };
}

models! {
    Lambert(Lambert) = "lambert",
    OrenNayar(OrenNayar) = "oren-nayar",
    BlinnPhong(BlinnPhong) = "blinn-phong",
    AshikhminShirley(AshikhminShirley) = "ashikhmin-shirley",
    Ward(Ward) = "ward",
    WardDuer(WardDuer) = "ward-duer",
    Beckmann(Beckmann) = "beckmann",
    #[default]
    Ggx(Ggx) = "ggx",
    OpenPbr(OpenPbr) = "openpbr",
    Merl(Merl) = "merl",
    Wgsl(Wgsl) = "wgsl",
}

impl SurfaceBrdf {
    /// [`Brdf::brdf_cos_x8`] on a surface with slopes that widen its lobes, see [`SpreadX8::slopes`].
    pub fn spread_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8, slopes: [f32; 3]) -> Vec3x8 {
        let mut value = Vec3x8::splat(Vec3::ZERO);
        self.visit(Reflect {
            lights: LightsX8::spread(wi, SpreadX8::with_slopes(inv_kappa, slopes)),
            wo,
            value: &mut value,
        });
        value
    }
}

/// Visitor that reflects eight lights.
struct Reflect<'a> {
    lights: LightsX8<f32x8>,
    wo: Vec3,
    value: &'a mut Vec3x8,
}

impl BrdfVisitor for Reflect<'_> {
    fn visit(self, brdf: &impl Brdf) {
        *self.value = brdf.reflect(&self.lights, self.wo);
    }
}

/// A generic operation on a concrete model.
pub trait BrdfVisitor {
    /// Runs the operation.
    fn visit(self, brdf: &impl Brdf);
}

impl BrdfModel {
    /// Declaration of a parameter by a model or by a BRDF file read so far, rendered or stored.
    pub fn declared(name: &str) -> Option<&'static Parameter> {
        Self::declared_by_models(name).or_else(|| written::all_declared().into_iter().find(|p| p.name == name))
    }

    /// Declaration of a parameter by a model, rendered or stored; files do not count.
    pub fn declared_by_models(name: &str) -> Option<&'static Parameter> {
        let of = |model: &Self| model.parameter(name).or_else(|| model.stored_parameter(name));
        Self::ALL.iter().find_map(of)
    }

    /// Whether its materials use a file.
    pub fn has_file(self) -> bool {
        matches!(self, Self::Merl | Self::Wgsl)
    }

    /// All rendered parameters that models and BRDF files read so far declare; names may repeat.
    pub fn all_declared() -> impl Iterator<Item = &'static Parameter> {
        Self::ALL
            .iter()
            .flat_map(|model| model.parameters())
            .chain(std::iter::once_with(written::all_declared).flatten())
    }

    /// Its parameter called `name`.
    pub fn parameter(self, name: &str) -> Option<&'static Parameter> {
        self.parameters().iter().find(|p| p.name == name)
    }

    /// Its stored parameter called `name`, which is never rendered.
    pub fn stored_parameter(self, name: &str) -> Option<&'static Parameter> {
        self.stored_parameters().iter().find(|p| p.name == name)
    }

    /// Its parameter for a quantity, such as `base_color` or `roughness`.
    pub fn parameter_for(self, quantity: &str) -> Option<&'static Parameter> {
        self.parameters().iter().find(|p| p.quantity == quantity)
    }
}

impl ContentKind {
    /// The model that uses such a file.
    pub fn model(self) -> BrdfModel {
        match self {
            Self::Measured => BrdfModel::Merl,
            Self::Written => BrdfModel::Wgsl,
        }
    }
}
