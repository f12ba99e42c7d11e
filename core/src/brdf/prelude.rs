//! Common imports of the models.

pub(super) use super::{
    Brdf, LightsX8, Lobes, Model, NO_LOBE, Parameter, Values,
    albedo::{Albedo, multiple_reflectance},
    diffuse_base::DiffuseBase,
    gaussian_lobe::{GaussianLobe, shadowing},
    ggx_lobe::GgxLobe,
    microfacet::{HalfVectorLobe, HalfVectors, Interface, Schlick, glossy_share, is_seen, widths},
    parameter::parameters,
    phong_lobe::PhongLobe,
    shared,
};
pub(super) use crate::{
    color::luminance,
    simd::{Lanes, Vec3x8},
    sphere::cosine_direction,
};
pub(super) use glam::Vec3;
pub(super) use std::f32::consts::FRAC_1_PI;
pub(super) use wide::f32x8;
