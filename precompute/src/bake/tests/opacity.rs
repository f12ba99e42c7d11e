//! Bakes of transparent surfaces.

use super::*;
use crate::{test_scenes::quad, verify};
use lapidary_core::{
    cut::packed::{depth, value},
    material::Material,
    parts::Part,
};

/// A floor with a pane over one corner that blocks this share of the light.
fn pane(opacity: f32) -> Scene {
    let mut triangles = floor(2.0, 0.0).to_vec();
    let corner = |x: f32, z: f32| Vec3::new(x, 0.5, z);
    triangles.extend(quad(corner(1.0, 1.0), corner(1.0, 3.0), corner(3.0, 3.0), corner(3.0, 1.0)));
    let mut scene = scene_of(&triangles);
    scene.mesh.triangle_material[2..].fill(1);
    scene.materials.push(Material::default());
    scene.materials[1].parameters.set("geometry_opacity", opacity);
    scene
}

/// A few large triangles without tessellation.
fn as_it_is(folder: &Path, name: &str, exhaustive: bool) -> BakeJob {
    let untouched = |s: &mut BakeSettings| (s.max_vertices, s.exhaustive, s.lights) = (None, exhaustive, 4096);
    with(job(folder, name), untouched)
}

/// Share of all directions visible from each floor vertex.
fn seen(dataset: &Dataset) -> Vec<f32> {
    let share = |&node: &u16| (0.5_f32).powi(depth(node) as i32) * value(node);
    let of_vertex = |v: u32| dataset.cuts.cut(dataset.tree.height(), v).iter().map(share).sum();
    let positions = &dataset.scene.mesh.positions;
    (0..positions.len() as u32).filter(|&v| positions[v as usize].y == 0.0).map(of_vertex).collect()
}

#[test]
fn vertices_see_through_in_proportion_and_their_cuts_hold_it() {
    let folder = tempfile::tempdir().unwrap();
    for exhaustive in [true, false] {
        let baked = |opacity: f32| {
            let job = as_it_is(folder.path(), &format!("{opacity}{exhaustive}.cuts"), exhaustive);
            let dataset = bake(pane(opacity), &job, &Silent).unwrap();
            let verified = verify(&dataset, 100);
            assert!(verified.passed, "{verified:?}");
            seen(&dataset)
        };
        let [open, some, closed] = [0.0, 0.3, 1.0].map(baked);
        let hidden: Vec<f32> = open.iter().zip(&closed).map(|(open, closed)| open - closed).collect();
        assert!(hidden.iter().any(|&hidden| hidden > 0.2) && hidden.iter().any(|&hidden| hidden < 0.05));
        for ((open, some), hidden) in open.iter().zip(&some).zip(&hidden) {
            assert!((open - 0.3 * hidden - some).abs() < 0.005, "{open} {some} {hidden}");
            assert!(*hidden < 0.2 || (open - 0.4 * hidden - some).abs() > 0.01, "negative control: another opacity");
        }
    }
}

/// The pane with an opacity on its part, whose material is opaque.
fn pane_of_a_part(opacity: f32, object: u32) -> Scene {
    let mut scene = pane(1.0);
    scene.mesh.triangle_object[2..].fill(1);
    scene.objects.push(scene.objects[0].clone());
    let mut own = scene.materials.clone();
    own.push(pane(opacity).materials[1].clone());
    scene.take_opacities(&own, 2, [(Part { object, material: 1 }, 2)], &[]);
    scene
}

#[test]
fn a_part_with_a_material_of_its_own_is_baked_with_what_that_lets_through() {
    let folder = tempfile::tempdir().unwrap();
    let mut names = 0..;
    let mut baked = |scene: Scene| {
        let job = as_it_is(folder.path(), &format!("{}.cuts", names.next().unwrap()), true);
        bake(scene, &job, &Silent).unwrap()
    };
    let [material, part, of_another] = [pane(0.3), pane_of_a_part(0.3, 1), pane_of_a_part(0.3, 0)].map(&mut baked);
    assert!(verify(&part, 100).passed);
    assert_eq!(part.cuts, material.cuts);
    assert_eq!(part.two_sided, material.two_sided);
    assert_ne!(of_another.cuts, material.cuts, "negative control: no part of the pane");
    assert_eq!(part.scene.mesh.triangle_material, baked(pane(0.3)).scene.mesh.triangle_material, "parts stay parts");
}

#[test]
fn a_bake_goes_on_only_under_the_opacity_that_it_began_with() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(5), ..as_it_is(folder.path(), "a.cuts", true) };
    assert!(bake(pane(0.5), &job, &CancelIn::phase(Phase::Visibility)).is_err());
    let resume = BakeJob { resume: true, ..job };
    let refused = bake(pane(0.25), &resume, &Silent).unwrap_err();
    assert!(matches!(refused, BakeError::Checkpoint(_)), "{refused}");
    let dataset = bake(pane(0.5), &resume, &Silent).unwrap();
    assert_eq!(dataset.scene_hash, scene_hash(&pane(0.25)), "the file is the same under any opacity");
}
