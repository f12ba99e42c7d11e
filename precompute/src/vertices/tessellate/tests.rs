//! Complete tessellations of a box over a floor.

use super::{edges::end_vertices, split::midpoint_vertex, *};
use crate::{
    observer::{Event, Silent},
    test_devices::{Emulated, Warnings},
    test_scenes::{cuboid, floor, quad, room, scene_of},
    vertices::sidedness::classify,
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{camera::Camera, dataset::BakeParts, scene::Scene};
use std::{
    collections::HashSet,
    sync::atomic::{AtomicU64, AtomicUsize, Ordering},
};

const DISTANT: Stored = Stored { environment: true, bounces: false };

fn box_over_floor() -> Scene {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
    scene_of(&triangles)
}

fn tessellated(budget: usize) -> Scene {
    tessellated_for(DISTANT, &[], box_over_floor(), budget)
}

fn tessellated_for(stored: impl Into<Option<Stored>>, shots: &[Shot], mut scene: Scene, budget: usize) -> Scene {
    let mut sides = classify(&scene);
    let intersector = Intersector::new(&scene.mesh);
    let wanted =
        Wanted { stored: stored.into(), budget, shots, around: None, devices: None, traced: &AtomicU64::new(0) };
    tessellate(&mut scene.mesh, &mut sides, &intersector, wanted, &Silent).unwrap();
    assert_eq!(sides.two_sided.len(), scene.mesh.triangles.len());
    scene
}

fn area(mesh: &Mesh) -> f32 {
    (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum()
}

#[test]
fn only_what_vertices_store_asks_for_vertices() {
    let of = |mode: BakeParts| Stored::of(mode).map(|stored| (stored.environment, stored.bounces));
    assert_eq!(of(BakeParts::MESHLESS.with(BakeParts::RADIOSITY)), None, "functions lie at points of their own");
    assert_eq!(of(BakeParts::ENVIRONMENT), Some((true, false)));
    assert_eq!(of(BakeParts::ENVIRONMENT_MESHLESS), of(BakeParts::ALL), "parts are the same with any others");
    assert_eq!(of(BakeParts::INDIRECT), Some((false, true)));
    assert_eq!(of(BakeParts::ALL), Some((true, true)));
}

#[test]
fn even_vertices_bound_all_edges_and_follow_no_shadow() {
    let longest = |scene: &Scene| {
        let mesh = &scene.mesh;
        let edge = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        (0..mesh.triangles.len()).map(edge).fold(0.0, f32::max)
    };
    let budget = 3000;
    let even = tessellated_for(None, &[], box_over_floor(), budget);
    let unit = (1.15 * area(&even.mesh) / budget as f32).sqrt();
    assert!(longest(&even) <= LONGEST * unit && longest(&box_over_floor()) > 2.0 * LONGEST * unit);
    assert!(is_conforming(&even.mesh));
    let adaptive = tessellated(budget);
    assert!(4 * even.mesh.positions.len() < adaptive.mesh.positions.len(), "{} vertices", even.mesh.positions.len());
}

/// Whether no vertex lies inside an edge of a triangle that lacks it as a corner.
fn is_conforming(mesh: &Mesh) -> bool {
    let edges = Edges::new(mesh);
    let positions: HashSet<[u32; 3]> = mesh.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
    edges.ends.iter().all(|&(a, b)| {
        let middle = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
        !positions.contains(&middle.to_array().map(f32::to_bits))
    })
}

#[test]
fn the_result_is_valid_conforming_and_has_the_same_surface() {
    let (before, after) = (box_over_floor(), tessellated(3000));
    assert_eq!(after.mesh.validate(1, 1), Ok(()));
    assert!(after.mesh.positions.len() > 1000 && after.mesh.positions.len() <= 3000);
    for budget in [50, 100, 200, 400, 800] {
        let vertices = tessellated(budget).mesh.positions.len();
        assert!(vertices <= budget && 10 * vertices > 9 * budget, "{vertices} of {budget}");
    }
    assert!((area(&after.mesh) / area(&before.mesh) - 1.0).abs() < 1e-4);
    assert!(is_conforming(&after.mesh));
    let mut cracked = after.mesh.clone();
    let edges = Edges::new(&cracked);
    let [a, b] = end_vertices(&cracked, &edges, 0);
    midpoint_vertex(&mut cracked, &mut Default::default(), a, b);
    assert!(!is_conforming(&cracked), "negative control: a hanging vertex is noticed");
}

/// Vertices per square meter of the plane y = `height` between two distances from (0.3, 0.2).
fn density(mesh: &Mesh, height: f32, near: f32, far: f32) -> f32 {
    let in_ring = |p: &&Vec3| {
        let r = Vec3::new(p.x - 0.3, 0.0, p.z - 0.2).length();
        p.y == height && r >= near && r < far
    };
    let area = std::f32::consts::PI * (far * far - near * near);
    mesh.positions.iter().filter(in_ring).count() as f32 / area
}

#[test]
fn vertices_gather_where_the_shadow_changes() {
    let mesh = tessellated(3000).mesh;
    let (under, beside) = (density(&mesh, 0.0, 0.0, 0.8), density(&mesh, 0.0, 1.2, 1.7));
    assert!(under > 3.0 * beside, "{under} and {beside}");
}

#[test]
fn in_a_closed_room_vertices_gather_where_bounced_light_changes() {
    let mut triangles = room(Vec3::ZERO, Vec3::splat(2.0));
    triangles.extend(cuboid(Vec3::new(0.3, -1.7, 0.2), Vec3::splat(0.25)));
    let ratio = |stored| {
        let mesh = tessellated_for(stored, &[], scene_of(&triangles), 6000).mesh;
        density(&mesh, -2.0, 0.0, 0.6) / density(&mesh, -2.0, 0.9, 1.4)
    };
    let (bounced, distant) = (ratio(Stored { environment: false, bounces: true }), ratio(DISTANT));
    assert!(bounced > 3.0, "{bounced}");
    assert!(distant < 1.5, "negative control: the sky is hidden everywhere, {distant}");
}

/// A room with a pillar between its halves, and a camera in one of them.
fn halved_room() -> (Scene, Shot) {
    let mut triangles = room(Vec3::ZERO, Vec3::splat(2.0));
    triangles.extend(cuboid(Vec3::new(0.01, 0.02, 0.53), Vec3::new(0.2, 1.9, 1.4)));
    let camera = Camera::look_at(Vec3::new(-1.5, 1.0, 1.5), Vec3::new(-1.0, -2.0, 0.0), 50.0);
    (scene_of(&triangles), Shot { camera, aspect: 16.0 / 9.0 })
}

#[test]
fn vertices_gather_where_a_shot_looks() {
    let (scene, shot) = halved_room();
    let eye = shot.camera.eye;
    let room = Intersector::new(&scene.mesh);
    let seen = |p: &Vec3| {
        shot.frustum().magnification(*p, Vec3::Y) > 0.0 && !room.occluded_between(eye, *p + (eye - *p) * 1e-3)
    };
    let bounced = Stored { environment: false, bounces: true };
    let count = |shots: &[Shot]| {
        let scene = tessellated_for(bounced, shots, scene.clone(), 6000);
        assert!(is_conforming(&scene.mesh));
        let inside = scene.mesh.positions.iter().filter(|p| seen(p)).count();
        (inside, scene.mesh.positions.len() - inside)
    };
    let (in_shot, elsewhere) = count(std::slice::from_ref(&shot));
    let (before, rest) = count(&[]);
    assert!(in_shot > 3 * before, "{in_shot} vertices in the shot, {before} without it");
    assert!(8 * elsewhere > rest, "the rest keeps some: {elsewhere} of {rest}");
}

#[test]
fn a_shot_that_sees_nothing_is_remarked_and_changes_nothing() {
    let (mut scene, shot) = halved_room();
    let away = Shot { camera: Camera { eye: Vec3::splat(9.0), target: Vec3::splat(10.0), ..shot.camera }, ..shot };
    let mut sides = classify(&scene);
    let intersector = Intersector::new(&scene.mesh);
    let without = tessellated_for(DISTANT, &[], scene.clone(), 3000).mesh;
    let warnings = Warnings::default();
    let wanted = Wanted {
        stored: Some(DISTANT),
        budget: 3000,
        shots: &[away],
        around: None,
        devices: None,
        traced: &AtomicU64::new(0),
    };
    tessellate(&mut scene.mesh, &mut sides, &intersector, wanted, &warnings).unwrap();
    assert_eq!(scene.mesh, without);
    let warning = warnings.only_one();
    assert!(warning.contains("shot 1 sees no surface"), "{warning}");
}

#[test]
fn no_budget_leaves_the_mesh_alone() {
    assert_eq!(tessellated(3).mesh, box_over_floor().mesh);
}
/// Requests a stop after `limit` checks.
struct Impatient {
    asked: AtomicUsize,
    limit: usize,
}

impl Observer for Impatient {
    fn event(&self, _event: Event) {}

    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.limit
    }
}

/// Whether tessellation was cancelled, the number of checks, and the number of vertices by then.
fn asked_until(limit: usize) -> (bool, usize, usize) {
    let mut scene = box_over_floor();
    let mut sides = classify(&scene);
    let intersector = Intersector::new(&scene.mesh);
    let observer = Impatient { asked: AtomicUsize::new(0), limit };
    let wanted = Wanted {
        stored: Some(DISTANT),
        budget: 3000,
        shots: &[],
        around: None,
        devices: None,
        traced: &AtomicU64::new(0),
    };
    let result = tessellate(&mut scene.mesh, &mut sides, &intersector, wanted, &observer);
    (result.is_err(), observer.asked.into_inner(), scene.mesh.positions.len())
}

#[test]
fn cancelling_stops_within_a_round() {
    let (cancelled, all, vertices) = asked_until(usize::MAX);
    assert!(!cancelled && all > 10 * ROUNDS, "points are asked about, not rounds: {all}");
    let (cancelled, asked, fewer) = asked_until(all / 2);
    assert!(cancelled && fewer < vertices, "{fewer} of {vertices} vertices");
    assert!(asked < all * 3 / 4, "asked {asked} times, half of all is {}", all / 2);
}

#[test]
fn a_vertex_between_two_has_the_mean_of_their_second_texture_coordinates_and_colors() {
    let mut mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X],
        normals: vec![Vec3::Y; 2],
        tangents: vec![Vec4::X; 2],
        uvs: vec![Vec2::ZERO, Vec2::X],
        second_uvs: vec![Vec2::ZERO, Vec2::new(0.0, 4.0)],
        colors: vec![Vec3::X, Vec3::Y],
        ..Default::default()
    };
    midpoint_vertex(&mut mesh, &mut Default::default(), 0, 1);
    assert_eq!((mesh.uvs[2], mesh.second_uvs[2]), (Vec2::new(0.5, 0.0), Vec2::new(0.0, 2.0)));
    assert_eq!(mesh.colors[2], Vec3::new(0.5, 0.5, 0.0));
}

/// A box and a banner over a floor, by devices or by the cores.
fn tessellated_on(devices: Option<&Emulated>, stored: Stored, opacity: f32, observer: &dyn Observer) -> Mesh {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
    let p = |x: f32, y: f32| Vec3::new(x, y, 0.9);
    triangles.extend(quad(p(-1.0, 0.2), p(1.0, 0.2), p(1.0, 1.0), p(-1.0, 1.0)));
    let mut scene = scene_of(&triangles);
    scene.materials[0].parameters.set("geometry_opacity", opacity);
    let mut sides = classify(&scene);
    let intersector = Intersector::of_scene(&scene);
    let devices = devices.map(|devices| devices as &dyn RayDevices);
    let traced = AtomicU64::new(0);
    let wanted = Wanted { stored: Some(stored), budget: 2000, shots: &[], around: None, devices, traced: &traced };
    tessellate(&mut scene.mesh, &mut sides, &intersector, wanted, observer).unwrap();
    scene.mesh
}

const OF_ALL_KINDS: [Stored; 3] =
    [DISTANT, Stored { environment: true, bounces: true }, Stored { environment: false, bounces: true }];

#[test]
fn a_device_asks_for_the_same_vertices_as_the_cores() {
    for stored in OF_ALL_KINDS {
        let devices = Emulated::lasting();
        let cores = tessellated_on(None, stored, 1.0, &Silent);
        assert!(tessellated_on(Some(&devices), stored, 1.0, &Silent) == cores, "{stored:?}");
        assert!(devices.begun() > 4, "{} pieces of work", devices.begun());
        let other = tessellated_on(Some(&Emulated::blind()), stored, 1.0, &Silent);
        assert!(other != cores, "negative control: a device that sees nothing");
    }
}

#[test]
fn the_cores_go_on_with_vertices_where_a_device_fails_and_say_so_once() {
    for stored in OF_ALL_KINDS {
        let cores = tessellated_on(None, stored, 1.0, &Silent);
        for (devices, reason, begun) in [(Emulated::lost_after(2), "unplugged", 3), (Emulated::full(), "no room", 0)] {
            let warnings = Warnings::default();
            assert!(tessellated_on(Some(&devices), stored, 1.0, &warnings) == cores, "{reason}");
            assert_eq!(devices.begun(), begun, "it is not asked again");
            assert!(warnings.only_one().contains(reason));
        }
    }
}

#[test]
fn thin_surfaces_are_left_to_the_cores() {
    for stored in OF_ALL_KINDS {
        let devices = Emulated::blind();
        let thin = tessellated_on(Some(&devices), stored, 0.7, &Silent);
        assert!(thin == tessellated_on(None, stored, 0.7, &Silent) && devices.begun() == 0);
        tessellated_on(Some(&devices), stored, 1.0, &Silent);
        assert!(devices.begun() > 0, "negative control");
    }
}
