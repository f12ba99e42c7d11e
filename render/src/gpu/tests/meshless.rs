//! Bounced light of the meshless basis on the GPU and by the CPU renderer, at what the deferred pass saw: every BRDF, with
//! textures, normal and bump maps, beside other light, the views of the basis, and what is uploaded again. Each comparison
//! has a negative control.

use super::{
    bounce::{BOUNCE, light},
    twin::{agrees, appearance, backend, difference, in_bands, maps, on_the_cpu, parameters, scene, view},
};
use crate::{
    Appearance, Backend, Background, Baked, BasisView, BounceLight, BrdfSampling, Components, CpuBackend,
    EnvironmentLight, LocalLighting, LocalRig, Post, Renderer, Solution, View, ViewMode,
    gpu::GpuBackend,
    light::{
        bounce::{MeshlessLight, VerticesAsBaked, meshless::functions::tests::with_functions_of_objects},
        implicit::tests::{blocked, posed},
    },
    shade::painter::PictureLight,
    test_scenes::{Edited, floor_and_wall, from_above, linked_floor_and_wall, point_light, white},
};
use glam::{Mat3A, Vec3, Vec3A};
use lapidary_core::{
    brdf::GgxParameters,
    camera::Camera,
    dataset::Dataset,
    image::Image,
    lights::Light,
    material::{BrdfModel, MaterialMaps},
    meshless::{Basis, MeshlessBake, Transport},
    scene::pose::Pose,
    surfel::Surfel,
};
use std::sync::{Arc, MutexGuard};

pub(super) struct Rig {
    renderer: Renderer,
    pub gpu: GpuBackend,
    environment: Arc<EnvironmentLight>,
    meshless: Arc<MeshlessLight>,
    _one: MutexGuard<'static, ()>,
}

/// Over black, so that nothing but surfaces counts in differences.
fn dark_view() -> View {
    View { background: Background::Flat(Vec3::ZERO), ..view(ViewMode::Shaded) }
}

/// A scene whose vertices have functions on both sides, of three levels; backs only on one half.
fn scene_with_basis() -> Dataset {
    let mut dataset = (*scene()).clone();
    let mesh = &dataset.scene.mesh;
    let side = |sign: f32| {
        let points = mesh.positions.iter().zip(&mesh.normals);
        points.map(move |(&position, &normal)| Surfel { position, normal: normal * sign, ..Default::default() })
    };
    let points: Vec<Surfel> = side(1.0).chain(side(-1.0).filter(|p| p.position.x > 0.0)).collect();
    let every = |n: usize| points.iter().step_by(n).copied().collect::<Vec<_>>();
    let basis = Basis::new(&[every(37), every(7), every(1)], 1.0, 1).unwrap();
    let transport = Transport::from_rows(&vec![Vec::new(); basis.len()], basis.senders().len());
    dataset.meshless = Some(MeshlessBake { basis, transport }.into());
    dataset
}

/// Light mostly from the side of each function, other in each and in each channel; of every fifth function none.
fn meshless_light(dataset: &Arc<Dataset>) -> Arc<MeshlessLight> {
    let mut random = fastrand::Rng::with_seed(7);
    let mut vector = || Vec3A::from_array(std::array::from_fn(|_| random.f32() - 0.5));
    let points = dataset.meshless.as_ref().unwrap().basis.points();
    let mut coefficient = |(i, point): (usize, &Surfel)| {
        let up = Vec3A::from(point.normal) * 0.3;
        let columns = Mat3A::from_cols(vector() + up, (vector() + up) * 2.0, (vector() + up) * 0.5);
        if i % 5 == 0 { Mat3A::ZERO } else { columns }
    };
    let coefficients = points.iter().enumerate().map(&mut coefficient).collect();
    Arc::new(MeshlessLight::new(dataset, coefficients).unwrap())
}

fn picture(gpu: &mut dyn Backend, view: &View) -> Image {
    picture_by(gpu, view, BrdfSampling::Refine)
}

fn picture_by(gpu: &mut dyn Backend, view: &View, sampling: BrdfSampling) -> Image {
    gpu.begin(view, sampling).unwrap();
    gpu.render_rows(0, 0..view.size[1]).unwrap();
    gpu.read(1).unwrap().0
}

impl Rig {
    pub fn new() -> Option<Self> {
        let (one, mut gpu) = backend()?;
        let renderer = Renderer::new(scene_with_basis());
        let environment = renderer.lighting(&light(), 64).into();
        gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
        gpu.set_light(&light(), &environment).unwrap();
        let meshless = meshless_light(renderer.dataset());
        let mut rig = Self { renderer, gpu, environment, meshless, _one: one };
        rig.show(BOUNCE);
        Some(rig)
    }

    fn show(&mut self, components: Components) {
        let lights: Arc<[Light]> = [point_light(Vec3::new(0.9, 1.4, 0.5), 4.0)].into();
        let bounce = Some(BounceLight::Functions(self.meshless.clone()));
        let local = LocalLighting { lights, bounce, components, ..Default::default() };
        assert!(self.gpu.set_local_lighting(&local).unwrap().is_empty(), "nothing to remark");
    }

    fn look(&mut self, appearance: Appearance) {
        assert!(self.gpu.set_appearance(&appearance).unwrap().is_empty());
        self.renderer.set_appearance(appearance);
    }

    /// The bounce alone, by the CPU renderer.
    fn on_cpu(&self, meshless: &MeshlessLight) -> Image {
        self.seen_on_cpu(&dark_view(), meshless)
    }

    fn seen_on_cpu(&self, view: &View, meshless: &MeshlessLight) -> Image {
        let bounce = BounceLight::Functions(meshless.clone().into());
        let light = PictureLight { bounce: Some(&bounce), ..Default::default() };
        on_the_cpu(&self.gpu, &self.renderer, view, light, BrdfSampling::Refine)
    }
}

/// Others in the place of all coefficients.
fn changed(light: &MeshlessLight, change: impl Fn(&Mat3A) -> Mat3A) -> MeshlessLight {
    MeshlessLight::new(light.dataset(), light.coefficients().iter().map(change).collect()).unwrap()
}

#[test]
fn pixels_agree_to_a_hundred_thousandth_of_the_light() {
    let Some(mut rig) = Rig::new() else { return };
    let (gpu, cpu) = (picture(&mut rig.gpu, &dark_view()), rig.on_cpu(&rig.meshless));
    let (relative, _) = difference(&gpu, &cpu);
    assert!(relative < 1e-5, "{relative}");
    let (levels, coefficients) = (rig.meshless.functions(), rig.meshless.coefficients());
    let mut fewer = coefficients.to_vec();
    fewer[levels.level(2)].fill(Mat3A::ZERO);
    let without_finest = MeshlessLight::new(rig.meshless.dataset(), fewer).unwrap();
    assert!(difference(&gpu, &rig.on_cpu(&without_finest)).0 > 0.05, "negative control: a level less");
    let mut swapped = coefficients.to_vec();
    let half = swapped.len() / 2;
    swapped[half..].rotate_left(1);
    let swapped = MeshlessLight::new(rig.meshless.dataset(), swapped).unwrap();
    assert!(difference(&gpu, &rig.on_cpu(&swapped)).0 > 0.05, "negative control: the neighbours' light");
}

#[test]
fn functions_of_objects_go_with_them_on_both_renderers() {
    let Some((_one, mut gpu)) = backend() else { return };
    let as_baked = Arc::new(with_functions_of_objects(blocked(white(), 12)));
    let pose = Pose { translate: Vec3::new(0.4, -0.3, 0.2), rotate_degrees: Vec3::Y * 30.0, ..Pose::AS_BAKED };
    let scene = Baked::from(as_baked.clone()).posed(&posed(pose)).unwrap();
    let renderer = Renderer::new(scene.dataset.clone());
    gpu.set_scene(&scene).unwrap();
    let bases = as_baked.object_bases.as_ref().unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    let mut vector = || Vec3A::from_array(std::array::from_fn(|_| random.f32() + 0.2));
    let coefficients = bases.points().iter().map(|_| Mat3A::from_cols(vector(), vector(), vector())).collect();
    let light = |dataset: &Arc<Dataset>| {
        let as_baked = VerticesAsBaked::of(&dataset.scene.mesh).into();
        MeshlessLight::of_objects(dataset, &as_baked, Vec::clone(&coefficients)).unwrap()
    };
    let on_gpu = |gpu: &mut GpuBackend, view: &View| {
        let bounce = Some(BounceLight::Functions(light(&as_baked).into()));
        let local = LocalLighting { bounce, components: BOUNCE, ..Default::default() };
        assert!(gpu.set_local_lighting(&local).unwrap().is_empty());
        picture(gpu, view)
    };
    for mode in [ViewMode::Shaded, ViewMode::BasisLevel, ViewMode::BasisCoefficients] {
        let view =
            View { mode, basis: BasisView { level: 1, function: 0 }, camera: from_above(64).camera, ..dark_view() };
        let shown = on_gpu(&mut gpu, &view);
        let on_cpu = |dataset: &Arc<Dataset>| {
            let bounce = BounceLight::Functions(light(dataset).into());
            let light = PictureLight { bounce: Some(&bounce), ..Default::default() };
            on_the_cpu(&gpu, &renderer, &view, light, BrdfSampling::Refine)
        };
        let cpu = on_cpu(&as_baked);
        assert!(agrees_but_at_edges(&shown, &cpu), "{mode:?}: {:?}", difference(&shown, &cpu));
        let stayed = on_cpu(&scene.dataset);
        assert!(!agrees_but_at_edges(&shown, &stayed), "negative control: functions stay behind, {mode:?}");
    }
}

#[test]
fn views_of_the_basis_agree_and_are_told_from_each_other() {
    let Some(mut rig) = Rig::new() else { return };
    let basis = rig.meshless.functions();
    // Of the middle level, and seen.
    let middle = |i: &usize| {
        let point = basis.points()[*i];
        point.normal.y > 0.0 && point.position.distance(Vec3::new(0.8, 0.0, 0.8)) < 0.5
    };
    let function = basis.level(1).find(middle).unwrap() as u32;
    let of = |mode, level, function| View { mode, basis: BasisView { level, function }, ..dark_view() };
    let views = [
        of(ViewMode::BasisLevel, 0, 0),
        of(ViewMode::BasisLevel, 2, 0),
        of(ViewMode::BasisFunction, 0, function),
        of(ViewMode::BasisFunction, 0, u32::MAX),
        of(ViewMode::BasisCoefficients, 0, 0),
    ];
    let on_gpu = views.each_ref().map(|view| picture(&mut rig.gpu, view));
    for (i, (view, gpu)) in views.iter().zip(&on_gpu).enumerate() {
        let cpu = rig.seen_on_cpu(view, &rig.meshless);
        assert!(agrees_but_at_edges(gpu, &cpu), "{i}: {:?}", difference(gpu, &cpu));
        let next = &on_gpu[(i + 1) % on_gpu.len()];
        assert!(!agrees_but_at_edges(next, &cpu), "negative control: {i}");
    }
    let unlit = rig.seen_on_cpu(&views[4], &changed(&rig.meshless, |_| Mat3A::ZERO));
    assert!(!agrees_but_at_edges(&on_gpu[4], &unlit) && agrees(&on_gpu[3], &unlit), "no coefficient, no mark");
}

/// Marks have sharp edges, which rounding moves.
fn agrees_but_at_edges(a: &Image, b: &Image) -> bool {
    let differing = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-4).count();
    (differing as f32) < 1e-3 * a.pixels.len() as f32
}

#[test]
fn backs_have_light_where_a_fine_function_is_on_their_side_and_none_elsewhere() {
    let Some(mut rig) = Rig::new() else { return };
    let camera = Camera::look_at(Vec3::new(1.5, -1.9, 2.2), Vec3::ZERO, 50.0);
    let from_below = View { camera, ..dark_view() };
    let (gpu, cpu) = (picture(&mut rig.gpu, &from_below), rig.seen_on_cpu(&from_below, &rig.meshless));
    assert!(agrees(&gpu, &cpu) && cpu.pixels.iter().any(|p| p.x > 0.0), "{:?}", difference(&gpu, &cpu));
    let is_front = |i: usize| rig.meshless.functions().points()[i].normal.y > 0.0;
    let fronts = (0..).zip(rig.meshless.coefficients()).map(|(i, &v)| if is_front(i) { v } else { Mat3A::ZERO });
    let fronts = MeshlessLight::new(rig.meshless.dataset(), fronts.collect()).unwrap();
    assert!(!agrees(&gpu, &rig.seen_on_cpu(&from_below, &fronts)), "negative control: the light of fronts alone");
    rig.meshless = Arc::new(fronts);
    rig.show(BOUNCE);
    let dark = picture(&mut rig.gpu, &from_below);
    assert!(dark.pixels.iter().all(|&p| p == Vec3::ZERO), "no light on backs");
    assert!(picture(&mut rig.gpu, &dark_view()).pixels.iter().any(|p| p.x > 0.0), "fronts as before");
}

#[test]
fn every_model_agrees_and_what_is_scaled_or_turned_does_not() {
    let Some(mut rig) = Rig::new() else { return };
    let dataset = rig.renderer.dataset().clone();
    for model in [BrdfModel::Lambert, BrdfModel::Ggx, BrdfModel::Ward] {
        for (roughness, anisotropy) in [(1.0, 0.0), (0.6, 0.0), (0.35, 0.8), (0.02, -0.6)] {
            rig.look(appearance(&dataset, model, parameters(roughness, anisotropy), MaterialMaps::default()));
            let (gpu, cpu) = (picture(&mut rig.gpu, &dark_view()), rig.on_cpu(&rig.meshless));
            assert!(agrees(&gpu, &cpu), "{model:?} {roughness} {anisotropy}: {:?}", difference(&gpu, &cpu));
            let scaled = changed(&rig.meshless, |&v| v * 1.001);
            assert!(!agrees(&gpu, &rig.on_cpu(&scaled)), "{model:?}: one part in a thousand more");
            let turned = changed(&rig.meshless, Mat3A::transpose);
            assert!(!agrees(&gpu, &rig.on_cpu(&turned)), "{model:?}: channels for axes");
        }
        let other = |roughness| appearance(&dataset, model, parameters(roughness, 0.0), MaterialMaps::default());
        rig.look(other(0.7));
        let gpu = picture(&mut rig.gpu, &dark_view());
        rig.renderer.set_appearance(other(0.75));
        let matters = !agrees(&gpu, &rig.on_cpu(&rig.meshless));
        assert_eq!(matters, model != BrdfModel::Lambert, "{model:?}: its lobe is part of the albedo");
    }
}

#[test]
fn textures_normal_and_bump_maps_agree_and_each_of_them_matters() {
    let Some(mut rig) = Rig::new() else { return };
    let dataset = rig.renderer.dataset().clone();
    for model in [BrdfModel::Lambert, BrdfModel::Ggx, BrdfModel::Ward] {
        let look = |maps| appearance(&dataset, model, parameters(0.8, 0.3), maps);
        rig.look(look(maps()));
        let (gpu, cpu) = (picture(&mut rig.gpu, &dark_view()), rig.on_cpu(&rig.meshless));
        assert!(agrees(&gpu, &cpu), "{model:?}: {:?}", difference(&gpu, &cpu));
        for kind in ["base_color", "normal", "bump"] {
            let mut fewer = maps();
            fewer.set(kind, None);
            rig.renderer.set_appearance(look(fewer));
            assert!(!agrees(&gpu, &rig.on_cpu(&rig.meshless)), "{model:?}: a map makes no difference");
        }
    }
}

#[test]
fn it_adds_to_environment_and_lights_and_shows_where_it_is_wanted() {
    let Some(mut rig) = Rig::new() else { return };
    let mut shown = |components, mode| {
        rig.show(components);
        picture(&mut rig.gpu, &View { mode, ..dark_view() })
    };
    let environment = Components { environment: true, ..Components::NONE };
    let direct = Components { direct: true, ..Components::NONE };
    let [all, sky, lamp, bounce] =
        [Components::ALL, environment, direct, BOUNCE].map(|components| shown(components, ViewMode::Shaded));
    let sum = |parts: &[&Image]| {
        let pixel = |i| parts.iter().map(|part: &&Image| part.pixels[i]).sum();
        Image { size: all.size, pixels: (0..all.pixels.len()).map(pixel).collect() }
    };
    assert!(difference(&sum(&[&sky, &lamp, &bounce]), &all).0 < 1e-6);
    for two in [[&sky, &lamp], [&lamp, &bounce], [&sky, &bounce]] {
        assert!(difference(&sum(&two), &all).0 > 0.01, "negative control: a part is missing");
    }
    assert!(shown(Components::NONE, ViewMode::Shaded).pixels.iter().all(|&p| p == Vec3::ZERO));
    assert!(shown(Components::ALL, ViewMode::Normals) == shown(Components::NONE, ViewMode::Normals));
    rig.show(Components::ALL);
    picture(&mut rig.gpu, &dark_view());
    assert!(rig.gpu.stats().unwrap().mean_merged_nodes > 1.0, "the environment is merged as before");
    let light = PictureLight { environment: Some(&rig.environment), ..Default::default() };
    let cpu = on_the_cpu(&rig.gpu, &rig.renderer, &dark_view(), light, BrdfSampling::Refine);
    assert!(agrees(&sky, &cpu) && !agrees(&bounce, &cpu));
}

#[test]
fn bands_and_jittered_samples_add_up_to_the_whole() {
    let Some(mut rig) = Rig::new() else { return };
    rig.show(Components::ALL);
    let view = View { aa: 3, ..dark_view() };
    let one = in_bands(&mut rig.gpu, &view, &[56]);
    assert!(in_bands(&mut rig.gpu, &view, &[1, 17, 17, 56]) == one);
    let first = picture(&mut rig.gpu, &view);
    let d = difference(&one, &first).0;
    assert!(d > 1e-3 && d < 0.3, "the mean of three samples is near the first, but not it: {d}");
}

fn lamp(x: f32) -> Arc<[Light]> {
    [point_light(Vec3::new(x, 1.2, 0.1), 3.0)].into()
}

pub(super) fn wall_view() -> View {
    let camera = Camera::look_at(Vec3::new(1.8, 1.2, 0.6), Vec3::new(-1.0, 0.1, 0.0), 50.0);
    View { background: Background::Flat(Vec3::ZERO), mirrors: false, ..View::new(camera, [64, 48]) }
}

#[test]
fn a_moved_light_changes_the_picture_and_a_moved_camera_uploads_nothing() {
    let Some((_one, mut gpu)) = backend() else { return };
    let renderer = Renderer::new(linked_floor_and_wall());
    let baked = renderer.dataset().clone().into();
    gpu.set_scene(&baked).unwrap();
    let mut rig = Edited::new(&baked, LocalRig::new(&baked));
    let mut shine = |gpu: &mut dyn Backend, lights: &Arc<[Light]>, view: &View| {
        if rig.situation.lights != *lights {
            rig.set_lights(lights);
        }
        let local = rig.lighting(BOUNCE, Solution::Meshless, 64);
        gpu.set_local_lighting(&local).unwrap();
        (picture(gpu, view), local.bounce.unwrap())
    };
    let (view, light) = (wall_view(), lamp(-1.0));
    let (before, solved) = shine(&mut gpu, &light, &view);
    let uploaded = gpu.coefficients().cloned().unwrap();
    let on_cpu = |gpu: &GpuBackend, solved: &BounceLight| {
        let light = PictureLight { bounce: Some(solved), ..Default::default() };
        on_the_cpu(gpu, &renderer, &view, light, BrdfSampling::Refine)
    };
    let cpu = on_cpu(&gpu, &solved);
    assert!(agrees(&before, &cpu) && cpu.pixels.iter().any(|p| p.x > 0.0), "{:?}", difference(&before, &cpu));
    let nearer = View { camera: Camera::look_at(Vec3::new(1.2, 1.0, 0.4), Vec3::ZERO, 50.0), ..view.clone() };
    let (elsewhere, _) = shine(&mut gpu, &light, &nearer);
    assert!(elsewhere != before && gpu.coefficients() == Some(&uploaded), "the camera moved");
    let (after, moved) = shine(&mut gpu, &lamp(-1.6), &view);
    assert!(gpu.coefficients() != Some(&uploaded), "the light moved");
    assert!(agrees(&after, &on_cpu(&gpu, &moved)) && difference(&after, &before).0 > 0.01);
    gpu.set_local_lighting(&rig.lighting(BOUNCE, Solution::Cuts, 64)).unwrap();
    assert!(gpu.coefficients().is_none(), "another solution needs none of it");
}

#[test]
fn further_bounces_on_the_sources_agree_and_are_told_from_one() {
    let Some((_one, mut gpu)) = backend() else { return };
    let mut dataset = linked_floor_and_wall();
    // The floor lights the wall too, so that its sources have more to send.
    let rows = [vec![(1, Vec3::new(0.3, -0.2, 0.0))], vec![(0, Vec3::new(-0.3, 0.2, 0.05))]];
    Arc::make_mut(dataset.meshless.as_mut().unwrap()).transport = Transport::from_rows(&rows, 2);
    let renderer = Renderer::new(dataset);
    let baked = renderer.dataset().clone().into();
    gpu.set_scene(&baked).unwrap();
    let mut rig = Edited::new(&baked, LocalRig::new(&baked));
    rig.set_lights(&lamp(-1.0));
    let view = wall_view();
    let mut both = |solution| {
        let local = rig.lighting(BOUNCE, solution, 64);
        assert!(gpu.set_local_lighting(&local).unwrap().is_empty());
        let shown = picture(&mut gpu, &view);
        let light = PictureLight { bounce: local.bounce.as_ref(), ..Default::default() };
        [shown, on_the_cpu(&gpu, &renderer, &view, light, BrdfSampling::Refine)]
    };
    let [one, _] = both(Solution::Cuts);
    let [gpu, cpu] = both(Solution::CutsMeshless);
    assert!(agrees(&gpu, &cpu), "{:?}", difference(&gpu, &cpu));
    assert!(difference(&gpu, &one).0 > 0.01, "negative control: {:?}", difference(&gpu, &one));
}

/// Floor and wall with a material of metal, and a lamp.
fn with_metal(material: usize, roughness: f32) -> (Renderer, Edited<LocalRig>) {
    let mut dataset = linked_floor_and_wall();
    let parameters = GgxParameters { base_color: Vec3::new(0.9, 0.6, 0.3), roughness, metalness: 1.0, ..white() };
    let metal = &mut dataset.scene.materials[material];
    (metal.model, metal.parameters) = (BrdfModel::Ggx, parameters.into());
    let renderer = Renderer::new(dataset);
    let baked = renderer.dataset().clone().into();
    let mut rig = Edited::new(&baked, LocalRig::new(&baked));
    rig.set_lights(&lamp(-1.0));
    (renderer, rig)
}

/// Light of a metal wall's sources, which send by direction.
pub(super) fn sent_by_metal() -> (Baked, LocalLighting) {
    let (renderer, mut rig) = with_metal(1, 0.4);
    (renderer.dataset().clone().into(), rig.lighting(BOUNCE, Solution::CutsGloss, 64))
}

#[test]
fn sources_that_send_by_direction_agree_and_are_told_from_diffuse_ones() {
    let Some((_one, mut gpu)) = backend() else { return };
    let (renderer, mut rig) = with_metal(1, 0.4);
    gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
    let mut both = |solution, mode, sampling| {
        let view = View { mode, ..wall_view() };
        let local = rig.lighting(BOUNCE, solution, 64);
        assert!(gpu.set_local_lighting(&local).unwrap().is_empty());
        let light = PictureLight { bounce: local.bounce.as_ref(), ..Default::default() };
        let shown = picture_by(&mut gpu, &view, sampling);
        [shown, on_the_cpu(&gpu, &renderer, &view, light, sampling)]
    };
    for sampling in [BrdfSampling::Refine, BrdfSampling::Lit, BrdfSampling::Once] {
        let [on_gpu, on_cpu] = both(Solution::CutsGloss, ViewMode::Shaded, sampling);
        assert!(agrees(&on_gpu, &on_cpu), "{sampling:?}: {:?}", difference(&on_gpu, &on_cpu));
        let [diffuse, _] = both(Solution::CutsMeshless, ViewMode::Shaded, sampling);
        assert!(difference(&on_gpu, &diffuse).0 > 0.05, "negative control: {:?}", difference(&on_gpu, &diffuse));
    }
    let [on_gpu, on_cpu] = both(Solution::CutsGloss, ViewMode::Gloss, BrdfSampling::Refine);
    assert!(agrees(&on_gpu, &on_cpu), "{:?}", difference(&on_gpu, &on_cpu));
    assert!(on_cpu.pixels.iter().any(|p| p.x > 0.0) && on_cpu.pixels.iter().any(|p| p.z > 0.0), "it adds and takes");
}

#[test]
fn glossy_receivers_of_the_basis_agree_and_are_told_from_diffuse_ones() {
    let Some((_one, mut gpu)) = backend() else { return };
    let (renderer, mut rig) = with_metal(0, 0.5);
    gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
    let Some(BounceLight::Functions(glossy)) = rig.lighting(BOUNCE, Solution::Meshless, 64).bounce else { panic!() };
    let diffuse = MeshlessLight::new(renderer.dataset(), glossy.coefficients().to_vec()).unwrap();
    let both = |light: Arc<MeshlessLight>, gpu: &mut GpuBackend| {
        let bounce = Some(BounceLight::Functions(light));
        let local = LocalLighting { bounce: bounce.clone(), components: BOUNCE, ..Default::default() };
        assert!(gpu.set_local_lighting(&local).unwrap().is_empty());
        let shown = picture(gpu, &wall_view());
        let light = PictureLight { bounce: bounce.as_ref(), ..Default::default() };
        [shown, on_the_cpu(gpu, &renderer, &wall_view(), light, BrdfSampling::Refine)]
    };
    let [on_gpu, on_cpu] = both(glossy, &mut gpu);
    assert!(agrees(&on_gpu, &on_cpu), "{:?}", difference(&on_gpu, &on_cpu));
    let [diffuse, _] = both(diffuse.into(), &mut gpu);
    assert!(difference(&on_gpu, &diffuse).0 > 0.1, "negative control: {:?}", difference(&on_gpu, &diffuse));
}

#[test]
fn counts_have_the_colours_of_the_cpu_also_where_no_environment_is_shown() {
    let Some((_one, mut gpu)) = backend() else { return };
    let dataset = Arc::new(floor_and_wall(8));
    let baked = dataset.clone().into();
    let mut rig = Edited::new(&baked, LocalRig::new(&baked));
    rig.set_lights(&lamp(-1.0));
    let local = rig.lighting(BOUNCE, Solution::Cuts, 512);
    let view = View { mode: ViewMode::MergedCut, ..wall_view() };
    let shown = |backend: &mut dyn Backend, illum_cut| {
        let lighting = Renderer::new(dataset.clone()).lighting(&light(), illum_cut);
        backend.set_scene(&baked).unwrap();
        backend.set_light(&light(), &lighting.into()).unwrap();
        backend.set_local_lighting(&local).unwrap();
        picture(backend, &view);
        backend.display(&Post::default(), 1).unwrap()
    };
    let differing = |a: &[[u8; 4]], b: &[[u8; 4]]| {
        let differs = |(a, b): &(&[u8; 4], &[u8; 4])| (0..4).any(|c| a[c].abs_diff(b[c]) > 2);
        a.iter().zip(b).filter(differs).count() as f32 / a.len() as f32
    };
    let [on_gpu, on_cpu] = [&mut gpu as &mut dyn Backend, &mut CpuBackend::new()].map(|backend| shown(backend, 1024));
    assert!(differing(&on_gpu, &on_cpu) < 0.02, "{}", differing(&on_gpu, &on_cpu));
    let other_top = shown(&mut gpu, 128);
    assert!(differing(&on_gpu, &other_top) > 0.2, "{}", differing(&on_gpu, &other_top));
}
