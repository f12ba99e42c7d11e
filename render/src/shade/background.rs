//! Backgrounds: the environment with rotation and intensity, and others.

use crate::{
    light::environment::Illumination,
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::{Quat, Vec3};
use lapidary_core::{color::LUMINANCE, environment::Environment, ground::Ground};
use std::{f32::consts::PI, sync::Arc};

/// Looks up an environment in world space.
pub struct Sky<'a> {
    light: &'a Illumination,
    environment_from_world: Quat,
}

impl<'a> Sky<'a> {
    /// The environment of `light`.
    pub fn new(light: &'a Illumination) -> Self {
        Self { light, environment_from_world: Quat::from_rotation_y(-light.rotation) }
    }

    /// Radiance from a world direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.light.environment.radiance(self.to_environment(direction)) * self.light.intensity
    }

    /// Rotates a world direction into the frame of the map.
    pub fn to_environment(&self, direction: Vec3) -> Vec3 {
        self.environment_from_world * direction
    }

    /// Rotates a direction of the map into world space.
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.environment_from_world.inverse() * direction
    }
}

/// The light behind a picture's surfaces, and the part of it that the ground catches.
pub struct Backdrop {
    /// Radiance of pixels without a surface.
    behind: Behind,
    /// `None` unless the ground catches shadows; it is then an ordinary surface.
    catcher: Option<Catcher>,
}

/// Radiance from all directions.
enum Behind {
    /// An environment, sharp or blurred.
    Map {
        map: Arc<Environment>,
        /// Rotates world directions into the frame of the map.
        environment_from_world: Quat,
        /// Scales its radiance.
        intensity: f32,
    },
    /// Uniform radiance.
    Flat(Vec3),
}

impl Behind {
    const BLACK: Self = Self::Flat(Vec3::ZERO);

    /// The background of a view.
    fn of(view: &View, light: &Illumination, blur: &mut BlurCache) -> Self {
        match view.background {
            Background::Environment => Self::sharp(light),
            Background::Blurred(width) => Self::map(light, blur.blurred(&light.environment, width)),
            Background::Flat(radiance) => Self::Flat(radiance),
            Background::Transparent => Self::BLACK,
        }
    }

    /// The environment of `light`.
    fn sharp(light: &Illumination) -> Self {
        Self::map(light, light.environment.clone())
    }

    /// A map in the place of the environment of `light`.
    fn map(light: &Illumination, map: Arc<Environment>) -> Self {
        let environment_from_world = Sky::new(light).environment_from_world;
        Self::Map { map, environment_from_world, intensity: light.intensity }
    }

    fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Map { map, environment_from_world, intensity } => {
                map.radiance(*environment_from_world * direction) * *intensity
            }
            Self::Flat(radiance) => *radiance,
        }
    }
}

/// A ground that shows the background times its own irradiance over its unoccluded irradiance: a diffuse surface whose reflectance
/// follows from the background. All light that reaches it, and all that is missing, shows on the background.
struct Catcher {
    /// The caught background; white for a picture with an alpha channel, which stores the transmitted share.
    caught: Behind,
    /// What mirrors show behind it: the environment, sharp.
    in_mirrors: Behind,
    /// Reflectance for a radiance of 1 behind the ground.
    per_radiance: Vec3,
    /// Channel weights in the transmitted share.
    weights: Vec3,
}

/// Luminance weights of the channels in which light arrives, with a sum of 1; the other channels give no share.
pub(crate) fn share_weights(per_radiance: Vec3) -> Vec3 {
    let weights = LUMINANCE * per_radiance.map(|reflectance| f32::from(reflectance > 0.0));
    weights / weights.element_sum()
}

/// Reflectance of a ground that catches shadows, for a radiance of 1 behind it; `None` if the view has no such ground, or if the
/// environment gives no light from above: the ground is then an ordinary surface. `shown` says whether the environment shines in
/// this picture; in a partial picture that hides its background, it shines in the other parts.
pub(crate) fn caught_per_radiance(view: &View, environment: &Environment, intensity: f32, shown: bool) -> Option<Vec3> {
    let shines = shown || view.hides_background;
    let catches = shines && view.ground() == Ground::Shadow && view.mode == ViewMode::Shaded;
    let irradiance = catches.then(|| environment.irradiance_from_above() * intensity)?;
    let per_radiance = irradiance.map(|e| if e > 0.0 { PI / e } else { 0.0 });
    (per_radiance.max_element() > 0.0 && per_radiance.is_finite()).then_some(per_radiance)
}

impl Backdrop {
    /// Backdrop of one picture under an environment, which pixels without a surface show if `shown`. View modes other than radiance
    /// have a black background.
    pub fn new(view: &View, light: Option<&Illumination>, shown: bool, blur: &mut BlurCache) -> Self {
        let behind = match (view.background, light) {
            _ if view.mode != ViewMode::Shaded || view.hides_background => Behind::BLACK,
            (Background::Flat(radiance), _) => Behind::Flat(radiance),
            (_, Some(light)) if shown => Behind::of(view, light, blur),
            _ => Behind::BLACK,
        };
        let catcher = light.and_then(|light| {
            let per_radiance = caught_per_radiance(view, &light.environment, light.intensity, shown)?;
            let caught = match view.background {
                Background::Transparent => Behind::Flat(Vec3::ONE),
                _ => Behind::of(view, light, blur),
            };
            let in_mirrors = Behind::sharp(light);
            Some(Catcher { caught, in_mirrors, per_radiance, weights: share_weights(per_radiance) })
        });
        Self { behind, catcher }
    }

    /// Black background; the ground is an ordinary surface.
    pub fn black() -> Self {
        Self { behind: Behind::BLACK, catcher: None }
    }

    /// Radiance from a world direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.behind.radiance(direction)
    }

    /// Whether the ground catches shadows.
    pub(super) fn catches(&self) -> bool {
        self.catcher.is_some()
    }

    /// Share of the light that a ground transmits, from its shown light over a white background.
    pub(super) fn share_let_through(&self, shown: Vec3) -> f32 {
        self.catcher.as_ref().map_or(0.0, |catcher| shown.dot(catcher.weights))
    }

    /// Reflectance of a ground that catches shadows, seen along a world direction; `None` for an ordinary surface.
    pub(super) fn caught(&self, direction: Vec3) -> Option<Vec3> {
        self.catcher.as_ref().map(|catcher| catcher.caught.radiance(direction) * catcher.per_radiance)
    }

    /// [`Self::caught`] as mirrors show it.
    pub(super) fn caught_in_mirrors(&self, direction: Vec3) -> Option<Vec3> {
        self.catcher.as_ref().map(|catcher| catcher.in_mirrors.radiance(direction) * catcher.per_radiance)
    }
}

/// Caches one blurred environment until another environment or width is requested, because blurring takes longer than a frame.
#[derive(Default)]
pub struct BlurCache(Option<Blurred>);

struct Blurred {
    source: Arc<Environment>,
    width: f32,
    map: Arc<Environment>,
}

impl BlurCache {
    /// `source` blurred by a standard deviation of `width` radians.
    pub fn blurred(&mut self, source: &Arc<Environment>, width: f32) -> Arc<Environment> {
        let known = self.0.take().filter(|b| Arc::ptr_eq(&b.source, source) && b.width == width);
        let blur = || Blurred { source: source.clone(), width, map: source.blurred(width).into() };
        self.0.insert(known.unwrap_or_else(blur)).map.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::image::Image;

    #[test]
    fn a_blurred_map_is_kept_until_map_or_width_change() {
        let environment = |value| Arc::new(Environment::new("e".into(), Image::filled([8, 4], value)));
        let (a, b) = (environment(Vec3::ONE), environment(Vec3::splat(2.0)));
        let mut cache = BlurCache::default();
        let first = cache.blurred(&a, 0.2);
        assert!(Arc::ptr_eq(&first, &cache.blurred(&a, 0.2)));
        let wider = cache.blurred(&a, 0.3);
        assert!(!Arc::ptr_eq(&first, &wider));
        let other = cache.blurred(&b, 0.3);
        assert!(!Arc::ptr_eq(&wider, &other) && (other.radiance(Vec3::Z).x - 2.0).abs() < 1e-4);
    }
}
