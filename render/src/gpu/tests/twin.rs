//! The shader and the CPU renderer on the same buffers: both shade the triangles and barycentric weights that the
//! deferred pass wrote, and agree at every pixel, for every BRDF and mode. Each comparison has a negative control.

use super::inexact;
use crate::{
    Appearance, Backend, BackendError, Background, BrdfSampling, CpuBackend, EnvironmentLight, Illumination, Post,
    Renderer, ToneMap, View, ViewMode,
    device::{
        layout::Vertex,
        test_adapter::{on_adapter, shared_device},
    },
    gpu::{GpuBackend, GpuPath, ShaderSource},
    post::vignetted,
    shade::surface::Surfaces,
    shade::{
        differentials::Differentials,
        painter::{Painter, PictureLight, SeenOfParts},
    },
    stale::LightPart,
    test_scenes::{dataset, mesh},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{GgxParameters, Parameters, example_file},
    camera::{Camera, Lens},
    dataset::Dataset,
    environment::{Environment, sun_and_sky},
    image::Image,
    material::{BrdfModel, Material, MaterialMaps, map_names},
    ray::Hit,
    texture::{Channel, ColorSpace, Texels, Texture, TextureSlot},
};
use std::sync::{Arc, MutexGuard};

/// A backend within WebGPU's default limits; see [`on_adapter`].
pub(in crate::gpu) fn backend() -> Option<(MutexGuard<'static, ()>, GpuBackend)> {
    backend_of(&inexact::source())
}

/// Another backend, where one is held.
pub(super) fn another() -> GpuBackend {
    on_path(path())
}

/// Another one that runs its passes so.
pub(super) fn on_path(path: GpuPath) -> GpuBackend {
    on(&inexact::source(), path).expect("there was one before")
}

/// A backend with these shaders.
pub(super) fn backend_of(source: &ShaderSource) -> Option<(MutexGuard<'static, ()>, GpuBackend)> {
    on_adapter(|| on(source, path()))
}

fn on(source: &ShaderSource, path: GpuPath) -> Result<GpuBackend, BackendError> {
    GpuBackend::new(shared_device()?, source, path)
}

/// How the tests of the GPU run its passes: `LAPIDARY_GPU_PATH=compute` takes the kernels.
fn path() -> GpuPath {
    match std::env::var("LAPIDARY_GPU_PATH").as_deref() {
        Ok("compute") => GpuPath::Compute,
        Ok(other) => panic!("LAPIDARY_GPU_PATH is {other}; give compute"),
        Err(_) => GpuPath::Fragment,
    }
}

pub(super) fn noise(i: u32) -> u8 {
    (i.wrapping_mul(0x9e37_79b9) >> 24) as u8
}

fn textures() -> Vec<Arc<Texture>> {
    let texture = |name: &str, size: [u32; 2], texels| Arc::new(Texture::new(name, size, texels));
    let codes = |n: u32| (0..n).map(|i| std::array::from_fn(|c| noise(4 * i + c as u32))).collect();
    // At least 0.3, for roughness: lobes magnify what rounding does to directions by the inverse of their width.
    let floats = |n: u32| (0..n).map(|i| [0.3 + 0.7 * f32::from(noise(i)) / 255.0; 4]).collect();
    vec![
        texture("codes", [7, 5], Texels::U8(codes(35))),
        texture("heights", [16, 16], Texels::F32(floats(256))),
        texture("normals", [4, 4], Texels::U8((0..16).map(|i| [118 + noise(i) / 12, 125, 250, 255]).collect())),
    ]
}

pub(super) fn maps() -> MaterialMaps {
    let slot = |texture, color_space, channel, strength| TextureSlot {
        texture,
        color_space,
        channel,
        strength,
        scale: Vec2::new(1.7, 0.6),
        offset: Vec2::new(0.3, -1.2),
        rotation: 0.4,
        flip_y: false,
        ..Default::default()
    };
    MaterialMaps::from([
        ("base_color", slot(0, ColorSpace::Srgb, Channel::R, 1.0)),
        ("roughness", slot(1, ColorSpace::Linear, Channel::G, 1.0)),
        ("metalness", slot(0, ColorSpace::Linear, Channel::B, 1.0)),
        ("specular", slot(0, ColorSpace::Linear, Channel::A, 1.0)),
        ("anisotropy", slot(1, ColorSpace::Linear, Channel::B, 1.0)),
        ("ior", slot(0, ColorSpace::Linear, Channel::G, 1.0)),
        ("edge_color", slot(0, ColorSpace::Linear, Channel::R, 1.0)),
        ("normal", slot(2, ColorSpace::Linear, Channel::R, 0.8)),
        ("bump", slot(1, ColorSpace::Linear, Channel::R, 0.02)),
    ])
}

/// A floor with a blocker above: shadows, both sides, a buried vertex, curved normals.
pub(super) fn scene() -> Arc<Dataset> {
    let mut mesh = mesh(24, true);
    for (n, p) in mesh.normals.iter_mut().zip(&mesh.positions).filter(|(n, _)| n.y > 0.0) {
        *n = (*n + Vec3::new(0.2 * (3.0 * p.x).sin(), 0.0, 0.2 * (2.0 * p.z).cos())).normalize();
    }
    let mut dataset = dataset(mesh, GgxParameters::default());
    dataset.two_sided.iter_mut().step_by(3).for_each(|t| *t = true);
    dataset.vertex_valid.iter_mut().step_by(7).for_each(|v| *v = false);
    dataset.scene.textures = textures();
    Arc::new(dataset)
}

pub(super) fn appearance(
    dataset: &Dataset,
    model: BrdfModel,
    parameters: impl Into<Parameters>,
    maps: MaterialMaps,
) -> Appearance {
    let parameters = parameters.into();
    let mut appearance = Appearance::of(&dataset.scene);
    for material in &mut appearance.materials {
        let file = example_file(model);
        *material = Material { model, file, parameters: parameters.clone(), maps: maps.clone(), ..material.clone() };
    }
    appearance
}

fn light() -> Illumination {
    let environment = Environment::new("sky".into(), sun_and_sky(0.6));
    Illumination { environment: environment.into(), rotation: 0.7, intensity: 1.3, sun: None }
}

pub(super) fn view(mode: ViewMode) -> View {
    let camera = Camera::look_at(Vec3::new(1.5, 1.9, 2.2), Vec3::new(0.0, 0.2, 0.0), 50.0);
    View { background: Background::Flat(Vec3::new(0.1, 0.2, 0.3)), mode, mirrors: false, ..View::new(camera, [72, 56]) }
}

/// One sample by the CPU renderer, at what the deferred pass of `gpu` saw.
pub(super) fn on_the_cpu(
    gpu: &GpuBackend,
    renderer: &Renderer,
    view: &View,
    light: PictureLight,
    sampling: BrdfSampling,
) -> Image {
    let dataset = renderer.dataset();
    let surfaces = Surfaces::of(renderer).filtered(Differentials::of(view));
    let mut painter = Painter::new(view, dataset, light, sampling);
    let Background::Flat(background) = view.background else { panic!("the twin test has a flat background") };
    let geometry = gpu.read_geometry();
    Image::from_fn(view.size, |x, y| {
        let [id, b, c, flags] = geometry[(y * view.size[0] + x) as usize];
        if id == 0 {
            return if view.mode == ViewMode::Shaded { background } else { Vec3::ZERO };
        }
        let back_face = flags & 0x100 != 0;
        if back_face && !dataset.two_sided[id as usize - 1] {
            return Vec3::ZERO;
        }
        let barycentric = Vec2::new(f32::from_bits(b), f32::from_bits(c));
        let hit = Hit { triangle: id - 1, distance: 0.0, barycentric, back_face };
        let pixel = Vec2::new(x as f32, y as f32) + 0.5;
        let wo = -view.camera.direction_through(pixel, view.size);
        let point = surfaces.point(&hit, wo);
        let shown = LightPart::ALL.into_iter().zip(light.parts(view.mode)).filter(|(_, shown)| *shown);
        shown.map(|(part, _)| painter.part(part, &point, Vec2::ZERO, SeenOfParts::default())).sum()
    })
}

/// Relative root mean square error, and the largest difference as a fraction of the mean.
pub(super) fn difference(a: &Image, b: &Image) -> (f64, f64) {
    let sum = |f: &dyn Fn(Vec3, Vec3) -> f32| -> f64 {
        a.pixels.iter().zip(&b.pixels).map(|(&a, &b)| f64::from(f(a, b))).sum()
    };
    let error = sum(&|a, b| (a - b).length_squared());
    let mean = sum(&|_, b| b.element_sum()) / (3 * b.pixels.len()) as f64;
    let largest = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    ((error / sum(&|_, b| b.length_squared())).sqrt(), f64::from(largest) / mean)
}

pub(super) fn agrees(a: &Image, b: &Image) -> bool {
    let (relative, largest) = difference(a, b);
    relative < 1e-4 && largest < 0.01
}

pub(super) fn parameters(roughness: f32, anisotropy: f32) -> GgxParameters {
    GgxParameters {
        base_color: Vec3::new(0.8, 0.5, 0.3),
        roughness,
        metalness: 0.4,
        anisotropy,
        ior: 1.6,
        specular: 0.9,
        edge_color: Vec3::new(0.9, 0.8, 0.7),
    }
}

/// Values of a model's parameters from its list: the widths are from a third of the range on.
fn settings(model: BrdfModel, case: u64) -> Parameters {
    let mut random = fastrand::Rng::with_seed(case);
    let mut settings = Parameters::default();
    let material = Material { model, file: example_file(model), ..Default::default() };
    for p in material.declared() {
        let [low, high] = p.slider;
        let low = if p.name.ends_with("roughness") { 0.35 } else { low };
        let mut number = || low + (high - low) * random.f32();
        match p.is_color() {
            true => settings.set(p.name, Vec3::new(number(), number(), number())),
            false => settings.set(p.name, number()),
        }
    }
    settings
}

pub(super) struct Rig {
    pub renderer: Renderer,
    pub gpu: GpuBackend,
    lighting: Arc<EnvironmentLight>,
    _one: MutexGuard<'static, ()>,
}

impl Rig {
    pub fn new(illum_cut: u32) -> Option<Self> {
        Self::of(scene(), illum_cut)
    }

    pub fn of(dataset: Arc<Dataset>, illum_cut: u32) -> Option<Self> {
        Self::with(&inexact::source(), dataset, illum_cut)
    }

    pub fn with(source: &ShaderSource, dataset: Arc<Dataset>, illum_cut: u32) -> Option<Self> {
        let (one, mut gpu) = backend_of(source)?;
        let renderer = Renderer::new(dataset);
        let lighting = renderer.lighting(&light(), illum_cut).into();
        gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
        gpu.set_light(&light(), &lighting).unwrap();
        Some(Self { renderer, gpu, lighting, _one: one })
    }

    pub fn lit(&self) -> PictureLight<'_> {
        PictureLight { environment: Some(&self.lighting), emission: true, ..Default::default() }
    }

    pub fn look(&mut self, appearance: Appearance) {
        assert!(self.gpu.set_appearance(&appearance).unwrap().is_empty());
        self.renderer.set_appearance(appearance);
    }

    /// Compiles all that these need at once. One by one each adds to what is compiled, which is compiled anew then.
    fn compile_for(&mut self, appearances: impl IntoIterator<Item = Appearance>) {
        let scene = &self.renderer.dataset().scene;
        let materials = appearances.into_iter().flat_map(|appearance| appearance.materials).collect();
        let assigned = Some(scene.mesh.triangle_material.clone().into());
        let all = Appearance { materials, assigned, ..Appearance::of(scene) };
        assert!(self.gpu.set_appearance(&all).unwrap().is_empty());
    }

    pub fn both(&mut self, view: &View, sampling: BrdfSampling) -> [Image; 2] {
        self.gpu.begin(view, sampling).unwrap();
        self.gpu.render_rows(0, 0..view.size[1]).unwrap();
        let gpu = self.gpu.read(1).unwrap().0;
        [gpu, on_the_cpu(&self.gpu, &self.renderer, view, self.lit(), sampling)]
    }
}

#[test]
fn every_model_and_sampling_agrees_and_another_roughness_does_not() {
    let Some(mut rig) = Rig::new(128) else { return };
    let dataset = rig.renderer.dataset().clone();
    let cases: Vec<_> = BrdfModel::ALL.iter().flat_map(|&model| (0..4).map(move |case| (model, case))).collect();
    let looks_as = |(model, case)| appearance(&dataset, model, settings(model, case), MaterialMaps::default());
    rig.compile_for(cases.iter().copied().map(looks_as));
    for case in cases {
        rig.look(looks_as(case));
        for sampling in [BrdfSampling::Lit, BrdfSampling::Refine, BrdfSampling::Once] {
            let [gpu, cpu] = rig.both(&view(ViewMode::Shaded), sampling);
            assert!(agrees(&gpu, &cpu), "{case:?} {sampling:?}: {:?}", difference(&gpu, &cpu));
        }
    }
    rig.look(appearance(&dataset, BrdfModel::Ward, parameters(0.5, -0.6), Default::default()));
    let [gpu, _] = rig.both(&view(ViewMode::Shaded), BrdfSampling::Refine);
    rig.renderer.set_appearance(appearance(&dataset, BrdfModel::Ward, parameters(0.51, -0.6), Default::default()));
    let other = on_the_cpu(&rig.gpu, &rig.renderer, &view(ViewMode::Shaded), rig.lit(), BrdfSampling::Refine);
    assert!(!agrees(&gpu, &other));
}

#[test]
fn textures_normal_and_bump_maps_agree_and_each_of_them_matters() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let look = |maps| appearance(&dataset, BrdfModel::Ggx, parameters(0.8, 0.3), maps);
    rig.look(look(maps()));
    let view = view(ViewMode::Shaded);
    let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
    assert!(agrees(&gpu, &cpu), "{:?}", difference(&gpu, &cpu));
    let mut flipped = maps();
    flipped.get_mut("normal").unwrap().flip_y = true;
    rig.renderer.set_appearance(look(flipped.clone()));
    let other = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
    assert!(!agrees(&gpu, &other));
    rig.look(look(flipped));
    let [flipped, cpu] = rig.both(&view, BrdfSampling::Refine);
    assert!(agrees(&flipped, &cpu), "{:?}", difference(&flipped, &cpu));
    // Those of emission and opacity have tests of their own.
    let has_own_test = |name: &str| name.starts_with("emission_") || name.contains("opacity");
    for name in map_names(BrdfModel::Ggx).filter(|name| !has_own_test(name)) {
        let mut fewer = maps();
        fewer.set(name, None);
        rig.renderer.set_appearance(look(fewer));
        let without = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
        assert!(!agrees(&gpu, &without), "the map {name} makes no difference");
    }
}

#[test]
fn maps_of_anisotropy_and_ior_agree_alone_and_each_of_them_matters() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let view = view(ViewMode::Shaded);
    let only = [&["anisotropy"][..], &["ior"], &["anisotropy", "ior"]].map(|kinds| {
        let mut only = maps();
        only.retain(|name, _| kinds.contains(&name));
        only
    });
    for model in [BrdfModel::Ggx, BrdfModel::Ward] {
        // Across the tangent, so that the sign travels too.
        let look = |maps| appearance(&dataset, model, parameters(0.5, -0.7), maps);
        for maps in &only {
            rig.look(look(maps.clone()));
            let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
            assert!(agrees(&gpu, &cpu), "{model:?}: {:?}", difference(&gpu, &cpu));
            rig.renderer.set_appearance(look(MaterialMaps::default()));
            let without = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
            assert!(difference(&gpu, &without).0 > 1e-3, "{model:?}: {:?}", difference(&gpu, &without));
        }
    }
}

#[test]
fn every_view_mode_agrees_and_is_told_from_the_next() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    rig.look(appearance(&dataset, BrdfModel::Ggx, parameters(0.7, 0.2), maps()));
    // Those of the meshless basis need one: see there.
    let modes: Vec<ViewMode> = ViewMode::ALL.into_iter().filter(|mode| !mode.is_of_bounce()).collect();
    for (i, &mode) in modes.iter().enumerate() {
        let [gpu, cpu] = rig.both(&view(mode), BrdfSampling::Refine);
        assert!(agrees(&gpu, &cpu), "{mode:?}: {:?}", difference(&gpu, &cpu));
        let next = view(modes[(i + 1) % modes.len()]);
        let other = on_the_cpu(&rig.gpu, &rig.renderer, &next, rig.lit(), BrdfSampling::Refine);
        assert!(!agrees(&gpu, &other), "{mode:?}");
    }
}

#[test]
fn what_a_display_shows_agrees_with_the_cpu_backend_but_at_silhouettes() {
    let Some(mut rig) = Rig::new(64) else { return };
    let mut cpu = CpuBackend::new();
    cpu.set_scene(&rig.renderer.dataset().clone().into()).unwrap();
    cpu.set_light(&light(), &rig.lighting).unwrap();
    let shown = |view: &View, backend: &mut dyn Backend| {
        backend.begin(view, BrdfSampling::Refine).unwrap();
        (0..view.aa).for_each(|sample| backend.render_rows(sample, 0..view.size[1]).unwrap());
        backend.display(&Post::default(), view.aa).unwrap()
    };
    let differing = |a: &[[u8; 4]], b: &[[u8; 4]]| {
        let differs = |(a, b): &(&[u8; 4], &[u8; 4])| (0..4).any(|c| a[c].abs_diff(b[c]) > 2);
        a.iter().zip(b).filter(differs).count() as f32 / a.len() as f32
    };
    for mode in ViewMode::ALL {
        for (wireframe, background) in [(false, Background::Transparent), (true, Background::Environment)] {
            let view = View { wireframe, background, aa: 2, ..view(mode) };
            let (on_gpu, on_cpu) = (shown(&view, &mut rig.gpu), shown(&view, &mut cpu));
            assert!(differing(&on_gpu, &on_cpu) < 0.01, "{mode:?} {wireframe}: {}", differing(&on_gpu, &on_cpu));
            let without = shown(&View { wireframe: !wireframe, ..view }, &mut cpu);
            assert!(differing(&on_gpu, &without) > 0.05, "{mode:?} {wireframe}");
        }
    }
}

#[test]
fn the_paper_s_loop_is_told_from_the_refined_one() {
    let Some(mut rig) = Rig::new(32) else { return };
    let dataset = rig.renderer.dataset().clone();
    rig.look(appearance(&dataset, BrdfModel::Ggx, parameters(0.3, 0.0), MaterialMaps::default()));
    let [refined, _] = rig.both(&view(ViewMode::Shaded), BrdfSampling::Refine);
    let [once, _] = rig.both(&view(ViewMode::Shaded), BrdfSampling::Once);
    assert!(!agrees(&refined, &once));
}

#[test]
fn lit_cuts_have_as_many_nodes_as_on_the_cpu_for_every_tau() {
    let Some(mut rig) = Rig::new(1) else { return };
    let dataset = rig.renderer.dataset().clone();
    rig.look(appearance(&dataset, BrdfModel::Ggx, parameters(0.3, 0.0), MaterialMaps::default()));
    let mut means = Vec::new();
    for tau in [0.0, 0.003, 0.1, 1.0] {
        rig.lighting = rig.renderer.lighting(&light(), 1).with_tau(tau).into();
        rig.gpu.set_light(&light(), &rig.lighting).unwrap();
        for mode in [ViewMode::Shaded, ViewMode::MergedCut] {
            let [gpu, cpu] = rig.both(&view(mode), BrdfSampling::Lit);
            assert!(agrees(&gpu, &cpu), "{tau} {mode:?}: {:?}", difference(&gpu, &cpu));
        }
        means.push(rig.gpu.stats().unwrap().mean_merged_nodes);
    }
    assert!(means[1] < 0.5 * means[0], "negative control: {means:?}");
    let stored = rig.both(&view(ViewMode::MergedCut), BrdfSampling::Refine);
    assert!((rig.gpu.stats().unwrap().mean_merged_nodes - means[0]).abs() < 1e-6, "tau 0 merges the stored nodes");
    assert!(agrees(&stored[0], &stored[1]));
}

/// All samples of a view, each in bands that end at these rows.
pub(super) fn in_bands(gpu: &mut GpuBackend, view: &View, ends: &[u32]) -> Image {
    gpu.begin(view, BrdfSampling::Refine).unwrap();
    for sample in 0..view.aa {
        let mut start = 0;
        for &end in ends {
            gpu.render_rows(sample, start..end).unwrap();
            start = end;
        }
    }
    gpu.read(view.aa).unwrap().0
}

#[test]
fn bands_and_jittered_samples_add_up_to_the_whole() {
    let Some(mut rig) = Rig::new(64) else { return };
    let view = View { aa: 3, ..view(ViewMode::Shaded) };
    let mut whole = |ends: &[u32]| (in_bands(&mut rig.gpu, &view, ends), rig.gpu.stats().unwrap());
    let (one, stats) = whole(&[56]);
    assert!(whole(&[1, 17, 17, 56]).0 == one);
    assert!(in_bands(&mut rig.gpu, &View { aa: 2, ..view.clone() }, &[56]) != one, "negative control");
    assert!(stats.pixels_shaded > 1000 && stats.mean_merged_nodes > 64.0, "{stats:?}");
    let cpu = rig.renderer.render_lit(&view, &light(), &rig.lighting, BrdfSampling::Refine);
    // Silhouettes may fall on either side of a sample; the rest agrees.
    assert!(difference(&one, &cpu.0).0 < 0.02, "{:?}", difference(&one, &cpu.0));
    assert!((stats.mean_merged_nodes / cpu.1.mean_merged_nodes - 1.0).abs() < 0.01);
    assert!((stats.mean_brdf_evaluations / cpu.1.mean_brdf_evaluations - 1.0).abs() < 0.01);
}

#[test]
fn samples_through_a_lens_agree_and_so_does_a_shifted_picture() {
    let Some(mut rig) = Rig::new(64) else { return };
    let straight = View { aa: 5, ..view(ViewMode::Shaded) };
    let mut shot = |lens: Lens| {
        let view = View { camera: Camera { lens, ..straight.camera.clone() }, ..straight.clone() };
        let gpu = in_bands(&mut rig.gpu, &view, &[56]);
        (gpu, rig.renderer.render_lit(&view, &light(), &rig.lighting, BrdfSampling::Refine).0)
    };
    let (sharp, _) = shot(Lens::default());
    for lens in [
        Lens { f_number: Some(0.05), focus: Some(2.0), ..Lens::default() },
        Lens { shift: Vec2::new(0.1, -0.2), ..Lens::default() },
    ] {
        let (gpu, cpu) = shot(lens);
        assert!(difference(&gpu, &cpu).0 < 0.02, "{lens:?}: {:?}", difference(&gpu, &cpu));
        assert!(difference(&gpu, &sharp).0 > 0.05, "negative control, {lens:?}: {:?}", difference(&gpu, &sharp));
    }
}

#[test]
fn the_environment_behind_agrees_with_the_map_and_turns() {
    let Some(mut rig) = Rig::new(16) else { return };
    let camera = Camera::look_at(Vec3::new(0.0, 30.0, 0.0), Vec3::new(0.3, 31.0, 1.0), 120.0);
    for background in [Background::Environment, Background::Blurred(0.2)] {
        let view = View { background, ..View::new(camera.clone(), [64, 64]) };
        rig.gpu.begin(&view, BrdfSampling::Refine).unwrap();
        rig.gpu.render_rows(0, 0..64).unwrap();
        let (gpu, coverage) = rig.gpu.read(1).unwrap();
        let cpu = rig.renderer.render_lit(&view, &light(), &rig.lighting, BrdfSampling::Refine).0;
        let sky: Vec<usize> = (0..64 * 64).filter(|&i| coverage[i] == 0.0).collect();
        assert!(sky.len() > 2000);
        let only = |image: &Image| Image {
            size: [sky.len() as u32, 1],
            pixels: sky.iter().map(|&i| image.pixels[i]).collect(),
        };
        let d = difference(&only(&gpu), &only(&cpu));
        assert!(d.0 < 2e-3, "{background:?}: {d:?}");
        let turned = Illumination { rotation: 0.72, ..light() };
        let other = rig.renderer.render_lit(&view, &turned, &rig.lighting, BrdfSampling::Refine).0;
        assert!(difference(&only(&gpu), &only(&other)).0 > 2e-3);
    }
}

#[test]
fn tone_curves_agree_to_a_code_value_and_are_told_apart() {
    let Some(mut rig) = Rig::new(64) else { return };
    let view = view(ViewMode::Shaded);
    rig.gpu.begin(&view, BrdfSampling::Refine).unwrap();
    rig.gpu.render_rows(0, 0..view.size[1]).unwrap();
    let linear = rig.gpu.read(1).unwrap().0;
    let light = |i: u32, post: &Post| vignetted(post.vignette, [i % view.size[0], i / view.size[0]], view.size);
    let codes = |post: Post| -> Vec<Vec3> {
        (0..).zip(&linear.pixels).map(|(i, &p)| post.display(p * light(i, &post)) * 255.0).collect()
    };
    for tone_map in ToneMap::ALL {
        let post = Post { exposure: 0.5, tone_map, vignette: 0.7 };
        let shown = rig.gpu.display(&post, 1).unwrap();
        let worst = |codes: &[Vec3]| {
            let distance =
                |(s, c): (&[u8; 4], &Vec3)| (Vec3::new(s[0].into(), s[1].into(), s[2].into()) - *c).abs().max_element();
            shown.iter().zip(codes).map(distance).fold(0.0, f32::max)
        };
        assert!(shown.iter().all(|p| p[3] == 255));
        assert!(worst(&codes(post)) < 1.0, "{tone_map:?}: {}", worst(&codes(post)));
        assert!(worst(&codes(Post { vignette: 0.2, ..post })) > 1.5, "{tone_map:?}");
        assert!(worst(&codes(Post { exposure: 0.6, ..post })) > 1.5, "{tone_map:?}");
        let next = ToneMap::ALL[(tone_map as usize + 1) % ToneMap::ALL.len()];
        assert!(worst(&codes(Post { tone_map: next, ..post })) > 1.5, "{tone_map:?}");
    }
}

#[test]
fn a_dataset_or_picture_beyond_the_limits_is_an_error_with_both_numbers() {
    let Some(mut rig) = Rig::new(16) else { return };
    let huge = View { size: [9000, 2], ..view(ViewMode::Shaded) };
    let message = rig.gpu.begin(&huge, BrdfSampling::Refine).unwrap_err().to_string();
    assert!(message.contains("9000") && message.contains("8192"), "{message}");
    let mut large = (*scene()).clone();
    let vertices = (128 << 20) / size_of::<Vertex>() + 1;
    large.scene.mesh.positions.resize(vertices, Vec3::ZERO);
    let message = rig.gpu.set_scene(&large.into()).unwrap_err().to_string();
    assert!(
        message.contains(&format!("{}", vertices * size_of::<Vertex>())) && message.contains("134217728"),
        "{message}"
    );
    // What was there before is still shown.
    let [gpu, cpu] = rig.both(&view(ViewMode::Shaded), BrdfSampling::Refine);
    assert!(agrees(&gpu, &cpu));
}

/// What is not there is the same magenta on both, and told from a white surface.
#[test]
fn a_brdf_whose_file_is_not_there_is_magenta() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let view = view(ViewMode::Shaded);
    for model in [BrdfModel::Merl, BrdfModel::Wgsl] {
        let mut missing = appearance(&dataset, model, Parameters::default(), MaterialMaps::default());
        missing.materials.iter_mut().for_each(|material| material.file = None);
        rig.look(missing);
        let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
        assert!(agrees(&gpu, &cpu), "{model:?}: {:?}", difference(&gpu, &cpu));
        let white = Parameters::default().with("base_color", Vec3::ONE);
        rig.renderer.set_appearance(appearance(&dataset, BrdfModel::Lambert, white, MaterialMaps::default()));
        let other = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
        assert!(!agrees(&gpu, &other), "negative control: {model:?}");
    }
}
