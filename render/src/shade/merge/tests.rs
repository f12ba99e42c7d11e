//! The merge in every instruction set, and its traversal of the tree.

use super::*;
use crate::{
    light::bounce::SourceLighting,
    renderer::Renderer,
    shade::surface::Surfaces,
    shade::{node_field::SourceField, surface::FirstHit},
    test_scenes::{dataset, floor_and_wall, from_the_side, glossy, illumination, mesh, surface_at},
};
use glam::Vec2;
use lapidary_core::{
    brdf::{BrdfModel, GgxParameters, example_file},
    material::Material,
    sources::SourceTree,
};

/// Bits of the radiance at one point in each instruction set, for each model and sampling.
fn bits_in_each_set<F: NodeField>(field: F, cuts: &PackedCuts, point: &SurfacePoint) -> Vec<Vec<[u32; 3]>> {
    let shaded = |instructions: InstructionSet| {
        let mut bits = Vec::new();
        for &model in BrdfModel::ALL {
            let parameters = GgxParameters { base_color: Vec3::new(0.6, 0.3, 0.1), ..glossy(0.4) };
            let material =
                Material { model, file: example_file(model), parameters: parameters.into(), ..Default::default() };
            let brdf = material.plain_brdf();
            let point = SurfacePoint { brdf, ..point.clone() };
            for sampling in [BrdfSampling::Once, BrdfSampling::Refine, BrdfSampling::Lit] {
                let mut shader = Shader { instructions, ..Shader::new(field, cuts, sampling) };
                bits.push(shader.shade(&point).to_array().map(f32::to_bits));
            }
        }
        bits
    };
    InstructionSet::available().map(shaded).collect()
}

/// Asserts that all sets agree with the first, and that it is not dark.
fn assert_same(bits: &[Vec<[u32; 3]>]) {
    assert!(bits.iter().all(|of_set| of_set == &bits[0]), "{bits:?}");
    assert!(bits[0].iter().all(|color| f32::from_bits(color[2]) > 0.0), "{bits:?}");
}

#[test]
fn all_instruction_sets_shade_a_point_to_the_same_bits() {
    let parameters = GgxParameters { base_color: Vec3::new(0.6, 0.3, 0.1), ..glossy(0.4) };
    let renderer = Renderer::new(dataset(mesh(16, true), parameters));
    let light = illumination([64, 32], |x, y| Vec3::new(0.3, 0.2, if x > 40 && y < 10 { 30.0 } else { 0.1 }));
    let lighting = renderer.lighting(&light, 64);
    let point = surface_at(&renderer, &from_the_side(24));
    let far = bits_in_each_set(&lighting, &renderer.dataset.cuts, &point);
    assert_same(&far);
    assert_ne!(far[0][3], far[0][4], "negative control: another sampling is another number");
    let smooth_normal = (point.smooth_normal + 0.3 * Vec3::X).normalize();
    let bent = bits_in_each_set(&lighting, &renderer.dataset.cuts, &SurfacePoint { smooth_normal, ..point });
    assert_same(&bent);
    assert_ne!(far[0], bent[0], "negative control: another normal is another number");
}

#[test]
fn all_instruction_sets_gather_sources_to_the_same_bits() {
    let renderer = Renderer::new(floor_and_wall(3));
    let indirect = renderer.dataset.indirect.as_ref().unwrap();
    let radiance: Vec<Vec3> = (0..indirect.sources.len()).map(|i| Vec3::new(1.0, 0.5, i as f32)).collect();
    let lighting = SourceLighting::new(SourceTree::new(&indirect.sources).into(), &radiance, 64);
    let point = surface_at(&renderer, &from_the_side(24));
    assert_same(&bits_in_each_set(SourceField::new(&lighting), &indirect.cuts, &point));
}

/// A shader caches the merged cuts of the last triangle. Points of other triangles in between must not change its results.
#[test]
fn a_shader_may_go_to_and_fro_between_triangles() {
    let renderer = Renderer::new(dataset(mesh(16, true), glossy(0.4)));
    let light = illumination([64, 32], |x, y| Vec3::new(0.3, 0.2, if x > 40 && y < 10 { 30.0 } else { 0.1 }));
    let lighting = renderer.lighting(&light, 64);
    let view = from_the_side(24);
    let material = Material { model: BrdfModel::Ggx, parameters: glossy(0.4).into(), ..Default::default() };
    let brdf = material.plain_brdf();
    let seen_at = |pixel: u32| {
        let [x, y] = [pixel % 24, pixel / 24].map(|at| at as f32 + 0.5);
        let direction = view.camera.direction_through(Vec2::new(x, y), view.size);
        match Surfaces::of(&renderer).seen_along(view.camera.eye, direction) {
            FirstHit::Surface(point) => Some(SurfacePoint { brdf: brdf.clone(), ..*point }),
            _ => None,
        }
    };
    let dimmed = |p: &SurfacePoint| SurfacePoint { weights: p.weights.map(|weight| 0.5 * weight), ..p.clone() };
    for sampling in [BrdfSampling::Once, BrdfSampling::Refine, BrdfSampling::Lit] {
        let shaded = |point: &SurfacePoint| Shader::new(&lighting, &renderer.dataset.cuts, sampling).shade(point);
        let mut points = (0..24 * 24).filter_map(seen_at);
        let a = points.next().expect("the view sees the mesh");
        let b = points.find(|b| b.vertices != a.vertices && shaded(b) != shaded(&a)).expect("not all are alike");
        let points = [&a, &dimmed(&a), &b, &a];
        assert_ne!(shaded(&a), shaded(&dimmed(&a)), "negative control");
        let mut kept = Shader::new(&lighting, &renderer.dataset.cuts, sampling);
        assert_eq!(points.map(|point| kept.shade(point)), points.map(shaded), "{sampling:?}");
    }
}
