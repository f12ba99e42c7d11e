//! What pictures show: a scene, and what lights it.

use super::{bounce::GpuBounce, groups::Groups, picture::Picture, pipelines::Pipelines};
use crate::{
    appearance::Assigned,
    baked::Baked,
    device::{
        GpuDevice, SharedDevice,
        layout::{
            FrameUniforms,
            constants::{
                FIELD_ENVIRONMENT, FIELD_NONE, FIELD_SOURCES, MIRRORS_HAVE_RAYS, MIRRORS_READ_MAP, NO_MIRRORS,
            },
        },
    },
    error::BackendError,
    gpu::{
        direct::DirectLights,
        frame::{ShownLight, frame},
        groups::Light,
        light::{GpuLight, GpuMap, GpuTreeLight, NodeBuffers},
        materials::GpuMaterials,
        passes::{MergeVariant, PartPass},
        picture_rays::PictureRays,
        scene::{GpuCuts, GpuScene},
        shadows::Plan,
        targets::Targets,
        turned::GpuSamples,
    },
    light::{
        environment::{EnvironmentLight, Illumination, TurnedMap},
        local::LocalLighting,
    },
    sampling::BrdfSampling,
    shade::{
        background::caught_per_radiance,
        mirror::{Mirror, rays::brightest_by_rays},
        mirrors::DEEPEST,
    },
    stale::{LightPart, Marks},
    summed::{DirectStep, SummedLights},
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::Vec3;
use lapidary_core::{environment::Environment, image::Image, opacity::Opacities};
use std::sync::Arc;

/// A scene and its light, as far as they are set and uploaded.
pub struct Shown {
    pub scene: Option<Loaded>,
    /// What the surfaces let through.
    pub opacities: Opacities,
    pub environment: ShownEnvironment,
    pub local: LocalLighting,
    pub bounce: GpuBounce,
    pub local_lights: DirectLights,
}

/// A scene and how it looks.
pub struct Loaded {
    pub scene: GpuScene,
    /// The patch of each vertex, or a single one where nothing asks for them.
    pub patches: wgpu::Buffer,
    pub materials: GpuMaterials,
    /// The materials of its triangles.
    pub assigned: Assigned,
    /// Materials that mirror, see [`crate::shade::mirror::rays::marks`].
    pub mirrors: Marks,
    /// What rays of mirrors and to suns meet, since there are some.
    pub rays: Option<PictureRays>,
    /// Whether these were uploaded, or had no room.
    pub has_tried_rays: bool,
    pub baked: Baked,
}

/// Light of the environment, and its map as it is seen.
#[derive(Default)]
pub struct ShownEnvironment {
    /// As it was set, whether it is shown or not.
    pub light: Option<(GpuLight, Arc<Environment>)>,
    /// What kernels light, once there was a map for the scene, unless they failed.
    samples: Option<GpuSamples>,
    kernels_failed: bool,
    /// Stands in where none is shown; made for the scene.
    dark: Option<(GpuLight, Arc<Environment>)>,
    map: Option<GpuMap>,
}

impl ShownEnvironment {
    /// Lights a scene. Kernels compute the light of a map, or the cores where those fail.
    ///
    /// # Errors
    /// A lost device.
    pub fn set(
        &mut self,
        pipelines: &Pipelines,
        scene: &GpuScene,
        (light, lighting): (&Illumination, &Arc<EnvironmentLight>),
    ) -> Result<(), BackendError> {
        // Kernels answer for their own errors alone.
        pipelines.gpu().check()?;
        let nodes = lighting.turned().and_then(|turned| self.turned(pipelines, turned));
        let (before, passes) = (self.light.as_ref().map(|(before, _)| before), &pipelines.passes);
        let lit = GpuLight::new(pipelines.gpu(), &passes.lit, scene, (light, lighting, nodes), before)?;
        self.light = Some((lit, light.environment.clone()));
        Ok(())
    }

    /// The nodes under a map by kernels, which are not tried again after a failure.
    fn turned(&mut self, pipelines: &Pipelines, turned: &TurnedMap) -> Option<NodeBuffers> {
        if self.kernels_failed || !pipelines.light_by_kernels {
            return None;
        }
        let nodes = self.try_turned(pipelines, turned).ok();
        self.kernels_failed = nodes.is_none();
        nodes
    }

    fn try_turned(
        &mut self,
        Pipelines { device, shaders, .. }: &Pipelines,
        turned: &TurnedMap,
    ) -> Result<NodeBuffers, BackendError> {
        let mut samples = match self.samples.take().filter(|known| known.is_of(&turned.samples)) {
            Some(known) => known,
            None => GpuSamples::new(device, shaders, &turned.samples)?,
        };
        let nodes = samples.light(&device.gpu, turned)?;
        self.samples = Some(samples);
        Ok(nodes)
    }
}

impl Loaded {
    /// Uploads what rays of mirrors and to suns meet, if there are mirrors or `suns` and it was not tried yet.
    ///
    /// # Errors
    /// A scene that the adapter has no room for.
    pub fn upload_rays(&mut self, device: &SharedDevice, suns: bool) -> Result<(), BackendError> {
        if !self.has_tried_rays && (suns || self.mirrors != Marks::default()) {
            self.has_tried_rays = true;
            self.rays = Some(PictureRays::new(device, &self.baked)?);
        }
        Ok(())
    }
}

impl Shown {
    /// Nothing yet.
    pub fn new(gpu: &GpuDevice) -> Self {
        Self {
            scene: None,
            opacities: Opacities::default(),
            environment: ShownEnvironment::default(),
            local: LocalLighting::default(),
            bounce: GpuBounce::default(),
            local_lights: DirectLights::new(gpu),
        }
    }

    /// Another scene, without light.
    pub fn set_scene(&mut self, loaded: Loaded) {
        self.scene = Some(loaded);
        self.forget_light();
        let map = self.environment.map.take();
        self.environment = ShownEnvironment { map, ..Default::default() };
        self.bounce = GpuBounce::default();
    }

    /// The lights go with where their scene is.
    pub fn forget_light(&mut self) {
        self.local_lights.set(&[], 1.0);
        (self.local, self.bounce.light) = Default::default();
    }

    pub fn loaded(&self) -> &Loaded {
        self.scene.as_ref().expect("a picture is begun with a scene")
    }

    /// The environment if it is shown.
    pub fn shown_environment(&self) -> Option<&(GpuLight, Arc<Environment>)> {
        self.environment.light.as_ref().filter(|_| self.local.components.environment)
    }

    /// The environment that is merged: one without light if none is shown.
    pub fn merged_environment(&self) -> &(GpuLight, Arc<Environment>) {
        let merged = self.shown_environment().or(self.environment.dark.as_ref());
        merged.expect("a picture is begun with an environment, be it a dark one")
    }

    /// The map that passes read.
    pub fn map(&self) -> &wgpu::TextureView {
        &self.environment.map.as_ref().expect("a picture is begun with a map").view
    }

    /// Uploads what a view shows of the light, and is not there yet. Returns the reflectance of a ground that catches shadows for a
    /// radiance of 1 behind it, if there is one.
    ///
    /// # Errors
    /// A lost device.
    pub fn upload(
        &mut self,
        pipelines: &Pipelines,
        view: &View,
        sampling: BrdfSampling,
    ) -> Result<Option<Vec3>, BackendError> {
        let (gpu, Loaded { scene, .. }) = (pipelines.gpu(), self.scene.as_ref().expect("there is a scene"));
        if let Some((light, _)) = self.environment.light.as_mut().filter(|_| sampling != BrdfSampling::Lit) {
            light.upload_cut(gpu);
        }
        self.bounce.upload(gpu, &pipelines.passes.lit, scene)?;
        if self.shown_environment().is_none() && self.environment.dark.is_none() {
            let map = Image::filled([1, 1], Vec3::ZERO);
            let dark = (GpuLight::dark(gpu, scene.tree_height), Environment::new(String::new(), map).into());
            self.environment.dark = Some(dark);
        }
        let catches = self.environment.light.as_ref().and_then(|(light, environment)| {
            scene.ground.as_ref()?;
            caught_per_radiance(view, environment, light.intensity, self.local.components.environment)
        });
        // In a part of a picture that hides its background it catches one that does not shine there.
        let seen = self.environment.light.as_ref().filter(|_| catches.is_some());
        let (_, map) = seen.unwrap_or(self.merged_environment());
        let blur = match view.background {
            Background::Blurred(width) => Some(width),
            _ => None,
        };
        let map = map.clone();
        self.environment.map = Some(GpuMap::new(gpu, &map, blur, self.environment.map.take()));
        Ok(catches)
    }

    /// Gets ready what mirrors show in a view. Returns whether they show the scene: not if the adapter has no room for it.
    pub fn prepare_mirrors(&mut self, pipelines: &Pipelines, view: &View, sampling: BrdfSampling) -> bool {
        let gpu = pipelines.gpu();
        let Some(loaded) = &mut self.scene else { return false };
        let wanted = view.mirrors && view.mode == ViewMode::Shaded && sampling != BrdfSampling::Once;
        if !wanted || loaded.mirrors == Marks::default() {
            return false;
        }
        // Who sets materials or lights is told why there is no room.
        let _ = loaded.upload_rays(&pipelines.device, false);
        loaded.rays.iter().for_each(|rays| rays.set_view(gpu, view));
        loaded.rays.is_some()
    }

    /// Gets ready what rays to suns meet, if some shine in a view. Returns whether there are such rays: not if the adapter has no room.
    pub fn prepare_suns(&mut self, device: &SharedDevice, view: &View) -> bool {
        let Some(loaded) = &mut self.scene else { return false };
        if view.mode != ViewMode::Shaded || !self.local_lights.have_suns() {
            return false;
        }
        // Who sets materials or lights is told why there is no room.
        let _ = loaded.upload_rays(device, true);
        loaded.rays.is_some()
    }

    /// The parts of the light, with that of mirrors if they show the scene. Counts of merged nodes have one for each tree.
    pub fn parts(&self, mode: ViewMode, mirrors: bool) -> [bool; LightPart::COUNT] {
        let (shaded, bounce) = (mode == ViewMode::Shaded, &self.bounce);
        let lights = |part| shaded && self.local_lights.has(part);
        LightPart::ALL.map(|part| match part {
            LightPart::Environment => true,
            LightPart::Bounce => {
                let shows_basis = (shaded || mode.is_of_basis()) && bounce.light.functions.is_some();
                let is_shaded_alone = bounce.light.is_of_vertices || bounce.light.patches.is_some();
                bounce.sources.is_some() || shows_basis || shaded && is_shaded_alone
            }
            LightPart::Mirrors => mirrors,
            LightPart::Direct | LightPart::Added => lights(part),
        })
    }

    /// The passes that add samples to the parts of the light, and those for the light of what mirrors show, see
    /// [`Picture::mirrored`]. The first part is never missing, because it also has what has no light.
    pub fn passes(
        &mut self,
        Pipelines { device, passes, .. }: &mut Pipelines,
        (view, sampling): (&View, BrdfSampling),
        (groups, targets): (&Groups, &Targets),
    ) -> Result<(Vec<PartPass>, [Vec<PartPass>; DEEPEST as usize]), BackendError> {
        let (gpu, shaded) = (&*device.gpu, view.mode == ViewMode::Shaded);
        let mut all = Vec::new();
        if shaded && let Some(Loaded { scene, rays, .. }) = &self.scene {
            let rays = rays.as_ref().zip(targets.suns_seen.as_ref());
            let nothing = &targets.nothing.work;
            all = self.local_lights.prepare(gpu, passes, (scene, rays, nothing), [&groups.frame.group, &groups.scene]);
        }
        let bounced = self.bounce.evaluated(gpu, passes, view)?;
        all.extend(bounced.map(|(pass, light)| PartPass { part: LightPart::Bounce, pass, light, suns: None }));
        let (mut as_baked, has_mirrors) = (all.clone(), groups.mirrored.is_some());
        for (part, field, light) in self.merged(gpu) {
            let is_first = part == LightPart::Environment;
            let mut merge = |mirrors| {
                let variant = self.merge_variant(field, is_first, sampling, mirrors);
                // The next may be a pose. On a card it is compiled when all else is.
                passes.merge(MergeVariant { posed: true, ..variant });
                let pass = passes.merge(variant);
                PartPass { part, pass, light: light.clone(), suns: None }
            };
            all.push(merge(has_mirrors));
            if has_mirrors {
                as_baked.push(merge(false));
            }
        }
        Ok(if has_mirrors { (all.clone(), [all, as_baked]) } else { (all, Default::default()) })
    }

    /// The trees of lights that are merged, by the part of the light.
    fn merged(&self, gpu: &GpuDevice) -> Vec<(LightPart, u32, wgpu::BindGroup)> {
        let scene = &self.loaded().scene;
        let first = if self.shown_environment().is_some() { FIELD_ENVIRONMENT } else { FIELD_NONE };
        let environment = (LightPart::Environment, first, bound(gpu, &self.merged_environment().0.tree, &scene.cuts));
        let sources = self.bounce.sources.as_ref().zip(scene.sources.as_ref());
        let sources =
            sources.map(|(light, baked)| (LightPart::Bounce, FIELD_SOURCES, bound(gpu, &light.tree, &baked.cuts)));
        [environment].into_iter().chain(sources).collect()
    }

    fn merge_variant(&self, field: u32, is_first: bool, sampling: BrdfSampling, has_rays: bool) -> MergeVariant {
        let (refine, Loaded { scene, materials, .. }) = (sampling != BrdfSampling::Once, self.loaded());
        let may_mirror = Mirror::may_be(materials.narrowest, scene.leaf_solid_angle);
        MergeVariant {
            field,
            is_first,
            refine,
            mirrors: match has_rays {
                true => MIRRORS_HAVE_RAYS,
                false if refine && field == FIELD_ENVIRONMENT && may_mirror => MIRRORS_READ_MAP,
                false => NO_MIRRORS,
            },
            lit: sampling == BrdfSampling::Lit,
            by_direction: field == FIELD_SOURCES
                && self.bounce.sources.as_ref().is_some_and(|s| s.tree.sends_by_direction),
            posed: self.bounce.light.posed.is_some(),
            bent: materials.are_bent,
        }
    }

    /// Uniforms of a sample of a picture, for every `stride`th pixel of every `stride`th row.
    pub fn frame(&self, picture: &Picture, sample: u32, stride: u32) -> FrameUniforms {
        let lit = ShownLight {
            shown: self.shown_environment().map(|(light, _)| light),
            behind: self.environment.light.as_ref().map(|(light, _)| light),
            emission: self.local.components.direct,
            catches: picture.catches,
            mirrors: picture.has_mirrors(),
            brightest: brightest_by_rays(self.bounce.light.sources.as_deref()),
        };
        frame(&picture.view, sample, picture.offset(sample), &self.loaded().scene, lit, stride)
    }

    /// Replaces the local lights in the sums by those that shine now. `before` are the shadow maps in the sums, and whether
    /// these are complete.
    pub fn step_lights(&mut self, lights: &mut SummedLights, before: Option<(&Plan, bool)>) -> DirectStep {
        let shown = self.local.shown_lights();
        let step = lights.update(&shown, before.is_some_and(|(_, complete)| complete));
        if self.local_lights.order(lights, before.map(|(plan, _)| plan)) || step == DirectStep::Anew {
            return step;
        }
        // With other shadow maps, a sum of lights is not what it was.
        *lights = SummedLights { direct: shown, added: Vec::new() };
        self.local_lights.order(lights, None);
        DirectStep::Anew
    }
}

/// A tree of lights and the cuts over it.
fn bound(gpu: &GpuDevice, tree: &GpuTreeLight, cuts: &GpuCuts) -> wgpu::BindGroup {
    let light = Light {
        nodes: &tree.of_nodes.nodes,
        brightness: &tree.of_nodes.brightness,
        visibility_cuts: &cuts.view,
        illumination_cut: &tree.cut,
        lit_nodes: &tree.lit.nodes,
        lit_offsets: &tree.lit.offsets,
        sent: &tree.sent,
    };
    light.bind(gpu)
}
