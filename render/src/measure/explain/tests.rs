//! Explanations against the renderer, for both trees; each with a negative control.

use super::{cut_map::CutMap, *};
use crate::{
    Backend, Background, BounceLight, Components, CpuBackend, Illumination, LocalLighting, SceneLighting,
    SourceLighting,
    test_scenes::{LIGHTS, dataset, floor_and_wall, from_the_side, glossy, illumination, mesh, white},
};
use lapidary_core::{
    camera::Camera,
    image::Image,
    material::BrdfModel,
    sources::{Source, SourceTree},
    surfel::{MeshPlace, Surfel},
};
use std::sync::Arc;

const SIZE: u32 = 24;

/// A glossy floor under a blocker and a sky with a bright patch.
fn prepared() -> (Renderer, View, SceneLighting, Illumination) {
    let mut dataset = dataset(mesh(16, true), glossy(0.4));
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    let renderer = Renderer::new(dataset);
    let light = illumination([64, 32], |x, y| Vec3::new(0.3, 0.2, if x > 40 && y < 10 { 30.0 } else { 0.1 }));
    let lighting = renderer.lighting(&light, 64);
    // By cuts alone, which it explains.
    (renderer, View { mirrors: false, ..from_the_side(SIZE) }, lighting, light)
}

/// Largest difference of explained and rendered pixels relative to the brightest, and the number of pixels.
fn difference(
    renderer: &Renderer,
    view: &View,
    light: CutLight,
    sampling: BrdfSampling,
    picture: &Image,
) -> (f32, usize) {
    let (mut worst, mut count) = (0.0_f32, 0);
    let brightest = picture.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    for y in 0..view.size[1] {
        for x in 0..view.size[0] {
            let Ok(explanation) = renderer.explain(view, [x, y], light, sampling) else { continue };
            let rendered = picture.at(x as usize, y as usize);
            let sum: Vec3 = explanation.nodes.iter().map(product).sum();
            worst = worst.max((explanation.radiance - rendered).abs().max_element() / brightest);
            worst = worst.max((sum - rendered).abs().max_element() / brightest);
            count += 1;
        }
    }
    (worst, count)
}

/// A node's contribution as the product of its factors.
fn product(node: &ExplainedNode) -> Vec3 {
    node.radiance * node.brdf_cos * node.visibility * node.solid_angle
}

#[test]
fn contributions_sum_to_the_rendered_pixel() {
    let (renderer, view, lighting, light) = prepared();
    for sampling in [BrdfSampling::Once, BrdfSampling::Refine] {
        let picture = renderer.render_lit(&view, &light, &lighting, sampling).0;
        let (worst, count) = difference(&renderer, &view, CutLight::Environment(&lighting), sampling, &picture);
        assert!(worst < 1e-5 && count > 200, "{sampling:?}: {worst} of {count} pixels");
    }
    let once = renderer.render_lit(&view, &light, &lighting, BrdfSampling::Once).0;
    let (other, _) = difference(&renderer, &view, CutLight::Environment(&lighting), BrdfSampling::Refine, &once);
    assert!(other > 1e-3, "negative control: another sampling is seen, {other}");
}

#[test]
fn a_dropped_node_is_missed() {
    let (renderer, view, lighting, _) = prepared();
    let explanation =
        renderer.explain(&view, [12, 16], CutLight::Environment(&lighting), BrdfSampling::Refine).unwrap();
    let order = explanation.by_contribution();
    let shares: Vec<f32> = order.iter().map(|&i| luminance(explanation.nodes[i].contribution)).collect();
    assert!(shares.is_sorted_by(|a, b| a >= b) && shares.len() == explanation.nodes.len());
    let without: Vec3 = order[1..].iter().map(|&i| explanation.nodes[i].contribution).sum();
    assert!((without - explanation.radiance).length() > 1e-5 * explanation.radiance.length());
}

#[test]
fn nodes_and_dark_nodes_are_a_cut() {
    let (renderer, view, lighting, _) = prepared();
    let explanation =
        renderer.explain(&view, [12, 16], CutLight::Environment(&lighting), BrdfSampling::Refine).unwrap();
    let heap = explanation.nodes.iter().map(|node| node.heap_index);
    let mut covered: Vec<usize> =
        heap.chain(explanation.dark_nodes.iter().copied()).flat_map(|node| leaves_below(node, LIGHTS)).collect();
    covered.sort_unstable();
    assert_eq!(covered, (0..LIGHTS).collect::<Vec<_>>());
    assert!(!explanation.dark_nodes.is_empty(), "below the floor nothing is seen");
    assert!(explanation.nodes.is_sorted_by_key(|node| leaves_below(node.heap_index, LIGHTS).start));
    let of_leaf = explanation.node_of_leaf(LIGHTS);
    let seen: u32 = explanation.nodes.iter().map(|node| node.leaves).sum();
    assert_eq!(of_leaf.iter().flatten().count(), seen as usize);
    let weights: f32 = explanation.vertices.iter().map(|vertex| vertex.weight).sum();
    assert!((weights - 1.0).abs() < 1e-5 && explanation.vertices.iter().all(|vertex| vertex.cut_nodes > 1));
    assert_eq!(explanation.illumination_nodes, 64);
}

#[test]
fn surface_sources_are_explained_with_their_places() {
    let renderer = Renderer::new(floor_and_wall(4));
    let sources = &renderer.dataset.indirect.as_ref().unwrap().sources;
    let leaf_radiance: Vec<Vec3> = (0..sources.len()).map(|i| Vec3::new(1.0, 0.1, (i % 7) as f32)).collect();
    let lighting = Arc::new(SourceLighting::new(Arc::new(SourceTree::new(sources)), &leaf_radiance, 32));
    let view = from_the_side(SIZE);
    let picture = rendered(&renderer, &view, &lighting);
    let light = CutLight::Sources(&lighting);
    let (worst, count) = difference(&renderer, &view, light, BrdfSampling::Refine, &picture);
    assert!(worst < 1e-5 && count > 200, "{worst} of {count} pixels");
    let explanation = renderer.explain(&view, [SIZE / 2, 2 * SIZE / 3], light, BrdfSampling::Refine).unwrap();
    let on_wall = |node: &ExplainedNode| node.center.is_some_and(|c| (c.x + 2.2).abs() < 1e-4 && c.y > 0.1);
    assert!(explanation.nodes.len() >= 16 && explanation.nodes.iter().all(on_wall));
    let map = renderer.cut_map(&explanation, light, 64);
    let wall = map.cut.pixels.iter().zip(&map.traced.pixels).filter(|(cut, traced)| cut.x > 0.0 && traced.x > 0.0);
    assert!(wall.count() > 20 && map.visibility.is_none(), "the wall is seen");
}

/// The bounce alone, by the interactive backend.
fn rendered(renderer: &Renderer, view: &View, lighting: &Arc<SourceLighting>) -> Image {
    let mut backend = CpuBackend::new();
    backend.set_scene(&renderer.dataset.clone().into()).unwrap();
    let components = Components { indirect: true, ..Components::NONE };
    let local =
        LocalLighting { bounce: Some(BounceLight::Sources(lighting.clone())), components, ..Default::default() };
    backend.set_local_lighting(&local).unwrap();
    backend.begin(&View { background: Background::Flat(Vec3::ZERO), ..view.clone() }, BrdfSampling::Refine).unwrap();
    backend.render_rows(0, 0..view.size[1]).unwrap();
    backend.read(1).unwrap().0
}

#[test]
fn pixels_that_have_no_cut_are_refused_with_a_reason() {
    let (renderer, mut view, lighting, _) = prepared();
    let explain =
        |view: &View, pixel| renderer.explain(view, pixel, CutLight::Environment(&lighting), BrdfSampling::Once);
    let outside = explain(&view, [SIZE, 3]).unwrap_err();
    assert!(matches!(outside, ExplainError::Outside { .. }) && outside.to_string().contains("24 x 24"), "{outside}");
    view.camera = Camera::look_at(Vec3::new(0.0, 1.0, 9.0), Vec3::new(0.0, 9.0, 0.0), 10.0);
    let sky = explain(&view, [3, 3]).unwrap_err();
    assert!(sky == ExplainError::Background { pixel: [3, 3] } && sky.to_string().contains("choose a pixel"), "{sky}");
    view.camera = Camera::look_at(Vec3::new(0.0, -6.0, 0.01), Vec3::ZERO, 30.0);
    assert_eq!(explain(&view, [12, 12]).unwrap_err(), ExplainError::Back { pixel: [12, 12] });
    let place = MeshPlace { triangle: 0, barycentric: glam::Vec2::ZERO };
    let surfel = Surfel { position: Vec3::Y, normal: Vec3::Y, place };
    let two = [Source { surfel, area: 1.0, spacing: 1.0 }; 2];
    let sources = SourceLighting::new(Arc::new(SourceTree::new(&two)), &[Vec3::ONE; 2], 1);
    let missing = renderer.explain(&from_the_side(SIZE), [12, 16], CutLight::Sources(&sources), BrdfSampling::Once);
    assert_eq!(missing.unwrap_err(), ExplainError::NoCuts(NoCuts::Sources));
}

#[test]
fn the_map_shows_exact_visibility_at_a_vertex_and_leaks_beside_the_shadow() {
    let mut dataset = dataset(mesh(4, true), white());
    // The blocker of this floor is one meter up and one meter wide; the vertices are one meter apart.
    dataset.scene.materials[0].double_sided = false;
    let renderer = Renderer::new(dataset);
    let light = illumination([64, 32], |_, _| Vec3::ONE);
    let lighting = renderer.lighting(&light, LIGHTS as u32);
    let mismatch = |target: Vec3| {
        let camera = Camera::look_at(target + Vec3::new(0.0, 0.4, 0.4), target, 0.1);
        let view = View::new(camera, [1, 1]);
        let light = CutLight::Environment(&lighting);
        let explanation = renderer.explain(&view, [0, 0], light, BrdfSampling::Once).unwrap();
        let map = renderer.cut_map(&explanation, light, 128);
        let coloured = |p: &&Vec3| (p.x - p.z).abs() > 0.2;
        map.visibility.unwrap().pixels.iter().filter(coloured).count()
    };
    // Slightly off the vertex, where rays find a definite triangle.
    let (at_vertex, between) = (mismatch(Vec3::new(1e-4, 0.0, 2e-4)), mismatch(Vec3::new(0.5, 0.0, 0.25)));
    assert!(at_vertex < 60, "{at_vertex} pixels are off at a vertex with an exact cut");
    assert!(between > 4 * at_vertex.max(30), "negative control: interpolation is off between vertices, {between}");
}

#[test]
fn borders_part_clusters_and_nothing_else() {
    let map = CutMap {
        cut: Image::filled([4, 2], Vec3::splat(2.0)),
        traced: Image::filled([4, 2], Vec3::splat(2.0)),
        visibility: None,
        cluster: vec![7, 7, 9, 9, 7, 7, 9, 9],
    };
    let bordered = map.with_borders(0.1);
    let is_border: Vec<bool> = bordered.pixels.iter().map(|p| (p.x - 0.2).abs() > 1e-6).collect();
    // The cluster changes to the right of column 1 and at the seam.
    assert_eq!(is_border, [false, true, false, true, false, true, false, true]);
    assert!((map.exposure() - 0.4).abs() < 1e-6);
}
