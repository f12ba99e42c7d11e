//! Direct light of local lights: shadow maps, or rays to suns, then a pass over every pixel for each part of them that is summed.

use super::{
    groups::{LocalLights, ShadowViews, SunRays},
    passes::{PartPass, Passes},
    picture_rays::PictureRays,
    scene::GpuScene,
    shadows::{self, Plan, ShadowMaps, ShadowRoom},
    targets::Target,
};
use crate::{
    device::{
        GpuDevice,
        layout::{LocalLight, ShadowView, Sun, SunUniforms, constants},
        storage, uniform,
    },
    stale::LightPart,
    summed::SummedLights,
};
use bytemuck::Zeroable;
use glam::Vec3;
use lapidary_core::{
    lights::{Disc, Emission, Light, RectangleShape},
    ray::wider,
};

/// Texels of a side of few shadow maps: four of them are all that there may be.
const LARGEST: u32 = 4096;

/// The local lights that shine, and their shadow maps.
pub struct DirectLights {
    /// The first of them are summed by themselves, in [`LightPart::Direct`]; those behind them in [`LightPart::Added`].
    lights: Vec<Light>,
    first: usize,
    radius: f32,
    plan: Plan,
    room: ShadowRoom,
    /// The last remark on lights without shadows.
    remark: Option<String>,
    maps: Option<ShadowMaps>,
}

impl DirectLights {
    /// None yet.
    pub fn new(gpu: &GpuDevice) -> Self {
        Self::within(ShadowRoom {
            layers: gpu.limits.max_texture_array_layers,
            largest: LARGEST.min(gpu.limits.max_texture_dimension_2d),
            suns: constants::MOST_SUNS as u32,
        })
    }

    /// None yet, with some room for shadow maps.
    pub fn within(room: ShadowRoom) -> Self {
        Self {
            lights: Vec::new(),
            first: 0,
            radius: 1.0,
            plan: Plan::new(&[], room, 1.0),
            room,
            remark: None,
            maps: None,
        }
    }

    /// Replaces the lights of a scene of `radius` meters; without lights their memory is freed. Returns a remark on
    /// those without shadows, unless it was returned before.
    pub fn set(&mut self, lights: &[Light], radius: f32) -> Option<String> {
        self.lights = lights.iter().filter(|light| shadows::shines(light)).cloned().collect();
        (self.first, self.radius) = (self.lights.len(), radius);
        if self.lights.is_empty() {
            self.maps = None;
        }
        self.plan = Plan::new(&self.lights, self.room, radius);
        let remark = self.shadowless();
        let before = std::mem::replace(&mut self.remark, remark.clone());
        remark.filter(|_| before != self.remark)
    }

    /// A remark on lights without shadows.
    fn shadowless(&self) -> Option<String> {
        let (suns, most) = (self.lights.iter().filter(|light| is_sun(light)).count(), self.room.suns as usize);
        let of_suns = (suns > most).then(|| {
            let without = suns - most;
            format!("{without} of {suns} directional lights shine without shadows: the strongest {most} cast some; switch some off")
        });
        let all: Vec<String> = self.plan.remark(&self.lights, self.room).into_iter().chain(of_suns).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// Whether there are suns that cast shadows.
    pub fn have_suns(&self) -> bool {
        self.room.suns > 0 && self.lights.iter().any(is_sun)
    }

    /// Which lights of a part are the suns that cast shadows: the strongest.
    fn casting_suns(&self, part: &[LocalLight]) -> Vec<usize> {
        let strength = |i: usize| Vec3::from(part[i].intensity).max_element();
        let is_sun = |i: &usize| part[*i].emission == constants::EMISSION_DIRECTIONAL && strength(*i) > 0.0;
        let mut suns: Vec<usize> = (0..part.len()).filter(is_sun).collect();
        suns.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
        suns.truncate(self.room.suns as usize);
        suns
    }

    /// Puts the lights in the order of the parts that sum them. Returns whether those of the first part have the same
    /// layers as before, of the same size, as far as `before` tells.
    pub fn order(&mut self, summed: &SummedLights, before: Option<&Plan>) -> bool {
        let shining = |lights: &[Light]| -> Vec<Light> {
            lights.iter().filter(|light| shadows::shines(light)).cloned().collect()
        };
        self.lights = shining(&summed.direct);
        self.first = self.lights.len();
        self.lights.extend(shining(&summed.added));
        self.plan = Plan::new(&self.lights, self.room, self.radius);
        before.is_none_or(|before| {
            (before.size, before.grid) == (self.plan.size, self.plan.grid)
                && before.first.get(..self.first) == self.plan.first.get(..self.first)
        })
    }

    /// Whether there are lights in a part.
    pub fn has(&self, part: LightPart) -> bool {
        if part == LightPart::Direct { self.first > 0 } else { self.lights.len() > self.first }
    }

    /// Which light has which shadow maps.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Marks all shadow maps as out of date, after a change of the shader.
    pub fn forget_shadows(&mut self) {
        if let Some(maps) = &mut self.maps {
            maps.forget();
        }
    }

    /// Renders shadow maps that are out of date, with the groups of the frame and the scene. Returns a pass for each part of the
    /// lights. Suns have rays, whose results are in a target; without these, `nothing` takes its place.
    pub fn prepare(
        &mut self,
        gpu: &GpuDevice,
        passes: &Passes,
        (scene, rays, nothing): (&GpuScene, Option<(&PictureRays, &Target)>, &Target),
        shared: [&wgpu::BindGroup; 2],
    ) -> Vec<PartPass> {
        if self.lights.is_empty() {
            return Vec::new();
        }
        let views = self.views(scene);
        // Bindings of no size are not allowed.
        let bound = if views.is_empty() { &[Zeroable::zeroed()][..] } else { &views[..] };
        let shadow_views = &storage(gpu, "shadow views", bytemuck::cast_slice(bound));
        let mut packed = self.packed(scene);
        self.make_room(gpu);
        let Some(maps) = self.maps.as_mut() else { return Vec::new() };
        let group = ShadowViews { shadow_views }.bind(gpu);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for layer in maps.stale(&views) {
            let groups = [shared[0], shared[1], &group];
            let view = (layer, views[layer as usize]);
            maps.encode(&mut encoder, &passes.shadow, groups, 3 * scene.triangle_count, view);
        }
        gpu.queue.submit([encoder.finish()]);
        let (direct, added) = packed.split_at_mut(self.first);
        let parts = [(LightPart::Direct, direct, 0), (LightPart::Added, added, self.first)];
        let read = (shadow_views, rays, nothing);
        let pass =
            |(part, lights, first): (_, &mut [LocalLight], _)| self.pass(gpu, passes, (part, lights, first), read);
        parts.into_iter().filter(|(_, lights, _)| !lights.is_empty()).filter_map(pass).collect()
    }

    /// The pass of a part of the lights, which begins with the light `first`. Its suns get their numbers.
    fn pass(
        &self,
        gpu: &GpuDevice,
        passes: &Passes,
        (part, lights, first): (LightPart, &mut [LocalLight], usize),
        (shadow_views, rays, nothing): (&wgpu::Buffer, Option<(&PictureRays, &Target)>, &Target),
    ) -> Option<PartPass> {
        let casting = rays.map_or(Vec::new(), |_| self.casting_suns(lights));
        for (number, &sun) in (0..).zip(&casting) {
            lights[sun].first_view = number;
        }
        let suns = casting.iter().map(|&sun| &self.lights[first + sun]);
        let suns = rays.filter(|_| !casting.is_empty()).map(|(rays, _)| sun_rays(gpu, suns, rays));
        let local_lights = &storage(gpu, "local lights", bytemuck::cast_slice(lights));
        let suns_seen = &rays.map_or(nothing, |(_, seen)| seen).view;
        let shadow_maps = &self.maps.as_ref()?.array;
        let light = LocalLights { shadow_views, local_lights, shadow_maps, suns_seen }.bind(gpu);
        Some(PartPass { part, pass: passes.direct.clone(), light, suns: suns.map(|rays| (passes.suns.clone(), rays)) })
    }

    /// Whether there are textures of lights.
    #[cfg(test)]
    pub fn takes_room(&self) -> bool {
        self.maps.is_some()
    }

    fn views(&self, scene: &GpuScene) -> Vec<ShadowView> {
        let Plan { size, grid, .. } = self.plan;
        let settings = shadows::ShadowViewSettings { near: scene.near, size, grid };
        let casting = self.lights.iter().zip(&self.plan.first).filter(|(_, first)| **first != constants::NO_SHADOW);
        casting.flat_map(|(light, _)| shadows::views(light, &settings)).collect()
    }

    /// Lights as the shader reads them, suns as yet without shadows.
    fn packed(&self, scene: &GpuScene) -> Vec<LocalLight> {
        // It lies under the ground.
        let is_below = |light: &Light| scene.ground.is_some() && light.comes_from_below();
        let shining = |light: &Light| if is_below(light) { Vec3::ZERO } else { light.intensity };
        let packed = |(light, &first): (&Light, &u32)| {
            let first = if is_sun(light) { constants::NO_SHADOW } else { first };
            LocalLight { intensity: shining(light).to_array(), ..packed(light, first, self.plan.grid) }
        };
        self.lights.iter().zip(&self.plan.first).map(packed).collect()
    }

    fn make_room(&mut self, gpu: &GpuDevice) {
        let Plan { size, layers, .. } = self.plan;
        if self.maps.as_ref().is_none_or(|maps| !maps.holds(size, layers)) {
            // Freed first: two sets may not fit.
            self.maps = None;
            self.maps = Some(ShadowMaps::new(gpu, size, shadows::capacity(layers, size, self.room)));
        }
    }
}

/// Suns that cast shadows, bound with what their rays meet.
fn sun_rays<'l>(gpu: &GpuDevice, casting: impl Iterator<Item = &'l Light>, rays: &PictureRays) -> wgpu::BindGroup {
    let mut suns = SunUniforms { largest_offset: rays.largest_offset, ..Zeroable::zeroed() };
    for (to, sun) in suns.suns.iter_mut().zip(casting) {
        *to = packed_sun(sun);
        suns.count += 1;
    }
    let suns = &uniform(gpu, "suns", bytemuck::bytes_of(&suns));
    let PictureRays { hierarchy, leaf_triangles, .. } = rays;
    SunRays { suns, nodes: &hierarchy.nodes, corners: &hierarchy.corners, leaf_triangles }.bind(gpu)
}

/// Whether a light has rays in place of shadow maps.
fn is_sun(light: &Light) -> bool {
    matches!(light.emission, Emission::Directional { .. })
}

/// A sun as the rays to it need it.
fn packed_sun(light: &Light) -> Sun {
    let axis = -light.forward().unwrap_or(Vec3::NEG_Y);
    let (right, up) = axis.any_orthonormal_pair();
    // Parallel light is a disc without an extent.
    let disc = Disc::of(light).unwrap_or(Disc { axis, right, up, height: 0.0 });
    let sine = wider(disc.sine());
    Sun {
        axis: disc.axis.to_array(),
        height: disc.height,
        right: disc.right.to_array(),
        sine,
        up: disc.up.to_array(),
        tangent: sine / (1.0 - sine * sine).max(1e-6).sqrt(),
    }
}

/// A light as the shader reads it.
fn packed(light: &Light, first_view: u32, grid: u32) -> LocalLight {
    let cos = |degrees: f32| degrees.to_radians().cos();
    let (cos_edge, cos_full) = match light.emission {
        Emission::Spot { cone_degrees, penumbra_degrees } => {
            (cos(cone_degrees), cos((cone_degrees - penumbra_degrees).max(0.0)))
        }
        _ => (0.0, 0.0),
    };
    let (shape, disc) = (RectangleShape::of(light), Disc::of(light));
    let across = shape.map(|s| [s.half_width, s.half_height]).or(disc.map(|d| [d.right, d.up])).unwrap_or_default();
    LocalLight {
        position: light.position.to_array(),
        emission: match light.emission {
            Emission::Point => constants::EMISSION_POINT,
            Emission::Spot { .. } => constants::EMISSION_SPOT,
            Emission::Directional { .. } => constants::EMISSION_DIRECTIONAL,
            Emission::Rectangle { .. } => constants::EMISSION_RECTANGLE,
        },
        forward: light.forward().unwrap_or_default().to_array(),
        first_view,
        intensity: light.intensity.to_array(),
        views_per_point: shadows::views_per_point(light),
        half_width: across[0].to_array(),
        cos_edge,
        half_height: across[1].to_array(),
        cos_full,
        area: shape.map(|s| s.area()).or(disc.map(|d| d.height)).unwrap_or_default(),
        grid,
        padding: [0; 2],
    }
}
