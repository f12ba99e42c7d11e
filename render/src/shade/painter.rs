//! The value of a surface point in each view mode: radiance or an underlying quantity.

use crate::{
    light::{
        bounce::{MeshlessLight, PatchLight, meshless::functions::level_color},
        environment::SceneLighting,
        implicit::{PosedLight, Sides},
        solver::BounceLight,
    },
    sampling::BrdfSampling,
    shade::{
        direct::{DirectLights, DirectShader, EightPoints, LightsSeen},
        merge::{Shader, SharpLight, Work},
        mirror::rays::{RayLobes, brightest_by_rays},
        mirrors::{Mirrors, cone::CameraCones},
        node_field::SourceField,
        seen_scene::SeenScene,
        surface::SurfacePoint,
    },
    stale::LightPart,
    view::View,
    view_mode::{BasisView, ViewMode, visibility_cuts},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    color::{luminance, signed_light},
    dataset::Dataset,
    meshless::{FunctionPlace, irradiance},
    ray::Blockers,
};
use std::{array::from_fn, f32::consts::FRAC_1_PI};

/// Gray of a surface facing the eye in the views of the meshless basis, to show its shape.
pub(crate) const BASIS_GREY: f32 = 0.4;

/// The light of a picture.
#[derive(Clone, Copy, Default)]
pub(crate) struct PictureLight<'a> {
    /// Direct light of the environment.
    pub environment: Option<&'a SceneLighting>,
    /// Whether emitted light of surfaces is shown.
    pub emission: bool,
    /// Bounced light as baked.
    pub bounce: Option<&'a BounceLight>,
    /// Changes of the environment's light by posed objects.
    pub posed: Option<&'a PosedLight>,
    /// Changes of bounced light by posed objects, if shown.
    pub posed_bounce: Option<&'a PosedLight>,
    /// Local lights whose direct light is shown.
    pub local: Option<DirectLights<'a>>,
    /// Local lights that are summed separately; [`Self::local`] has the others.
    pub added: Option<DirectLights<'a>>,
    /// The scene that mirrors show, if they do.
    pub mirrored: Option<SeenScene<'a>>,
}

impl PictureLight<'_> {
    /// Parts of a picture in a mode. The first part always exists: it also holds quantities without light.
    pub fn parts(&self, mode: ViewMode) -> [bool; LightPart::COUNT] {
        let shaded = mode == ViewMode::Shaded;
        LightPart::ALL.map(|part| match part {
            LightPart::Environment => true,
            LightPart::Bounce => match self.bounce {
                Some(BounceLight::Functions(_)) => shaded || mode.is_of_basis(),
                Some(BounceLight::Sources(_)) => shaded || mode == ViewMode::Gloss,
                Some(_) => shaded,
                None => shaded && self.posed_bounce.is_some(),
            },
            LightPart::Mirrors => shaded && self.mirrored.is_some(),
            LightPart::Direct => shaded && self.local.is_some(),
            LightPart::Added => shaded && self.added.is_some(),
        })
    }
}

/// Bounced light at surface points.
enum Bounce<'a> {
    Vertices(&'a Sides),
    Sources(Shader<'a, SourceField<'a>>),
    Functions(&'a MeshlessLight),
    Patches(&'a PatchLight),
}

impl<'a> Bounce<'a> {
    /// `None` if the dataset lacks the cuts that gather this light.
    fn new(light: &'a BounceLight, dataset: &'a Dataset, sampling: BrdfSampling) -> Option<Self> {
        Some(match light {
            BounceLight::Vertices(sides) => Self::Vertices(sides),
            BounceLight::Sources(lighting) => {
                let cuts = &dataset.indirect.as_ref()?.cuts;
                Self::Sources(Shader::new(SourceField::new(lighting), cuts, sampling))
            }
            BounceLight::Functions(light) => Self::Functions(light),
            BounceLight::Patches(light) => Self::Patches(light),
        })
    }

    /// Radiance toward the eye. Vertices and functions treat the surface as diffuse with an albedo.
    fn reflected(&mut self, point: &SurfacePoint, sharp: SharpLight) -> Vec3 {
        let received = match self {
            Self::Sources(shader) => {
                shader.sharp = sharp;
                return shader.shade(point);
            }
            Self::Patches(light) => return light.reflected(point) * rough_share(point, sharp),
            Self::Vertices(sides) => sides.at(point.vertices, point.weights, point.from_behind),
            Self::Functions(light) => {
                let Some(place) = place(light, point) else { return Vec3::ZERO };
                let received = irradiance(&light.at(&place, point.from_behind), point.world_from_local.z_axis);
                if let Some(reflectance) = light.reflectance(&place, point) {
                    return reflectance * rough_share(point, sharp) * received * FRAC_1_PI;
                }
                received
            }
        };
        albedo(point, sharp) * received * FRAC_1_PI
    }
}

/// Albedo of a point, without the part that rays along sharp lobes give.
fn albedo(point: &SurfacePoint, sharp: SharpLight) -> Vec3 {
    let albedo = point.brdf.as_brdf().albedo();
    let mirrored = sharp.lobes(point).map(|lobes| lobes.albedo(point));
    (albedo - mirrored.unwrap_or_default()).max(Vec3::ZERO)
}

/// The same as a share of the whole albedo.
fn rough_share(point: &SurfacePoint, sharp: SharpLight) -> Vec3 {
    match sharp {
        SharpLight::Map => Vec3::ONE,
        SharpLight::Rays { .. } => albedo(point, sharp) / point.brdf.as_brdf().albedo().max(Vec3::splat(1e-6)),
    }
}

/// A surface point among the functions of a light.
fn place(light: &MeshlessLight, point: &SurfacePoint) -> Option<FunctionPlace> {
    let shown = FunctionPlace::new(point.position, point.face_normal);
    light.place(shown, point.vertices, point.barycentric, point.from_behind)
}

/// Known visibility of each part's lights at a point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SeenOfParts {
    local: LightsSeen,
    added: LightsSeen,
}

/// Computes values of surface points; keeps its buffers between them.
pub(crate) struct Painter<'a> {
    mode: ViewMode,
    basis: BasisView,
    dataset: &'a Dataset,
    /// `None` without an environment: values that depend on it are black.
    environment: Option<Shader<'a, &'a SceneLighting>>,
    emission: bool,
    bounce: Option<Bounce<'a>>,
    posed: Option<&'a PosedLight>,
    posed_bounce: Option<&'a PosedLight>,
    local: Option<DirectShader<'a>>,
    added: Option<DirectShader<'a>>,
    mirrors: Option<Mirrors<'a>>,
    /// Where the light of the current point's sharp lobes comes from.
    sharp: SharpLight,
    /// Blockers of the last point's rays, for each local light and each added one; and of what mirrors show.
    blockers: [[Vec<Blockers>; 2]; 2],
    /// Work not yet taken by [`Self::take_work`].
    shown: Work,
}

impl<'a> Painter<'a> {
    pub fn new(view: &View, dataset: &'a Dataset, light: PictureLight<'a>, sampling: BrdfSampling) -> Self {
        let environment = light.environment.map(|lighting| Shader::new(lighting, &dataset.cuts, sampling));
        let bounce = light.bounce.and_then(|bounce| Bounce::new(bounce, dataset, sampling));
        let map = light.environment.and_then(|lighting| lighting.lights.mirrored.as_ref());
        // Light samples alone have no light for what is sharp.
        let has_map = map.is_some() || light.environment.is_none();
        let mirrors = light.mirrored.filter(|_| view.mode == ViewMode::Shaded && has_map);
        let leaf_solid_angle = dataset.tree.leaf_solid_angle();
        let sources = match light.bounce {
            Some(BounceLight::Sources(lighting)) => Some(&**lighting),
            _ => None,
        };
        let brightest = brightest_by_rays(sources);
        let mirrors = mirrors.map(|scene| {
            let cones = CameraCones::of(view);
            Mirrors { scene, map, leaf_solid_angle, brightest, cones }
        });
        Self {
            mode: view.mode,
            basis: view.basis,
            dataset,
            environment,
            emission: light.emission,
            bounce,
            posed: light.posed,
            posed_bounce: light.posed_bounce,
            local: light.local.map(|lights| lights.shader()),
            added: light.added.map(|lights| lights.shader()),
            mirrors,
            sharp: mirrors.map_or(SharpLight::Map, |mirrors| mirrors.sharp()),
            blockers: Default::default(),
            shown: Work::default(),
        }
    }

    /// One part of a point's light as scene-linear radiance. The first part also holds the quantities of other modes: an albedo, a
    /// normal from 0 to 1, a roughness, or a count. `shift` places samples of lights with an extent, see
    /// [`crate::shade::direct::pixel_shift`], and `ray_shift` for mirrors; `seen` comes from [`Self::lights_seen`].
    pub fn part(&mut self, part: LightPart, point: &SurfacePoint, shift: Vec2, seen: SeenOfParts) -> Vec3 {
        match part {
            LightPart::Environment => self.mode_value(point),
            LightPart::Bounce if self.mode.is_of_basis() => self.basis_value(point),
            LightPart::Bounce if self.mode == ViewMode::Gloss => self.gloss_value(point),
            LightPart::Bounce => self.bounced(point),
            LightPart::Mirrors => self.mirrored(point, shift),
            LightPart::Direct => direct(&self.local, point, shift, seen.local, &mut self.blockers[0][0]),
            LightPart::Added => direct(&self.added, point, shift, seen.added, &mut self.blockers[0][1]),
        }
    }

    /// Number of points to process together: eight if [`Self::lights_seen`] gives results, else one, which stays in the cache.
    pub fn together(&self) -> usize {
        let may_know = |lights: &Option<DirectShader>| lights.as_ref().is_some_and(DirectShader::may_know);
        if may_know(&self.local) || may_know(&self.added) { 8 } else { 1 }
    }

    /// Known visibility at up to eight points, for the lights of each part that they lack; faster the closer the points are.
    pub fn lights_seen(
        &self,
        points: &EightPoints,
        lacks: impl Fn(usize) -> [bool; LightPart::COUNT],
    ) -> [SeenOfParts; 8] {
        let seen = |lights: &Option<DirectShader>, part: LightPart| {
            let lacking = |i: usize| points[i].filter(|_| lacks(i)[part as usize]);
            lights.as_ref().map(|lights| lights.lights_seen(&from_fn(lacking))).unwrap_or_default()
        };
        let (local, added) = (seen(&self.local, LightPart::Direct), seen(&self.added, LightPart::Added));
        from_fn(|i| SeenOfParts { local: local[i], added: added[i] })
    }

    fn mode_value(&mut self, point: &SurfacePoint) -> Vec3 {
        match self.mode {
            ViewMode::Shaded => self.reflected(point) + self.emitted(point),
            ViewMode::Normals => 0.5 * point.world_from_local.z_axis + 0.5,
            ViewMode::Albedo => point.base_color,
            ViewMode::Roughness => Vec3::splat(point.roughness),
            ViewMode::VisibilityCut => Vec3::splat(self.visibility_nodes(point)),
            ViewMode::MergedCut => Vec3::splat(self.work_at(point).merged_nodes as f32),
            ViewMode::BrdfEvaluations => Vec3::splat(self.work_at(point).brdf_evaluations as f32),
            // These modes belong to bounced light.
            ViewMode::BasisLevel | ViewMode::BasisFunction | ViewMode::BasisCoefficients | ViewMode::Gloss => {
                Vec3::ZERO
            }
        }
    }

    /// What sharp lobes at a point show along a ray, which `shift` chooses.
    fn mirrored(&mut self, point: &SurfacePoint, shift: Vec2) -> Vec3 {
        let Some(mirrors) = self.mirrors else { return Vec3::ZERO };
        mirrors.shown(point, shift, &mut |point, sharp, shift| self.all_light(point, sharp, shift))
    }

    /// Width of the widest sharp lobe of a point; 0 for none.
    pub fn width_of_mirror(&self, point: &SurfacePoint) -> f32 {
        self.mirrors
            .and_then(|mirrors| RayLobes::at(point, mirrors.leaf_solid_angle))
            .map_or(0.0, |lobes| lobes.width())
    }

    /// See [`Mirrors::over_ground`].
    pub fn over_ground(&mut self, point: &SurfacePoint, shift: Vec2) -> [Vec3; 2] {
        let Some(mirrors) = self.mirrors else { return [Vec3::ZERO; 2] };
        mirrors.over_ground(point, shift, &mut |point, sharp, shift| self.all_light(point, sharp, shift))
    }

    /// Light of all kinds from a point, but what mirrors show there.
    fn all_light(&mut self, point: &SurfacePoint, sharp: SharpLight, shift: Vec2) -> Vec3 {
        let before = std::mem::replace(&mut self.sharp, sharp);
        let around = self.reflected(point) + self.emitted(point) + self.bounced(point);
        self.sharp = before;
        let ([local, added], point) = (&mut self.blockers[1], point.within_cone());
        let local = direct(&self.local, &point, shift, LightsSeen::default(), local);
        around + local + direct(&self.added, &point, shift, LightsSeen::default(), added)
    }

    /// Direct light of the environment.
    fn reflected(&mut self, point: &SurfacePoint) -> Vec3 {
        let sharp = self.sharp;
        let as_baked = self.environment.as_mut().map(|shader| {
            shader.sharp = sharp;
            shader.shade(point)
        });
        let as_baked = as_baked.unwrap_or_default();
        let Some(posed) = self.posed.filter(|_| self.environment.is_some()) else { return as_baked };
        let at = |sides: &Sides| sides.at(point.vertices, point.weights, point.from_behind);
        let albedo = albedo(point, sharp.of_environment());
        as_baked * (1.0 + at(&posed.growth)) + albedo * at(&posed.uncovered) * FRAC_1_PI
    }

    fn emitted(&self, point: &SurfacePoint) -> Vec3 {
        if self.emission { point.emission } else { Vec3::ZERO }
    }

    /// Work since the last call.
    pub fn take_work(&mut self) -> Work {
        self.take_shading() + std::mem::take(&mut self.shown)
    }

    fn take_shading(&mut self) -> Work {
        let environment = self.environment.as_mut().map(|shader| std::mem::take(&mut shader.work));
        let sources = match &mut self.bounce {
            Some(Bounce::Sources(shader)) => std::mem::take(&mut shader.work),
            _ => Work::default(),
        };
        environment.unwrap_or_default() + sources
    }

    /// Bounced light: as baked, plus its change by posed objects.
    fn bounced(&mut self, point: &SurfacePoint) -> Vec3 {
        let Some(posed) = self.posed_bounce else { return self.bounced_as_baked(point) };
        let has_moved = posed.is_moved[point.vertices[0] as usize];
        let as_baked = if has_moved { Vec3::ZERO } else { self.bounced_as_baked(point) };
        let more = posed.bounce.at(point.vertices, point.weights, point.from_behind);
        (as_baked + albedo(point, self.sharp) * more * FRAC_1_PI).max(Vec3::ZERO)
    }

    fn bounced_as_baked(&mut self, point: &SurfacePoint) -> Vec3 {
        let sharp = self.sharp;
        self.bounce.as_mut().map(|bounce| bounce.reflected(point, sharp)).unwrap_or_default()
    }

    /// Value in the views of the meshless basis. Twin of `basis_value` in `shaders/meshless_pass.wgsl`.
    fn basis_value(&self, point: &SurfacePoint) -> Vec3 {
        let Some(Bounce::Functions(light)) = self.bounce else { return Vec3::ZERO };
        let gray = Vec3::splat(BASIS_GREY * point.wo.z);
        let Some(place) = place(light, point) else {
            return if self.mode == ViewMode::BasisLevel { Vec3::ZERO } else { gray };
        };
        match self.mode {
            ViewMode::BasisLevel => light.level_part(self.basis.level, &place, point.world_from_local.z_axis),
            ViewMode::BasisFunction => gray.lerp(Vec3::X, light.function_value(self.basis.function, &place)),
            _ => match light.marked_level(&place) {
                Some(level) => level_color(level, light.functions().levels()),
                None => gray,
            },
        }
    }

    /// What sources send by direction, less what diffuse ones would.
    fn gloss_value(&mut self, point: &SurfacePoint) -> Vec3 {
        let Some(Bounce::Sources(shader)) = &mut self.bounce else { return Vec3::ZERO };
        let by_direction = shader.shade(point);
        let field = shader.field;
        shader.field = field.as_diffuse();
        let as_diffuse = shader.shade(point);
        shader.field = field;
        signed_light(luminance(by_direction - as_diffuse))
    }

    fn work_at(&mut self, point: &SurfacePoint) -> Work {
        self.reflected(point);
        self.bounced(point);
        let work = self.take_shading();
        self.shown += work;
        work
    }

    /// Sizes of the vertices' cuts, interpolated like their visibility.
    fn visibility_nodes(&self, point: &SurfacePoint) -> f32 {
        let (height, cuts) = visibility_cuts(self.dataset);
        let nodes = |vertex: u32| cuts.cut(height, vertex).len() as f32;
        point.vertices.iter().zip(point.weights).map(|(&vertex, weight)| weight * nodes(vertex)).sum()
    }
}

fn direct(
    lights: &Option<DirectShader>,
    point: &SurfacePoint,
    shift: Vec2,
    seen: LightsSeen,
    blockers: &mut Vec<Blockers>,
) -> Vec3 {
    lights.as_ref().map_or(Vec3::ZERO, |lights| lights.reflected_beside(point, shift, seen, blockers))
}
