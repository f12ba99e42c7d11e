//! Ideal diffuse reflection: `f = albedo / π`.

use super::prelude::*;

parameters! {
    /// Parameters of [`Lambert`].
    pub struct LambertParameters {
        base_color: Vec3 = shared::BASE_COLOR,
    }
}

/// Ideal diffuse reflection.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    albedo: Vec3,
}

impl Lambert {
    /// `albedo` is linear, 0 to 1.
    pub fn new(albedo: Vec3) -> Self {
        Self { albedo }
    }
}

impl Model for Lambert {
    const LABEL: &'static str = "Lambert";
    const SUMMARY: &'static str = "Ideal diffuse reflection: chalk, plaster.";
    const PARAMETERS: &'static [Parameter] = LambertParameters::LIST;

    fn from_values(values: &Values) -> Self {
        Self::new(LambertParameters::new(values).base_color)
    }
}

impl Brdf for Lambert {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        Vec3x8::splat(self.albedo * FRAC_1_PI) * (lights.cosine * is_seen(wo))
    }

    fn lobes(&self) -> Lobes {
        [NO_LOBE; 3]
    }

    fn albedo(&self) -> Vec3 {
        self.albedo
    }

    fn sample(&self, _wo: Vec3, u: Vec3) -> Vec3 {
        cosine_direction(u.x, u.y)
    }

    fn pdf(&self, wi: Vec3, _wo: Vec3) -> f32 {
        wi.z.max(0.0) * FRAC_1_PI
    }
}
