//! The space for which light is baked, and warnings about it.

use super::*;
use crate::errors::PointsError;
use lapidary_core::{camera::Camera, shot::Shot};
use lapidary_interchange::image;

#[test]
fn light_is_baked_for_the_space_that_a_shot_is_taken_in() {
    let folder = tempfile::tempdir().unwrap();
    let job = searching(indirect_job(folder.path(), "a.cuts", BakeParts::INDIRECT));
    let eye = Vec3::new(-0.3, 0.1, -0.2);
    let camera = Camera::look_at(eye, Vec3::ZERO, 40.0);
    let reached_from = |job: &BakeJob| {
        bake(interior(), job, &Silent).unwrap();
        Vec3::from(Dataset::read(&job.output, image::decode).unwrap().report.indirect.unwrap().viewpoint)
    };
    assert!(reached_from(&job) != eye, "negative control");
    let shots = vec![Shot { camera, aspect: 1.0 }];
    assert_eq!(reached_from(&with(job, |settings| settings.shots = shots)), eye);
}

#[test]
fn viewpoints_that_reach_nothing_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let from = |viewpoint| {
        let job = indirect_job(folder.path(), "a.cuts", BakeParts::INDIRECT);
        bake(interior(), &with(job, |settings| settings.indirect.viewpoint = Some(viewpoint)), &Silent).unwrap_err()
    };
    let inside = from(Vec3::new(0.3, -0.4, 0.2));
    assert!(matches!(inside, BakeError::Points(PointsError::InsideSolid(_))), "{inside}");
    let outside = from(Vec3::new(0.0, 9.0, 0.0));
    assert!(outside.to_string().contains("(viewpoint)"), "{outside}");
}

#[test]
fn a_scene_without_a_closed_space_is_remarked_upon() {
    let folder = tempfile::tempdir().unwrap();
    let remarks = |scene, name| {
        let told = Told::default();
        let job = searching(indirect_job(folder.path(), name, BakeParts::MESHLESS));
        let dataset = bake(scene, &job, &told).unwrap();
        assert_eq!(dataset.report.warnings, told.all(), "the report has them as well");
        told.all().join("\n")
    };
    let open = remarks(scene(), "a.cuts");
    assert!(open.contains("meet no surface") && open.contains("(viewpoint)"), "{open}");
    assert_eq!(remarks(interior(), "b.cuts"), "");
}

#[test]
fn backs_of_walls_are_no_opening_and_only_what_is_seen_reflects() {
    let folder = tempfile::tempdir().unwrap();
    let remarks = |scene: Scene, name| {
        let job = indirect_job(folder.path(), name, BakeParts::INDIRECT);
        let job = with(job, |settings| settings.indirect.viewpoint = Some(Vec3::new(0.0, 0.1, -0.2)));
        bake(scene, &job, &Silent).unwrap().report.warnings.join("\n")
    };
    // Half of the walls are reversed: their backs are visible, and nothing of the outside.
    let mut turned = room(Vec3::ZERO, Vec3::new(1.0, 0.7, 0.8));
    turned.iter_mut().filter(|t| t.iter().all(|p| p.x > 0.9 || p.y > 0.6)).for_each(|t| t.swap(1, 2));
    let mut scene = scene_of(&turned);
    scene.materials[0].parameters.set("base_color", Vec3::ONE);
    assert_eq!(remarks(scene, "a.cuts"), "", "light is lost at the backs, so bounces end");
    // A white room beside a large gray one.
    let mut scene = scene_of(&[room(Vec3::ZERO, Vec3::ONE), room(Vec3::X * 20.0, Vec3::splat(5.0))].concat());
    scene.materials.push(scene.materials[0].clone());
    let gray = |positions: &[Vec3], t: &[u32; 3]| u32::from(positions[t[0] as usize].x > 5.0);
    scene.mesh.triangle_material = scene.mesh.triangles.iter().map(|t| gray(&scene.mesh.positions, t)).collect();
    scene.materials[0].parameters.set("base_color", Vec3::ONE);
    scene.materials[1].parameters.set("base_color", Vec3::splat(0.3));
    let white = remarks(scene.clone(), "b.cuts");
    assert!(white.contains("light is missing after the last bounce"), "{white}");
    scene.materials[0].parameters.set("base_color", Vec3::splat(0.9));
    assert_eq!(remarks(scene, "c.cuts"), "");
}
