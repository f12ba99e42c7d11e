//! Bounced light on the GPU and by the CPU renderer, at what the deferred pass saw: alone, over the environment, for
//! every BRDF, and in bands and samples. Each comparison has a negative control.

use super::twin::{agrees, backend, difference, in_bands, on_the_cpu};
use crate::{
    Appearance, Backend, Background, BounceLight, BrdfSampling, Components, EnvironmentLight, Illumination,
    LocalLighting, Renderer, SourceRig, View, ViewMode,
    gpu::GpuBackend,
    shade::painter::PictureLight,
    test_scenes::{Edited, floor_and_wall, illumination, point_light},
};
use glam::Vec3;
use lapidary_core::{
    brdf::GgxParameters,
    camera::Camera,
    image::Image,
    material::{BrdfModel, Material},
};
use std::sync::{Arc, MutexGuard};

pub(super) const BOUNCE: Components = Components { indirect: true, ..Components::NONE };
const ALL: Components = Components { direct: false, ..Components::ALL };

pub(super) struct Rig {
    renderer: Renderer,
    pub gpu: GpuBackend,
    sources: Edited<SourceRig>,
    environment: Arc<EnvironmentLight>,
    bounce: BounceLight,
    _one: MutexGuard<'static, ()>,
}

pub(super) fn light() -> Illumination {
    illumination([64, 32], |x, y| Vec3::new(0.05 * x as f32, 0.3, 0.02 * y as f32))
}

fn view(mode: ViewMode) -> View {
    let camera = Camera::look_at(Vec3::new(1.8, 1.2, 0.6), Vec3::new(-1.0, 0.1, 0.0), 50.0);
    View { background: Background::Flat(Vec3::new(0.1, 0.2, 0.3)), mode, mirrors: false, ..View::new(camera, [64, 48]) }
}

impl Rig {
    pub fn new(model: BrdfModel, roughness: f32) -> Option<Self> {
        let (one, mut gpu) = backend()?;
        let mut dataset = floor_and_wall(6);
        let parameters = GgxParameters { roughness, metalness: 0.3, ..Default::default() };
        dataset.scene.materials[0] = Material { model, parameters: parameters.into(), ..Default::default() };
        let renderer = Renderer::new(dataset);
        let environment = renderer.lighting(&light(), 64).into();
        gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
        gpu.set_light(&light(), &environment).unwrap();
        let baked = renderer.dataset().clone().into();
        let mut sources = Edited::new(&baked, SourceRig::new(&baked)?);
        sources.set_environment(Some((*environment).clone()));
        let bounce = BounceLight::Sources(sources.lighting(64).into());
        let mut rig = Self { renderer, gpu, sources, environment, bounce, _one: one };
        rig.shine(Vec3::new(-1.5, 1.2, 0.4), ALL);
        Some(rig)
    }

    fn shine(&mut self, position: Vec3, components: Components) {
        self.sources.set_lights(&[point_light(position, 4.0)]);
        self.bounce = BounceLight::Sources(self.sources.lighting(64).into());
        let local = LocalLighting { bounce: Some(self.bounce.clone()), components, ..Default::default() };
        self.gpu.set_local_lighting(&local).unwrap();
    }

    fn on_gpu(&mut self, view: &View, sampling: BrdfSampling) -> Image {
        self.gpu.begin(view, sampling).unwrap();
        self.gpu.render_rows(0, 0..view.size[1]).unwrap();
        self.gpu.read(1).unwrap().0
    }

    fn on_cpu(&self, view: &View, components: Components, sampling: BrdfSampling) -> Image {
        let light = PictureLight {
            environment: Some(&**self.environment).filter(|_| components.environment),
            bounce: Some(&self.bounce).filter(|_| components.indirect),
            ..Default::default()
        };
        on_the_cpu(&self.gpu, &self.renderer, view, light, sampling)
    }
}

#[test]
fn bounces_agree_for_every_model_alone_and_with_the_environment() {
    for (model, roughness) in [(BrdfModel::Lambert, 1.0), (BrdfModel::Ggx, 0.4), (BrdfModel::Ward, 0.5)] {
        let Some(mut rig) = Rig::new(model, roughness) else { return };
        let view = view(ViewMode::Shaded);
        for sampling in [BrdfSampling::Refine, BrdfSampling::Once] {
            for components in [BOUNCE, ALL] {
                rig.shine(Vec3::new(-1.5, 1.2, 0.4), components);
                let gpu = rig.on_gpu(&view, sampling);
                let cpu = rig.on_cpu(&view, components, sampling);
                assert!(agrees(&gpu, &cpu), "{model:?} {sampling:?} {components}: {:?}", difference(&gpu, &cpu));
                let none = rig.on_cpu(&view, Components { indirect: false, ..components }, sampling);
                assert!(!agrees(&gpu, &none), "negative control: {model:?} {sampling:?} {components}");
            }
        }
        rig.shine(Vec3::new(-1.4, 1.2, 0.4), ALL);
        let (moved, cpu) = (rig.on_gpu(&view, BrdfSampling::Refine), rig.on_cpu(&view, ALL, BrdfSampling::Refine));
        assert!(agrees(&moved, &cpu), "a moved light: {:?}", difference(&moved, &cpu));
    }
}

#[test]
fn counts_agree_and_neither_environment_nor_bounce_shows_what_needs_no_light() {
    let Some(mut rig) = Rig::new(BrdfModel::Ggx, 0.5) else { return };
    for mode in [ViewMode::MergedCut, ViewMode::BrdfEvaluations, ViewMode::Albedo, ViewMode::Normals] {
        let (gpu, cpu) =
            (rig.on_gpu(&view(mode), BrdfSampling::Refine), rig.on_cpu(&view(mode), ALL, BrdfSampling::Refine));
        // A node at the edge of the criterion may be halved by one of both.
        assert!(difference(&gpu, &cpu).0 < 1e-3, "{mode:?}: {:?}", difference(&gpu, &cpu));
    }
    let both = rig.gpu.stats().unwrap();
    assert!(both.pixels_shaded > 1000);
    rig.shine(Vec3::new(-1.5, 1.2, 0.4), Components::NONE);
    let dark = rig.on_gpu(&view(ViewMode::Shaded), BrdfSampling::Refine);
    let surfaces = dark.pixels.iter().filter(|&&p| p == Vec3::ZERO).count();
    assert_eq!(
        surfaces as u64,
        rig.gpu.stats().unwrap().pixels_shaded,
        "surfaces are black, what is behind them is not"
    );
    assert_eq!(rig.gpu.stats().unwrap().mean_merged_nodes, 0.0);
}

#[test]
fn bands_and_samples_of_several_passes_add_up_to_the_whole() {
    let Some(mut rig) = Rig::new(BrdfModel::Ggx, 0.5) else { return };
    let view = View { aa: 3, ..view(ViewMode::Shaded) };
    let mut whole = |ends: &[u32]| in_bands(&mut rig.gpu, &view, ends);
    let one = whole(&[48]);
    assert!(whole(&[1, 17, 17, 48]) == one);
    assert!(in_bands(&mut rig.gpu, &View { aa: 2, ..view.clone() }, &[48]) != one, "negative control");
    rig.gpu.set_appearance(&Appearance::of(&rig.renderer.dataset().scene)).unwrap();
    rig.gpu.begin(&view, BrdfSampling::Refine).unwrap();
    rig.gpu.render_rows(0, 0..48).unwrap();
    let first = rig.gpu.read(1).unwrap().0;
    rig.gpu.render_rows(1, 0..20).unwrap();
    assert!(rig.gpu.read(1).unwrap().0 == first, "rows with one sample more are no brighter");
}
