//! Known answers of implicit visibility.

use super::*;
use crate::{
    implicit::{disc_forest::DiscForest, forest::SurfelForest},
    mesh::Mesh,
    ray::Intersector,
    sphere::{concentric::HemisphereCells, frame_around},
    test_scenes::{cuboid, quad, room, scene_of},
    transport::BounceEnergy,
};
use glam::Vec3;
use std::{collections::BTreeSet, f32::consts::PI};

/// A mesh with its surfels.
pub struct Furnished {
    pub mesh: Mesh,
    pub forest: SurfelForest,
}

fn mesh_of(objects: &[Vec<[Vec3; 3]>]) -> Mesh {
    let mut mesh = scene_of(&objects.concat()).mesh;
    let number = |(object, triangles): (usize, &Vec<_>)| vec![object as u32; triangles.len()];
    mesh.triangle_object = objects.iter().enumerate().flat_map(number).collect();
    mesh
}

fn with_surfels(mesh: Mesh, surfels: u32) -> Furnished {
    let forest = SurfelForest::new(&mesh, &vec![false; mesh.triangles.len()], surfels);
    Furnished { mesh, forest }
}

/// A sphere that faces outward: meridians and parallels.
fn sphere(center: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
    let (across, around) = (12, 24);
    let point = |i: usize, j: usize| {
        let (polar, turn) = (PI * i as f32 / across as f32, 2.0 * PI * (j % around) as f32 / around as f32);
        center + radius * Vec3::new(polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos())
    };
    let cells = (0..across).flat_map(|i| (0..around).map(move |j| (i, j)));
    let quads = cells.flat_map(|(i, j)| quad(point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)));
    quads.filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() > 1e-6).collect()
}

/// A closed room of 2 m with a sphere and a box in it, each an object.
pub fn furnished(surfels: u32) -> Furnished {
    let objects = [
        room(Vec3::ZERO, Vec3::ONE),
        sphere(Vec3::new(-0.35, -0.55, -0.3), 0.4),
        cuboid(Vec3::new(0.4, -0.5, 0.3), Vec3::new(0.25, 0.4, 0.25)),
    ];
    with_surfels(mesh_of(&objects), surfels)
}

fn views_of(forest: &DiscForest) -> Views {
    Bins::walk(forest, BinLayout::FINEST, &|_| true).views()
}

/// The light of a forest whose leaves emit and reflect one value each.
fn light(forest: &DiscForest, emitted: &dyn Fn(usize) -> f32, reflectance: f32, bounces: u32) -> LeafLight {
    light_of_bins(BinLayout::FINEST, forest, emitted, reflectance, bounces)
}

fn light_of_bins(
    layout: BinLayout,
    forest: &DiscForest,
    emitted: &dyn Fn(usize) -> f32,
    reflectance: f32,
    bounces: u32,
) -> LeafLight {
    let leaves = forest.discs().len();
    let emitted: Vec<Vec3> = (0..leaves).map(|leaf| Vec3::splat(emitted(leaf))).collect();
    let lighting = Lighting {
        reflectance: &vec![Vec3::splat(reflectance); leaves],
        emitted: &emitted,
        received: &vec![Vec3::ZERO; leaves],
        sky: &|_| Vec3::ZERO,
    };
    LeafLight::new(forest, &Bins::walk(forest, layout, &|_| true).views(), &lighting, bounces)
}

fn mean(values: impl ExactSizeIterator<Item = f32>) -> f32 {
    let count = values.len() as f32;
    values.sum::<f32>() / count
}

/// Share of the light of one square that arrives at another, by 2,048 surfels each.
fn form_factor(from: [[Vec3; 3]; 2], to: [[Vec3; 3]; 2]) -> f32 {
    form_factor_by(BinLayout::FINEST, from, to)
}

fn form_factor_by(layout: BinLayout, from: [[Vec3; 3]; 2], to: [[Vec3; 3]; 2]) -> f32 {
    let Furnished { forest, .. } = with_surfels(mesh_of(&[from.to_vec(), to.to_vec()]), 4096);
    let forest = forest.discs();
    let sends = |leaf: usize| if forest.leaves_of(0).contains(&(leaf as u32)) { 1.0 } else { 0.0 };
    let received = light_of_bins(layout, forest, &sends, 0.0, 0).direct;
    mean(forest.leaves_of(1).map(|leaf| received[leaf as usize].x / PI))
}

/// A unit square at a height, facing up or down.
fn square(height: f32, up: bool) -> [[Vec3; 3]; 2] {
    let p = |x: f32, z: f32| Vec3::new(x, height, z);
    let [a, b, c, d] = [p(0.0, 0.0), p(0.0, 1.0), p(1.0, 1.0), p(1.0, 0.0)];
    if up { quad(a, b, c, d) } else { quad(a, d, c, b) }
}

#[test]
fn squares_exchange_what_their_form_factors_say() {
    let parallel = form_factor(square(1.0, false), square(0.0, true));
    assert!((parallel / 0.1998 - 1.0).abs() < 0.02, "a metre apart: {parallel}");
    let farther = form_factor(square(1.1, false), square(0.0, true));
    assert!((farther / 0.1998 - 1.0).abs() > 0.05, "negative control: {farther}");
    let wall = quad(Vec3::ZERO, Vec3::Z, Vec3::new(0.0, 1.0, 1.0), Vec3::Y).map(|[a, b, c]| [a, c, b]);
    let edge = form_factor(wall, square(0.0, true));
    assert!((edge / 0.2000 - 1.0).abs() < 0.02, "with a common edge: {edge}");
    let away = form_factor(wall.map(|[a, b, c]| [a, c, b]), square(0.0, true));
    assert_eq!(away, 0.0, "negative control: it faces away");
}

#[test]
fn a_furnace_is_everywhere_the_same() {
    let Furnished { forest, .. } = with_surfels(mesh_of(&[room(Vec3::ZERO, Vec3::ONE)]), 4096);
    let forest = forest.discs();
    let direct = |light: &LeafLight| mean(light.direct.iter().map(|e| e.x / PI));
    let black = direct(&light(forest, &|_| 1.0, 0.0, 0));
    assert!((black - 1.0).abs() < 0.01, "{black}");
    let gray = light(forest, &|_| 1.0, 0.5, 12);
    let sum = direct(&gray) + mean(gray.bounced.iter().map(|e| e.x / PI));
    assert!((sum - 2.0).abs() < 0.04, "half gray: {sum}");
    let BounceEnergy { bounces, missing_share, .. } = light(forest, &|_| 1.0, 0.5, 3).energy;
    assert!(bounces == 3 && (missing_share - 0.0625).abs() < 0.003, "of 1 + 1/2 + 1/4 + 1/8: {missing_share}");
    let open = &room(Vec3::ZERO, Vec3::ONE)[2..];
    let Furnished { forest, .. } = with_surfels(mesh_of(&[open.to_vec()]), 4096);
    let open = direct(&light(forest.discs(), &|_| 1.0, 0.0, 0));
    assert!(open < 0.9, "negative control: without a ceiling, {open}");
}

#[test]
fn fewer_bins_see_nearly_as_well() {
    let Furnished { forest, .. } = with_surfels(mesh_of(&[room(Vec3::ZERO, Vec3::ONE)]), 4096);
    let direct = |side: usize| {
        let light = light_of_bins(BinLayout::new(side), forest.discs(), &|_| 1.0, 0.0, 0);
        mean(light.direct.iter().map(|e| e.x / PI))
    };
    assert!((direct(14) - 1.0).abs() < 0.01, "{}", direct(14));
    let exchanged = |side: usize| {
        let (from, to) = (square(1.0, false), square(0.0, true));
        form_factor_by(BinLayout::new(side), from, to) / 0.1998 - 1.0
    };
    assert!(exchanged(14).abs() < 0.04, "{}", exchanged(14));
    assert!(exchanged(8).abs() > 0.08, "negative control: {}", exchanged(8));
}

/// Irradiance of some leaves from a wall of radiance 1, by rays.
fn by_rays(of: &Furnished, leaves: &[usize]) -> Vec<f32> {
    let intersector = Intersector::new(&of.mesh);
    let cells = HemisphereCells { side: 45 };
    let discs = of.forest.discs().discs();
    let is_lit = |leaf: usize, cell: usize| {
        let origin = discs[leaf].position + discs[leaf].normal * 1e-4;
        let direction = frame_around(discs[leaf].normal) * cells.direction_of(cell);
        intersector.closest_hit(origin, direction).is_some_and(|hit| (origin + direction * hit.distance).x < -0.999)
    };
    let irradiance =
        |&leaf: &usize| (0..cells.len()).filter(|&cell| is_lit(leaf, cell)).count() as f32 * cells.weight();
    leaves.iter().map(irradiance).collect()
}

/// Root of the mean squared error over the mean, and the ratio of the sums.
fn compared(found: &[f32], truth: &[f32]) -> (f32, f32) {
    let squares = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2));
    let average = mean(truth.iter().copied());
    (mean(squares).sqrt() / average, mean(found.iter().copied()) / average)
}

/// Light of a wall by `surfels` surfels and by rays, at about 300 leaves elsewhere.
fn light_of_a_wall(surfels: u32) -> [Vec<f32>; 2] {
    let furnished = furnished(surfels);
    let forest = furnished.forest.discs();
    let is_wall = |leaf: usize| forest.discs()[leaf].position.x < -0.999;
    let step = surfels as usize / 315;
    let leaves: Vec<usize> = (0..forest.discs().len()).step_by(step).filter(|&leaf| !is_wall(leaf)).collect();
    let light = light(forest, &|leaf| f32::from(u8::from(is_wall(leaf))), 0.0, 0);
    [leaves.iter().map(|&leaf| light.direct[leaf].x).collect(), by_rays(&furnished, &leaves)]
}

#[test]
fn light_of_a_wall_is_that_of_rays() {
    for (surfels, bound) in [(4096, 0.08), (16_384, 0.06)] {
        let [found, truth] = light_of_a_wall(surfels);
        let (error, energy) = compared(&found, &truth);
        assert!(error < bound && (energy - 1.0).abs() < 0.03, "{surfels}: error {error}, energy {energy}");
        assert!(compared(&found.iter().map(|e| 1.1 * e).collect::<Vec<_>>(), &truth).1 > 1.03, "negative control");
        let shuffled: Vec<f32> = found.iter().rev().copied().collect();
        assert!(compared(&shuffled, &truth).0 > 0.3, "negative control: other leaves");
    }
}

#[test]
fn a_closed_room_hardly_sees_the_sky() {
    let sky_of = |furnished: &Furnished| {
        let forest = furnished.forest.discs();
        let views = views_of(forest);
        mean((0..views.leaves()).map(|leaf| views.share_of_sky(leaf as u32)))
    };
    for (surfels, bound) in [(4096, 0.01), (16_384, 0.005)] {
        let closed = sky_of(&furnished(surfels));
        assert!(closed < bound, "{surfels}: {closed}");
    }
    let open = sky_of(&with_surfels(mesh_of(&[room(Vec3::ZERO, Vec3::ONE)[2..].to_vec()]), 4096));
    assert!(open > 0.1, "negative control: without a ceiling, {open}");
}

#[test]
fn an_object_carried_away_leaves_the_scene_without_it() {
    let mut moved = furnished(2048);
    let posed: Vec<Vec3> = moved.mesh.positions.iter().map(|&p| p + Vec3::Y * 500.0).collect();
    moved.forest.update(&posed, &|object| object == 2);
    let forest = moved.forest.discs();
    let still = forest.leaves_of(0).start..forest.leaves_of(1).end;
    // Far above the ceiling it shows at most through holes of the covering.
    let without = Bins::of_leaves(forest, BinLayout::FINEST, still.clone(), &|object| object != 2);
    let changed = |with: &Bins| {
        let bins = still.clone().flat_map(|leaf| without.of_leaf(leaf).iter().zip(with.of_leaf(leaf)));
        bins.filter(|(a, b)| **a != EMPTY && a != b).count()
    };
    assert_eq!(changed(&Bins::of_leaves(forest, BinLayout::FINEST, still.clone(), &|_| true)), 0);
    let near = furnished(2048);
    let with = Bins::of_leaves(near.forest.discs(), BinLayout::FINEST, still.clone(), &|_| true);
    assert!(changed(&with) > 1000, "negative control: where it was");
}

#[test]
fn a_dragged_object_gives_the_bins_of_a_whole_walk() {
    let mut scene = furnished(2048);
    for objects in [BTreeSet::from([2]), [1, 2].into()] {
        let drag = Drag::begin(scene.forest.discs(), BinLayout::FINEST, objects);
        for step in 0..3 {
            let offset = Vec3::new(-0.1 * step as f32, 0.05 * step as f32, 0.0);
            let posed: Vec<Vec3> = scene.mesh.positions.iter().map(|&p| p + offset).collect();
            scene.forest.update(&posed, &|object| drag.objects().contains(&object));
            let forest = scene.forest.discs();
            assert_eq!(drag.frame(forest), Bins::walk(forest, BinLayout::FINEST, &|_| true).views(), "step {step}");
        }
    }
    let wrong = Drag::begin(scene.forest.discs(), BinLayout::FINEST, [1].into());
    scene.forest.update(&scene.mesh.positions, &|object| object == 2);
    let forest = scene.forest.discs();
    assert_ne!(
        wrong.frame(forest),
        Bins::walk(forest, BinLayout::FINEST, &|_| true).views(),
        "negative control: another object has moved"
    );
}

#[test]
fn the_sky_lights_what_is_open_to_it() {
    let floor = quad(Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X);
    let Furnished { forest, .. } = with_surfels(mesh_of(&[floor.to_vec()]), 256);
    let (forest, views) = (forest.discs(), views_of(forest.discs()));
    let gradient = |direction: Vec3| Vec3::new(1.0, direction.y, direction.x.max(0.0));
    for e in views.irradiance_of_sky(forest, &gradient) {
        // Integrals over the hemisphere of the cosine, its square, and the cosine times x where that is positive.
        let known = Vec3::new(PI, 2.0 * PI / 3.0, 2.0 / 3.0);
        assert!((e / known - 1.0).abs().max_element() < 0.01, "{e}");
    }
    let sky = |direction: Vec3| gradient(-direction);
    assert!(views.irradiance_of_sky(forest, &sky)[0].y < 0.0, "negative control: from below");
}
