//! Bounced light of wavelet transport on the GPU and by the CPU renderer, at what the deferred pass saw: every BRDF, with textures,
//! normal and bump maps, on quads with few and with many cells of directions. Each comparison has a negative control.

use super::twin::{appearance, backend, difference, maps, on_the_cpu, parameters, scene, view};
use crate::{
    Backend, Background, Baked, BounceLight, BrdfSampling, Components, LocalLighting, LocalRig, Renderer, Solution,
    View, ViewMode,
    gpu::GpuBackend,
    shade::painter::PictureLight,
    test_scenes::{Edited, point_light},
};
use glam::{Mat3, UVec2, Vec3};
use lapidary_core::{
    dataset::Dataset,
    image::Image,
    material::{BrdfModel, MaterialMaps},
    sphere::concentric::HemisphereCells,
    wavelet::{
        WaveletTransport,
        operator::{Operator, RadianceFunction, TransportCoefficient},
        patch::Patch,
        reflecting::ReflectingPatch,
        square::{Function, Node, transform},
    },
};
use std::sync::Arc;

/// All functions of a square down to a level.
fn functions(level: u32) -> Vec<Function> {
    let cells = 1 << level;
    let node = |i: u32| Node::of_cell(level, UVec2::new(i % cells, i / cells));
    let mut smooth: Vec<(Node, f32)> = (0..cells * cells).map(|i| (node(i), (i * i) as f32 + 1.0)).collect();
    let mut found = Vec::new();
    transform(&mut smooth, |function, _| found.push(function));
    found
}

/// Two quads over the halves of the floor, with 8 x 8 cells and with one, which get other light at each function.
fn with_transport(mut dataset: Dataset) -> Dataset {
    let quad = |corner: Vec3| Patch {
        corner,
        edges: [Vec3::Z * 4.0, Vec3::X * 2.0],
        frame: Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y),
        area: 8.0,
        material: 0,
        object: 0,
    };
    let halves = [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(0.0, 0.0, -2.0)].map(quad);
    let mut patches = ReflectingPatch::all(halves.into(), &dataset.scene.materials);
    patches.iter_mut().zip([8, 1]).for_each(|(patch, side)| patch.cells = HemisphereCells { side });
    let constant = |patch| RadianceFunction { patch, space: Function::CONSTANT, angle: Function::CONSTANT };
    let mut random = fastrand::Rng::with_seed(5);
    let of_patch = [(0, 3), (1, 0)].into_iter().flat_map(|(patch, level)| {
        let angles = if level == 0 { vec![Function::CONSTANT] } else { functions(level) };
        let spaces = functions(2).into_iter();
        spaces.flat_map(move |space| {
            angles.clone().into_iter().map(move |angle| RadianceFunction { patch, space, angle })
        })
    });
    let coefficients = of_patch.map(|receiver| TransportCoefficient {
        receiver,
        sender: constant(receiver.patch),
        value: Vec3::new(random.f32(), random.f32(), random.f32())
            * if receiver == constant(receiver.patch) { 9.0 } else { 1.0 },
    });
    let (basis, direct) = Operator::of(coefficients.collect());
    let global = Operator::identity(basis.functions().len());
    dataset.wavelet = Some(WaveletTransport { patches, basis, direct, global }.into());
    dataset
}

pub(super) fn baked() -> Baked {
    Baked::from(with_transport((*scene()).clone()))
}

pub(super) fn lit(baked: &Baked, intensity: f32) -> BounceLight {
    let mut rig = Edited::new(baked, LocalRig::new(baked));
    rig.set_lights(&Arc::from([point_light(Vec3::new(0.4, 3.0, 0.5), intensity)]));
    rig.lighting(Components::ALL, Solution::Wavelet, 64).bounce.expect("light of quads")
}

/// Share of the pixels that differ by more than a thousandth of the mean: some look along the edge of a cell, to either side of it.
fn differing(a: &Image, b: &Image) -> f64 {
    let mean = b.pixels.iter().map(|pixel| pixel.element_sum()).sum::<f32>() / (3 * b.pixels.len()) as f32;
    let differs = |(a, b): &(&Vec3, &Vec3)| (**a - **b).abs().max_element() > 1e-3 * mean;
    a.pixels.iter().zip(&b.pixels).filter(differs).count() as f64 / b.pixels.len() as f64
}

fn dark_view() -> View {
    View { background: Background::Flat(Vec3::ZERO), ..view(ViewMode::Shaded) }
}

pub(super) fn picture(gpu: &mut GpuBackend, bounce: &BounceLight) -> Image {
    let components = Components { indirect: true, ..Components::NONE };
    let local = LocalLighting { bounce: Some(bounce.clone()), components, ..Default::default() };
    gpu.set_local_lighting(&local).unwrap();
    gpu.begin(&dark_view(), BrdfSampling::Refine).unwrap();
    gpu.render_rows(0, 0..dark_view().size[1]).unwrap();
    gpu.read(1).unwrap().0
}

#[test]
fn pixels_agree_for_every_brdf_with_maps_and_bumps() {
    let Some((_one, mut gpu)) = backend() else { return };
    let baked = baked();
    let mut renderer = Renderer::new(baked.dataset.clone());
    gpu.set_scene(&baked).unwrap();
    let (light, brighter) = (lit(&baked, 8.0), lit(&baked, 9.0));
    for (model, maps) in [
        (BrdfModel::Lambert, MaterialMaps::default()),
        (BrdfModel::Ggx, MaterialMaps::default()),
        (BrdfModel::Ggx, maps()),
        (BrdfModel::Ward, maps()),
    ] {
        let look = appearance(renderer.dataset(), model, parameters(0.5, 0.3), maps);
        assert!(gpu.set_appearance(&look).unwrap().is_empty());
        renderer.set_appearance(look);
        let shown = picture(&mut gpu, &light);
        let light_of = |light| PictureLight { bounce: Some(light), ..Default::default() };
        let expected = on_the_cpu(&gpu, &renderer, &dark_view(), light_of(&light), BrdfSampling::Refine);
        assert!(differing(&shown, &expected) < 0.002, "{model:?}: {:?}", difference(&shown, &expected));
        assert!(expected.pixels.iter().any(|pixel| pixel.max_element() > 0.01), "{model:?} is lit");
        let other = on_the_cpu(&gpu, &renderer, &dark_view(), light_of(&brighter), BrdfSampling::Refine);
        assert!(differing(&shown, &other) > 0.2, "{model:?}: negative control");
    }
}
