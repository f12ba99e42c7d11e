//! A measured BRDF in the format of the MERL database, tinted. See [`Measured`].

use super::prelude::*;
use super::{FilePart, Measured};
use std::sync::Arc;

/// Albedo of a material whose file is missing.
pub const MISSING: Vec3 = Vec3::new(0.8, 0.0, 0.8);

parameters! {
    /// Parameters of [`Merl`].
    pub struct MerlParameters {
        tint: Vec3 = Parameter::color(
            "Tint",
            [1.0; 3],
            "Multiplies the measured reflectance. The hex is sRGB; the value is kept linear, 0 to 1.",
        ),
    }
}

/// A measured BRDF; diffuse magenta if its file is missing.
#[derive(Clone, Debug)]
pub struct Merl {
    table: Option<Arc<Measured>>,
    tint: Vec3,
}

impl Merl {
    /// `tint` must be within its range.
    pub fn new(table: Option<Arc<Measured>>, tint: Vec3) -> Self {
        Self { table, tint }
    }
}

impl Model for Merl {
    const LABEL: &'static str = "MERL";
    const SUMMARY: &'static str =
        "A measured material from a .binary file of the MERL database. Only its tint can be changed.";
    const PARAMETERS: &'static [Parameter] = MerlParameters::LIST;

    fn from_values(values: &Values) -> Self {
        Self::new(None, MerlParameters::new(values).tint)
    }

    fn of_file(values: &Values, file: Option<FilePart>) -> Self {
        let table = file.and_then(|file| file.content.measured()).cloned();
        Self { table, ..Self::from_values(values) }
    }
}

impl Brdf for Merl {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let Some(table) = &self.table else {
            return Vec3x8::splat(MISSING * FRAC_1_PI) * (lights.cosine * is_seen(wo));
        };
        let [x, y, z] = [lights.wi.x, lights.wi.y, lights.wi.z].map(L::to_array);
        let (inv_kappa, cosine) = (lights.spread.inv_kappa.to_array(), lights.cosine.to_array());
        let [xx, xy, yy] = [lights.spread.slopes[0], lights.spread.slopes[1], lights.spread.slopes[2]].map(L::to_array);
        let mut values = [Vec3::ZERO; 8];
        for i in 0..8 {
            if cosine[i] > 0.0 && wo.z > 0.0 {
                // A light centered below the horizon may be partly above it.
                let wi = Vec3::new(x[i], y[i], z[i].max(0.0)).normalize_or(Vec3::Z);
                values[i] = table.value(wi, wo, inv_kappa[i], [xx[i], xy[i], yy[i]]) * self.tint * cosine[i];
            }
        }
        Vec3x8::from_array(values)
    }

    fn lobes(&self) -> Lobes {
        self.table.as_ref().map_or([NO_LOBE; 3], |table| table.lobe().lobes())
    }

    fn albedo(&self) -> Vec3 {
        self.table.as_ref().map_or(MISSING, |table| table.lobe().albedo_at(1.0) * self.tint)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        match &self.table {
            Some(table) => table.lobe().sample(wo, u),
            None => cosine_direction(u.x, u.y),
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        match &self.table {
            Some(table) => table.lobe().pdf(wi, wo),
            None => wi.z.max(0.0) * FRAC_1_PI,
        }
    }
}
