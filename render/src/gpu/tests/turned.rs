//! Light of a turned environment by kernels and on the cores: all nodes, and pictures.

use super::{
    inexact,
    twin::{Rig, agrees, backend, difference, scene, view},
};
use crate::{
    Backend, Baked, BrdfSampling, EnvironmentLight, Illumination, LightRig, LitScene, Look, ViewMode,
    device::{
        Shaders, SharedDevice,
        layout::Node,
        readback::read_range,
        test_adapter::{on_adapter, shared_device},
    },
    gpu::{GpuBackend, ShaderSource, turned::GpuSamples},
    light::{
        environment::TurnedMap,
        node_row::{NodeExtent, NodeRow},
        situation::Gathering,
    },
    test_scenes::illumination,
};
use glam::Vec3;
use lapidary_core::{
    color::luminance,
    image::Image,
    light_tree::{LightTree, means_up_the_tree},
};
use std::sync::Arc;

/// Cells of a leaf are summed in another order, and cards contract products and sums and are off by some units in quotients and roots.
/// A leaf has some hundred cells of positive energy, whose rounding adds up to some units in the last place. This is 32 of them.
const TOLERANCE: f32 = 32.0 * f32::EPSILON;

const GATHERING: Gathering = Gathering { illum_cut: 1, tau: 0.003 };

/// Dark below, with small lamps above: some nodes are dark, others have a leaf of most of the light.
fn lamps() -> Illumination {
    illumination([96, 48], |x, y| {
        let lamp = if x % 31 == 7 && y == 9 { Vec3::new(900.0, 500.0, 200.0) } else { Vec3::ZERO };
        let sky = Vec3::new(0.2 + 0.01 * x as f32, 0.5, 1.0 + 0.02 * y as f32);
        if y < 24 { sky + lamp } else { Vec3::ZERO }
    })
}

fn black() -> Illumination {
    illumination([4, 2], |_, _| Vec3::ZERO)
}

/// What the kernels find under a map.
fn by_kernels(device: &SharedDevice, samples: &mut GpuSamples, turned: &TurnedMap) -> (Vec<Node>, Vec<f32>) {
    let (gpu, all) = (&device.gpu, 0..2 * turned.samples.tree.len());
    let light = samples.light(gpu, turned).unwrap();
    (read_range(gpu, &light.nodes, all.clone()).unwrap(), read_range(gpu, &light.brightness, all).unwrap())
}

/// Lengths of the mean directions of the nodes, weighted by luminance.
fn resultants(tree: &LightTree, leaves: &[Vec3]) -> Vec<f32> {
    let luminances: Vec<f32> = leaves.iter().map(|&leaf| luminance(leaf)).collect();
    let weighted: Vec<Vec3> = tree.leaf_directions().iter().zip(&luminances).map(|(&d, &l)| d * l).collect();
    let means = means_up_the_tree(&weighted).into_iter().zip(means_up_the_tree(&luminances));
    let plain = tree.mean_directions();
    means.zip(plain).map(|((d, l), plain)| if l > 0.0 { (d / l).length() } else { plain.length() }).collect()
}

/// What differs from the light on the cores, in sentences. A mean direction is off by the tolerance; its unit vector by as much over its
/// length, and its spread by as much times how fast that changes with the length.
fn differences(turned: &TurnedMap, (nodes, brightness): &(Vec<Node>, Vec<f32>)) -> Vec<String> {
    let (tree, lighting) = (&turned.samples.tree, turned.lighting());
    let lengths = resultants(tree, &lighting.nodes.radiance[tree.len()..]);
    let differs = |i: usize| {
        let (row, extent): (&NodeRow, &NodeExtent) = (&lighting.rows[i], &lighting.extents[i]);
        let (node, length) = (&nodes[i], lengths[i].clamp(1e-4, 1.0));
        let is_near = |found: f32, expected: f32, scale: f32| (found - expected).abs() <= TOLERANCE * scale;
        let are_near = |found: [f32; 3], expected: Vec3, scale: f32| {
            found.into_iter().zip(expected.to_array()).all(|(found, expected)| is_near(found, expected, scale))
        };
        let agrees = are_near(node.radiance, row.radiance, row.radiance.max_element())
            && are_near(node.place, row.place, 1.0 / length)
            && is_near(node.spread, row.spread, 1.0 + row.spread / length)
            && node.radius == extent.radius
            && is_near(brightness[i], extent.brightness, extent.brightness);
        (!agrees).then(|| format!("node {i}: {node:?} {} for {row:?} {extent:?}", brightness[i]))
    };
    (0..nodes.len()).filter_map(differs).collect()
}

/// What becomes of a program's text.
type Change = fn(&str) -> String;

/// Kernels with an error each.
const ERRORS: [Change; 5] = [
    |text| text.replace("(column + 1u) & within", "column & within"),
    |text| text.replace("(left.luminance_sq + right.luminance_sq)", "(left.luminance_sq + left.luminance_sq)"),
    |text| text.replace("if mean.luminance > 0.0", "if mean.luminance >= 0.0"),
    |text| text.replace(" + turned.leaf_spread", ""),
    |text| text.replace("ratio > 1.0", "ratio > 0.0"),
];

#[test]
fn errors_in_kernels_are_found() {
    let Some((_one, device)) = on_adapter(shared_device) else { return };
    let mut rig = LightRig::new(&LightTree::geometric(256).unwrap());
    let light = rig.light(&Illumination { rotation: 0.3, ..lamps() }, GATHERING);
    let turned = light.turned().unwrap();
    for (i, change) in ERRORS.into_iter().enumerate() {
        let shaders = Shaders { source: ShaderSource::Changed(change), ..Default::default() };
        let mut samples = GpuSamples::new(&device, &shaders, &turned.samples).unwrap();
        assert!(!differences(turned, &by_kernels(&device, &mut samples, turned)).is_empty(), "error {i}");
    }
}

#[test]
fn kernels_find_the_nodes_of_the_cores_and_not_those_of_another_rotation() {
    let Some((_one, device)) = on_adapter(shared_device) else { return };
    let shaders = Shaders { source: inexact::source(), ..Default::default() };
    for lights in [2, 64, 256, 1024] {
        let mut rig = LightRig::new(&LightTree::geometric(lights).unwrap());
        let mut samples: Option<GpuSamples> = None;
        for (map, rotation, intensity) in
            [(lamps(), 0.0, 1.0), (lamps(), 2.5, 0.3), (lamps(), -7.1, 40.0), (black(), 0.4, 1.0), (lamps(), 0.1, 0.0)]
        {
            let mut turned = |rotation| {
                let light = rig.light(&Illumination { rotation, intensity, ..map.clone() }, GATHERING);
                light.turned().unwrap().clone()
            };
            let (at, beside) = (turned(rotation), turned(rotation + 0.02));
            let samples = samples.get_or_insert_with(|| GpuSamples::new(&device, &shaders, &at.samples).unwrap());
            let found = by_kernels(&device, samples, &at);
            assert_eq!(differences(&at, &found), Vec::<String>::new(), "{lights} lights, {rotation} {intensity}");
            let is_dark = at.lighting().nodes.radiance[1] == Vec3::ZERO;
            assert!(
                is_dark || !differences(&beside, &found).is_empty(),
                "negative control: {lights} lights, {rotation}"
            );
            assert!(!is_dark || found.1.iter().all(|&brightness| brightness == 1.0));
        }
    }
}

fn drawn(
    gpu: &mut GpuBackend,
    light: &Illumination,
    lighting: &Arc<EnvironmentLight>,
    sampling: BrdfSampling,
) -> Image {
    let view = view(ViewMode::Shaded);
    gpu.set_light(light, lighting).unwrap();
    gpu.begin(&view, sampling).unwrap();
    gpu.render_rows(0, 0..view.size[1]).unwrap();
    gpu.read(1).unwrap().0
}

/// The kernels, with an error in one of them.
fn without_kernels(text: &str) -> String {
    text.replace("fn light_leaves(", "fn light_leaves(no_such_input: f32, ")
}

#[test]
fn pictures_are_as_with_light_of_the_cores_also_where_kernels_fail() {
    for (source, fail) in [(inexact::source(), false), (ShaderSource::Changed(without_kernels), true)] {
        let Some(mut rig) = Rig::with(&source, scene(), 1) else { return };
        rig.gpu.light_by_kernels();
        for (sampling, illum_cut) in [(BrdfSampling::Lit, 64), (BrdfSampling::Refine, 64), (BrdfSampling::Once, 1)] {
            let gathering = Gathering { illum_cut, ..GATHERING };
            let light = |rotation: f32| {
                let light = Illumination { rotation, ..lamps() };
                let turned: Arc<EnvironmentLight> = rig.renderer.rig().light(&light, gathering).into();
                (turned.turned().unwrap().lighting().into(), turned, light)
            };
            let ((on_cores, turned, at), (_, beside, other)) = (light(2.0), light(2.2));
            let expected = drawn(&mut rig.gpu, &at, &on_cores, sampling);
            let found = drawn(&mut rig.gpu, &at, &turned, sampling);
            assert!(agrees(&found, &expected), "{sampling:?}: {:?}", difference(&found, &expected));
            let needs_cut = sampling != BrdfSampling::Lit && illum_cut > 1;
            assert_eq!(turned.computed().is_some(), fail || needs_cut, "{sampling:?}, kernels fail: {fail}");
            assert!(!agrees(&drawn(&mut rig.gpu, &other, &beside, sampling), &expected), "negative control");
        }
    }
}

#[test]
fn a_turned_environment_is_not_lit_on_the_cores() {
    let Some((_one, mut gpu)) = backend() else { return };
    gpu.light_by_kernels();
    let baked = Baked::from((*scene()).clone());
    let look = Look::under_environment(&baked.dataset.scene, view(ViewMode::Shaded), lamps());
    let turned = Look { illumination: Illumination { rotation: 1.0, ..lamps() }, ..look.clone() };
    let mut scene = LitScene::<dyn Backend>::new(Box::new(gpu), baked.clone()).unwrap();
    for look in [&look, &turned] {
        scene.show_whole(look).unwrap();
        assert!(scene.environment().unwrap().computed().is_none());
    }
    scene.show_whole(&Look { sampling: BrdfSampling::Refine, ..turned }).unwrap();
    assert!(scene.environment().unwrap().computed().is_some(), "negative control: it merges an illumination cut");
}
