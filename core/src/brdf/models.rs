//! The list of all models. A new model is a file beside this one, a file with the name of its key in `shaders/brdf/`, and
//! its line here.

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
        /// Which reflectance model a material uses.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum BrdfModel {
            $(#[doc = concat!("See [`", stringify!($variant), "`].")] $(#[$attribute])* #[serde(rename = $key)] $variant,)*
        }

        impl BrdfModel {
            /// All of them, in the order of lists.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Its name in files and on the command line.
            pub const fn key(self) -> &'static str {
                match self { $(Self::$variant => $key,)* }
            }

            /// Its name for people.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => <$ty as Model>::LABEL,)* }
            }

            /// What it is good for.
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$variant => <$ty as Model>::SUMMARY,)* }
            }

            /// The parameters of its reflectance.
            pub const fn own_parameters(self) -> &'static [Parameter] {
                match self { $(Self::$variant => <$ty as Model>::PARAMETERS,)* }
            }

            /// What its materials keep for other programs and nothing renders.
            pub const fn stored_parameters(self) -> &'static [Parameter] {
                match self { $(Self::$variant => <$ty as Model>::STORED,)* }
            }

            /// The parameters of its materials: its own, and then those of [`SurfaceParameters`].
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

            /// Its text in the language of shaders: what `shaders/brdf.wgsl` says that a model has.
            pub const fn wgsl(self) -> &'static str {
                match self { $(Self::$variant => include_str!(concat!("../../../shaders/brdf/", $key, ".wgsl")),)* }
            }

            /// Name of its type, here and in shaders.
            pub const fn type_name(self) -> &'static str {
                match self { $(Self::$variant => stringify!($variant),)* }
            }
        }

        /// Any of the models, by value.
        #[derive(Clone, Debug)]
        pub enum SurfaceBrdf {
            $(#[doc = concat!("See [`", stringify!($variant), "`].")] $variant($ty),)*
        }

        impl SurfaceBrdf {
            /// The model with values of its parameters, in the order of its list and in their ranges, and with its file.
            #[inline]
            pub fn new(model: BrdfModel, values: &Values, file: Option<FilePart>) -> Self {
                match model { $(BrdfModel::$variant => Self::$variant(<$ty as Model>::of_file(values, file)),)* }
            }

            /// The model behind the variant.
            #[inline(always)]
            pub fn as_brdf(&self) -> &dyn Brdf {
                match self { $(Self::$variant(brdf) => brdf,)* }
            }

            /// Visits the model as what it is, so that the visitor is compiled for each.
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
    /// [`Brdf::brdf_cos_x8`] on a surface whose slopes widen its lobes, see [`SpreadX8::slopes`].
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

/// Eight lights that any model reflects.
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

/// What is done with a model of a type that is known.
pub trait BrdfVisitor {
    /// Does it.
    fn visit(self, brdf: &impl Brdf);
}

impl BrdfModel {
    /// What models, or else files of BRDFs that were read, declare under a name, if any does, rendered or stored.
    pub fn declared(name: &str) -> Option<&'static Parameter> {
        Self::declared_by_models(name).or_else(|| written::all_declared().into_iter().find(|p| p.name == name))
    }

    /// What models declare under a name, whatever files were read, rendered or stored.
    pub fn declared_by_models(name: &str) -> Option<&'static Parameter> {
        let of = |model: &Self| model.parameter(name).or_else(|| model.stored_parameter(name));
        Self::ALL.iter().find_map(of)
    }

    /// Whether its materials have a file.
    pub fn has_file(self) -> bool {
        matches!(self, Self::Merl | Self::Wgsl)
    }

    /// All parameters that models and files of BRDFs that were read declare and that are rendered; a name may come more than
    /// once.
    pub fn all_declared() -> impl Iterator<Item = &'static Parameter> {
        Self::ALL
            .iter()
            .flat_map(|model| model.parameters())
            .chain(std::iter::once_with(written::all_declared).flatten())
    }

    /// Its parameter of a name.
    pub fn parameter(self, name: &str) -> Option<&'static Parameter> {
        self.parameters().iter().find(|p| p.name == name)
    }

    /// What it stores under a name and does not render.
    pub fn stored_parameter(self, name: &str) -> Option<&'static Parameter> {
        self.stored_parameters().iter().find(|p| p.name == name)
    }

    /// Its parameter for a quantity, such as `base_color` or `roughness`.
    pub fn parameter_for(self, quantity: &str) -> Option<&'static Parameter> {
        self.parameters().iter().find(|p| p.quantity == quantity)
    }
}

impl ContentKind {
    /// The model that has such a file.
    pub fn model(self) -> BrdfModel {
        match self {
            Self::Measured => BrdfModel::Merl,
            Self::Written => BrdfModel::Wgsl,
        }
    }
}
