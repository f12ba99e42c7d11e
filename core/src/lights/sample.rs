//! Radiometry of lights: unoccluded light at a point, by samples.

use super::{Disc, Emission, Light, RectangleShape};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Light that arrives at a point from one direction, unless blocked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction from the point to the light.
    pub direction: Vec3,
    /// Distance to the light in meters; infinite for directional lights.
    pub distance: f32,
    /// Irradiance in W/m² on a surface that faces the light, divided by the density of the sample: the mean over
    /// samples is the irradiance. It includes neither visibility nor the receiver's cosine.
    pub irradiance: Vec3,
    /// Density of the direction per solid angle; infinite for lights without extent.
    pub pdf: f32,
}

/// Hit of a ray on a light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightHit {
    /// Distance along the ray in meters.
    pub distance: f32,
    /// Radiance toward the ray's origin in W/(m² sr).
    pub radiance: Vec3,
    /// Density per solid angle of [`Light::sample`] for this direction.
    pub pdf: f32,
}

impl Light {
    /// The light that arrives at `point`. Lights without extent ignore `u`; rectangles sample their area and directional lights
    /// their disc uniformly by `u` in [0, 1)². `None` if no light arrives: from behind, outside the cone, or switched off.
    pub fn sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        self.sampler().sample(point, u)
    }

    /// A sampler for repeated use.
    pub fn sampler(&self) -> LightSampler<'_> {
        LightSampler { light: self, disc: Disc::of(self), cone: Cone::of(self) }
    }

    /// The intersection of a ray with the light, without the scene; only lights with an extent can be hit.
    pub fn intersect(&self, origin: Vec3, direction: Vec3) -> Option<LightHit> {
        if let Some(disc) = Disc::of(self).filter(|_| self.shines()) {
            let radiance = self.intensity * disc.radiance_of_irradiance();
            let hit = LightHit { distance: f32::INFINITY, radiance, pdf: 1.0 / disc.solid_angle() };
            return disc.contains(direction).then_some(hit);
        }
        let shape = RectangleShape::of(self).filter(|_| self.shines())?;
        let distance = shape.intersect(origin, direction)?;
        let cos = -direction.dot(shape.normal);
        Some(LightHit { distance, radiance: self.intensity, pdf: distance * distance / (shape.area() * cos) })
    }

    /// Upper bound of its power in W, for the choice between lights; directional lights fill a disc of `radius` meters.
    pub fn power_bound(&self, radius: f32) -> f32 {
        let largest = self.intensity.max_element().max(0.0);
        let power = match self.emission {
            Emission::Point => 4.0 * PI * largest,
            Emission::Spot { cone_degrees, .. } => 2.0 * PI * (1.0 - cone_degrees.to_radians().cos()) * largest,
            Emission::Directional { .. } => PI * radius * radius * largest,
            Emission::Rectangle { width, height } => PI * width * height * largest,
        };
        if self.enabled { power } else { 0.0 }
    }

    fn at_position(&self, point: Vec3, factor: f32) -> Option<LightSample> {
        let (direction, distance) =
            (self.position - point).try_normalize().map(|d| (d, self.position.distance(point)))?;
        let irradiance = self.intensity * (factor / (distance * distance));
        Some(LightSample { direction, distance, irradiance, pdf: f32::INFINITY })
    }

    fn on_rectangle(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        let shape = RectangleShape::of(self)?;
        let toward = shape.point(u) - point;
        let (distance, direction) = (toward.length(), toward.try_normalize()?);
        let cos = -direction.dot(shape.normal);
        let solid_angle = shape.area() * cos / (distance * distance);
        (solid_angle > 0.0).then(|| LightSample {
            direction,
            distance,
            irradiance: self.intensity * solid_angle,
            pdf: 1.0 / solid_angle,
        })
    }
}

/// The cone of a spot light.
#[derive(Clone, Copy, Debug)]
struct Cone {
    axis: Vec3,
    /// Cosine of the angle from the axis beyond which it emits nothing.
    edge: f32,
    /// Cosine of the angle within which it emits fully.
    full: f32,
}

impl Cone {
    /// `None` for other lights, and if target and position coincide.
    fn of(light: &Light) -> Option<Self> {
        let Emission::Spot { cone_degrees, penumbra_degrees } = light.emission else { return None };
        let [edge, full] = [cone_degrees, (cone_degrees - penumbra_degrees).max(0.0)].map(|a| a.to_radians().cos());
        Some(Self { axis: light.forward()?, edge, full })
    }

    /// Share of the intensity along `away`, which need not be unit: one on the axis, zero outside the cone, smooth in
    /// the cosine between.
    fn factor(&self, away: Vec3) -> f32 {
        let Some(away) = away.try_normalize() else { return 0.0 };
        let (cos, edge, full) = (self.axis.dot(away), self.edge, self.full);
        if cos < edge {
            return 0.0;
        }
        if cos >= full {
            return 1.0;
        }
        let t = (cos - edge) / (full - edge);
        t * t * (3.0 - 2.0 * t)
    }
}

/// Samples a light, with its [disc](Disc) or cone precomputed.
#[derive(Clone, Copy, Debug)]
pub struct LightSampler<'a> {
    light: &'a Light,
    disc: Option<Disc>,
    cone: Option<Cone>,
}

impl<'a> LightSampler<'a> {
    /// The light.
    pub fn light(&self) -> &'a Light {
        self.light
    }

    /// See [`Light::sample`].
    pub fn sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        let light = self.light;
        if !light.shines() {
            return None;
        }
        let sample = match light.emission {
            Emission::Point => light.at_position(point, 1.0),
            Emission::Spot { .. } => light.at_position(point, self.cone?.factor(point - light.position)),
            Emission::Directional { .. } => self.distant(u),
            Emission::Rectangle { .. } => light.on_rectangle(point, u),
        };
        sample.filter(|s| s.irradiance.max_element() > 0.0 && s.irradiance.is_finite())
    }

    /// The disc of a distant light.
    pub fn disc(&self) -> Option<&Disc> {
        self.disc.as_ref()
    }

    fn distant(&self, u: Vec2) -> Option<LightSample> {
        let (direction, irradiance, pdf) = match self.disc {
            None => (-self.light.forward()?, self.light.intensity, f32::INFINITY),
            Some(disc) => {
                let solid_angle = disc.solid_angle();
                let irradiance = self.light.intensity * (disc.radiance_of_irradiance() * solid_angle);
                (disc.direction(u), irradiance, 1.0 / solid_angle)
            }
        };
        Some(LightSample { direction, distance: f32::INFINITY, irradiance, pdf })
    }
}

#[cfg(test)]
mod tests;
