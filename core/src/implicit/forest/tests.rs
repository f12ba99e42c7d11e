use super::*;
use crate::{
    mesh::Mesh,
    sphere::frame_around,
    test_scenes::{cuboid, quad, room, scene_of},
    threads::on_threads,
};
use std::f32::consts::PI;

/// A room of 2 m with a box and a two-sided sheet in it, each an object.
fn scene() -> (Mesh, Vec<bool>) {
    let p = |x: f32, y: f32| Vec3::new(x, y, 0.6);
    let parts = [
        room(Vec3::ZERO, Vec3::ONE),
        cuboid(Vec3::new(0.3, -0.7, 0.0), Vec3::splat(0.2)),
        quad(p(-0.5, 0.0), p(0.0, 0.0), p(0.0, 0.5), p(-0.5, 0.5)).to_vec(),
    ];
    let mut mesh = scene_of(&parts.concat()).mesh;
    mesh.triangle_object = [vec![0; 12], vec![1; 12], vec![2; 2]].concat();
    let two_sided = mesh.triangle_object.iter().map(|&object| object == 2).collect();
    (mesh, two_sided)
}

fn area_of(forest: &SurfelForest, object: u32) -> f32 {
    forest.discs().node(object).area
}

#[test]
fn surfels_stand_for_the_area_of_all_sides() {
    let (mesh, two_sided) = scene();
    let forest = SurfelForest::new(&mesh, &two_sided, 4096);
    assert_eq!(forest.discs().discs().len(), 4096);
    for (object, area) in [24.0, 0.96, 0.5].into_iter().enumerate() {
        let found = area_of(&forest, object as u32);
        assert!((found / area - 1.0).abs() < 1e-3, "object {object}: {found} in place of {area} m²");
    }
    let one_sided = SurfelForest::new(&mesh, &[false; 26], 4096);
    assert!((area_of(&one_sided, 2) - 0.25).abs() < 1e-3, "negative control: one side has half of the area");
    let leaves = |object: u32| forest.discs().leaves_of(object).len();
    assert!((leaves(0) as f32 / leaves(1) as f32 / 25.0 - 1.0).abs() < 0.02 && leaves(2) > 64);
    let facing: Vec3 = forest.discs().leaves_of(2).map(|leaf| forest.discs().discs()[leaf as usize].normal).sum();
    assert!(facing.length() < 0.1 * leaves(2) as f32, "as many on each side");
}

#[test]
fn surfels_lie_evenly() {
    let (mesh, two_sided) = scene();
    let forest = SurfelForest::new(&mesh, &two_sided, 4096);
    let of_room = &forest.discs().discs()[..forest.discs().leaves_of(0).len()];
    // Share of the floor that no disc of 1.26 radii covers; independent samples leave a fifth.
    let floor: Vec<&Disc> = of_room.iter().filter(|d| d.normal.y > 0.9).collect();
    let reach = 1.26 * floor[0].radius();
    let place = |i: u32| Vec3::new((i % 100) as f32, -50.0, (i / 100) as f32) / 50.0 - Vec3::new(0.99, 0.0, 0.99);
    let bare = (0..10_000).filter(|&i| floor.iter().all(|d| d.position.distance(place(i)) > reach)).count();
    assert!(bare < 600, "{bare} of 10,000 places");
    let mut rng = fastrand::Rng::with_seed(1);
    let drawn: Vec<Vec3> =
        floor.iter().map(|_| Vec3::new(2.0 * rng.f32() - 1.0, -1.0, 2.0 * rng.f32() - 1.0)).collect();
    let bare = (0..10_000).filter(|&i| drawn.iter().all(|d| d.distance(place(i)) > reach)).count();
    assert!(bare > 1500, "negative control: {bare} of 10,000 places");
}

#[test]
fn only_moved_objects_change_and_there_and_back_is_the_same() {
    let (mesh, two_sided) = scene();
    let mut forest = SurfelForest::new(&mesh, &two_sided, 1024);
    let baked = forest.clone();
    forest.update(&mesh.positions, &|_| true);
    assert_eq!(forest, baked, "the pose of the bake");
    let turn = frame_around(Vec3::new(0.6, 0.8, 0.0));
    let posed: Vec<Vec3> = mesh.positions.iter().map(|&p| turn * p * 2.0).collect();
    forest.update(&posed, &|object| object == 1);
    assert!((area_of(&forest, 1) / area_of(&baked, 1) - 4.0).abs() < 1e-3, "twice the size");
    assert!((forest.discs().node(1).center - turn * baked.discs().node(1).center * 2.0).length() < 1e-4);
    assert_eq!((area_of(&forest, 0), forest.discs().node(2)), (area_of(&baked, 0), baked.discs().node(2)));
    let leaf = forest.discs().leaves_of(1).start as usize;
    let [before, after] = [&baked, &forest].map(|f| f.surfels().nth(leaf).unwrap());
    assert!((after.normal - turn * before.normal).length() < 1e-4 && after.place == before.place);
    forest.update(&mesh.positions, &|object| object == 1);
    assert_eq!(forest, baked, "bit for bit");
}

#[test]
fn a_forest_does_not_depend_on_threads() {
    let (mesh, two_sided) = scene();
    let with = |threads| on_threads(threads, || SurfelForest::new(&mesh, &two_sided, 2048));
    assert_eq!(with(1), with(3));
}

#[test]
fn a_ground_leaves_surfels_for_what_stands_on_it() {
    let mut scene = scene_of(&cuboid(Vec3::Y, Vec3::ONE));
    crate::ground::add_ground(&mut scene);
    let two_sided = vec![false; scene.mesh.triangles.len()];
    let forest = SurfelForest::new(&scene.mesh, &two_sided, 4096);
    let of_box = forest.discs().leaves_of(0).len();
    assert!(of_box > 800, "{of_box} of 4,096, though the near ground is 30 times as large");
    let radius = 8.0 * 3.0_f32.sqrt();
    let of_ground = area_of(&forest, 1);
    assert!(of_ground > 0.4 * PI * radius * radius && of_ground < 1.1 * PI * radius * radius, "{of_ground} m²");
}

#[test]
fn objects_without_area_have_no_surfels() {
    let (mut mesh, two_sided) = scene();
    let point = mesh.positions[0];
    mesh.triangles[12..24].iter().flatten().for_each(|&v| mesh.positions[v as usize] = point);
    let forest = SurfelForest::new(&mesh, &two_sided, 1024);
    assert!(forest.discs().leaves_of(1).is_empty() && area_of(&forest, 1) == 0.0);
    assert_eq!(forest.discs().discs().len(), 1024);
    assert_eq!(SurfelForest::new(&Mesh::default(), &[], 1024).discs().discs().len(), 0);
}
