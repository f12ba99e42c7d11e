//! Light solved anew, against known answers.

use super::*;
use crate::{
    observer::Silent,
    test_scenes::{cuboid, floor, room, scene_of},
};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    mesh_surface::CarryingMesh,
    meshless::{FunctionTree, LitFunctions, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep, irradiance},
    ray::Intersector,
    scene::Scene,
    surfel::Surface,
};
use std::collections::BTreeMap;

const BLACK: &(dyn Fn(&Surfel) -> Vec3 + Sync) = &|_| Vec3::ZERO;

/// A scene with what a solver borrows.
struct Stage {
    as_baked: Scene,
    now: Scene,
    rays: Intersector,
    two_sided: Vec<bool>,
}

impl Stage {
    /// Triangles of several objects.
    fn new(objects: &[Vec<[Vec3; 3]>]) -> Self {
        let mut scene = scene_of(&objects.concat());
        let counts = objects.iter().enumerate().flat_map(|(i, triangles)| vec![i as u32; triangles.len()]);
        scene.mesh.triangle_object = counts.collect();
        Self {
            rays: Intersector::new(&scene.mesh),
            two_sided: vec![false; scene.mesh.triangles.len()],
            as_baked: scene.clone(),
            now: scene,
        }
    }

    /// Moves an object away from its baked place.
    fn moved(&self, object: u32, by: Vec3) -> Self {
        let mut now = self.as_baked.clone();
        let owners = now.mesh.owners();
        let places = now.mesh.positions.iter_mut().zip(owners).filter(|(_, owner)| *owner == object);
        places.for_each(|(position, _)| *position += by);
        Self {
            rays: Intersector::new(&now.mesh),
            two_sided: self.two_sided.clone(),
            as_baked: self.as_baked.clone(),
            now,
        }
    }

    fn surface(&self) -> CarryingMesh<'_> {
        CarryingMesh::new(&self.as_baked.mesh, MeshSurface::new(&self.now.mesh, &self.rays, &self.two_sided, BLACK))
    }

    fn bases(&self, functions: u32) -> ObjectBases {
        let mesh = &self.as_baked.mesh;
        let surface = MeshSurface::new(mesh, &self.rays, &self.two_sided, BLACK);
        let settings = ObjectBasesSettings { functions, levels: 4, sender_level: 2 };
        place_object_bases(mesh, &surface, &settings, &Silent).unwrap()
    }

    /// The box around an object now.
    fn bounds(&self, object: u32) -> Bounds {
        let mesh = &self.now.mesh;
        let of_object = mesh.owners().into_iter().zip(&mesh.positions).filter(|(owner, _)| *owner == object);
        Bounds::around(of_object.map(|(_, position)| *position))
    }
}

/// Values of one kind for all functions.
struct Values {
    direct: Vec<Vec3>,
    reflectance: Vec<Vec3>,
    emitted: Vec<Vec3>,
}

impl Values {
    fn new(bases: &ObjectBases, of: impl Fn(&Surfel, Owner) -> [Vec3; 3]) -> Self {
        let all: Vec<[Vec3; 3]> = bases.points().iter().zip(bases.owners()).map(|(p, o)| of(p, *o)).collect();
        let [direct, reflectance, emitted] = std::array::from_fn(|i| all.iter().map(|values| values[i]).collect());
        Self { direct, reflectance, emitted }
    }

    fn lit(&self) -> LitFunctions<'_> {
        LitFunctions { direct: &self.direct, reflectance: &self.reflectance, emitted: &self.emitted, sky: None }
    }
}

/// All bounces.
fn solved(solver: &mut Radiosity, stage: &Stage, lit: &LitFunctions) -> RadiosityLight {
    let surface = stage.surface();
    let mut light = solver.begin(&surface, lit);
    while solver.advance(&surface, lit, &mut light, usize::MAX) != RadiosityStep::Last {}
    light
}

fn settings(bounces: u32) -> RadiositySettings {
    RadiositySettings { bounces, least: 0.0, ..RadiositySettings::DEFAULT }
}

/// Irradiance of the finest functions.
fn finest<'a>(solver: &'a Radiosity, light: &'a RadiosityLight) -> impl Iterator<Item = Vec3> + 'a {
    let bases = solver.bases();
    bases.level(bases.levels() - 1).map(|i| irradiance(&light.total[i], bases.points()[i].normal))
}

#[test]
fn light_in_a_closed_room_is_the_sum_of_its_series() {
    let stage = Stage::new(&[room(Vec3::ZERO, Vec3::new(1.0, 0.7, 1.3))]);
    let bases = stage.bases(4000);
    let r = 0.6;
    let values = Values::new(&bases, |_, _| [Vec3::ONE, Vec3::splat(r), Vec3::ZERO]);
    let of = |bounces: u32| {
        let mut solver = Radiosity::new(bases.clone(), settings(bounces));
        let light = solved(&mut solver, &stage, &values.lit());
        let (sum, count) = finest(&solver, &light).fold((0.0, 0), |(sum, count), e| (sum + e.x, count + 1));
        1.0 + sum / count as f32
    };
    let expected = 1.0 / (1.0 - r);
    let found = of(16);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    assert!((of(5) / expected - 1.0).abs() > 0.02, "negative control: five bounces");
}

#[test]
fn the_flux_of_a_lamp_arrives() {
    let lamp = cuboid(Vec3::new(0.1, 0.2, 0.0), Vec3::splat(0.1));
    let stage = Stage::new(&[room(Vec3::ZERO, Vec3::ONE), lamp]);
    let bases = stage.bases(6000);
    let shining = |radiance: f32| {
        Values::new(&bases, |_, owner| {
            [Vec3::ZERO, Vec3::ZERO, Vec3::splat(if owner.object == 1 { radiance } else { 0.0 })]
        })
    };
    let mut solver = Radiosity::new(bases.clone(), settings(1));
    let mut arrived = |values: &Values| {
        let light = solved(&mut solver, &stage, &values.lit());
        let finest = bases.level(bases.levels() - 1);
        let walls: Vec<usize> = finest.filter(|&i| bases.owners()[i].object == 0).collect();
        let sum: f32 = walls.iter().map(|&i| irradiance(&light.total[i], bases.points()[i].normal).x).sum();
        sum / walls.len() as f32 * 6.0 * 4.0
    };
    // Six sides of 0.2 m: a convex lamp sends pi times area times radiance, all of it to the walls.
    let expected = std::f32::consts::PI * 6.0 * 0.04 * 5.0;
    let found = arrived(&shining(5.0));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    let dimmer = arrived(&shining(4.9));
    assert!((dimmer / expected - 1.0).abs() > 0.01, "negative control: {dimmer}");
}

/// Irradiance that changes over a room.
fn smooth(p: Vec3) -> f32 {
    (0.5 + 0.5 * p.y).powi(2) * (1.0 + 0.5 * (2.0 * p.x).sin())
}

/// A closed room with a block, and light from above.
fn room_with_block(functions: u32) -> (Stage, ObjectBases, Values) {
    let stage = Stage::new(&[room(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::new(0.3, -0.7, 0.2), Vec3::new(0.2, 0.3, 0.2))]);
    let bases = stage.bases(functions);
    let values = Values::new(&bases, |p, _| {
        [Vec3::new(1.0, 0.5, 1.0) * smooth(p.position), Vec3::new(0.7, 0.5, 0.3), Vec3::ZERO]
    });
    (stage, bases, values)
}

/// Error of one bounce relative to the mean, against rays.
fn error_of(stage: &Stage, bases: &ObjectBases, light: &RadiosityLight) -> f32 {
    let surface = MeshSurface::new(&stage.now.mesh, &stage.rays, &stage.two_sided, BLACK);
    let by_rays = |at: &Surfel| -> f32 {
        let frame = lapidary_core::sphere::frame_around(at.normal);
        let origin = at.position + at.normal * surface.offset();
        let radiance = |i: usize| {
            let (u, v) = ((i as f32 + 0.5) / 4096.0, (i as f32 * lapidary_core::sphere::GOLDEN_TURN).fract());
            let hit = surface.first_hit(origin, frame * lapidary_core::sphere::cosine_direction(u, v));
            hit.map_or(0.0, |hit| 0.7 * std::f32::consts::FRAC_1_PI * smooth(hit.position))
        };
        (0..4096).map(radiance).sum::<f32>() * std::f32::consts::PI / 4096.0
    };
    let finest = bases.level(bases.levels() - 1);
    let pairs = finest.step_by(37).map(|i| {
        let at = &bases.points()[i];
        (irradiance(&light.total[i], at.normal).x, by_rays(at))
    });
    // No ray leaves a covered function, which stands for its neighbors.
    let pairs: Vec<(f32, f32)> = pairs.filter(|(_, by_rays)| *by_rays > 0.0).collect();
    let mean = pairs.iter().map(|(_, e)| e).sum::<f32>() / pairs.len() as f32;
    (pairs.iter().map(|(f, e)| (f - e).powi(2)).sum::<f32>() / pairs.len() as f32).sqrt() / mean
}

#[test]
fn a_bounce_is_that_of_rays_and_few_gathers_give_the_light_of_all() {
    let (stage, bases, values) = room_with_block(24_000);
    let of = |threshold: f32| {
        let mut solver = Radiosity::new(bases.clone(), RadiositySettings { threshold, ..settings(1) });
        let light = solved(&mut solver, &stage, &values.lit());
        let (sum, count) = finest(&solver, &light).fold((0.0, 0.0), |(sum, count), e| (sum + e.x, count + 1.0));
        (light, sum / count)
    };
    let ((mut some, few), (all, most)) = (of(RadiositySettings::DEFAULT.threshold), of(0.0));
    assert!((few / most - 1.0).abs() < 0.01, "{few} for {most}");
    assert!(2 * some.gathers < all.gathers, "{} of {}", some.gathers, all.gathers);
    let [by_some, by_all, by_fewest] = [&some, &all, &of(10.0).0].map(|light| error_of(&stage, &bases, light));
    assert!(by_some < 0.03 && by_some < by_all + 0.002, "{by_some} {by_all}");
    assert!(by_fewest > 0.05, "negative control: {by_fewest}");
    some.total.iter_mut().for_each(|vector| *vector *= 1.1);
    assert!(error_of(&stage, &bases, &some) > 0.06, "negative control: {}", error_of(&stage, &bases, &some));
}

#[test]
fn after_a_move_a_partial_solve_is_a_whole_one_and_the_way_back_leads_back() {
    let (stage, bases, values) = room_with_block(6000);
    let moved = stage.moved(1, Vec3::new(-0.5, 0.0, -0.3));
    let whole = |stage: &Stage| {
        let mut solver = Radiosity::new(bases.clone(), settings(3));
        solved(&mut solver, stage, &values.lit()).total
    };
    let mut solver = Radiosity::new(bases.clone(), settings(3));
    let mut after = |stage: &Stage, now: Bounds, left: &[Bounds]| {
        solver.follow(&stage.surface(), &BTreeMap::from([(1, now)]), left);
        (solved(&mut solver, stage, &values.lit()).total, solver.traced_again(), 8 * solver.table().bytes() / 64)
    };
    let nowhere = Bounds::around([Vec3::splat(99.0)]);
    let (before, ..) = after(&stage, nowhere, &[]);
    assert!(before == whole(&stage));
    let (there, rays, kept) = after(&moved, moved.bounds(1), &[stage.bounds(1)]);
    assert!(there == whole(&moved) && there != before);
    assert!(rays > 0 && 2 * rays < kept, "{rays} of {kept}");
    let (back, ..) = after(&stage, stage.bounds(1), &[moved.bounds(1)]);
    assert!(back == before);
    let (forgotten, ..) = after(&moved, nowhere, &[stage.bounds(1)]);
    assert!(forgotten != there, "negative control: the new box is forgotten");

    // Two moves before a solution: the first reached other rays than the second.
    let mut solver = Radiosity::new(bases.clone(), settings(3));
    let far = stage.moved(1, Vec3::new(0.4, 0.9, 0.3));
    let block = |stage: &Stage| BTreeMap::from([(1, stage.bounds(1))]);
    solved(&mut solver, &stage, &values.lit());
    solver.follow(&far.surface(), &block(&far), &[stage.bounds(1)]);
    let mut light = solver.begin(&far.surface(), &values.lit());
    assert_eq!(solver.advance(&far.surface(), &values.lit(), &mut light, 50), RadiosityStep::Partial);
    solver.follow(&moved.surface(), &block(&moved), &[far.bounds(1)]);
    assert!(solved(&mut solver, &moved, &values.lit()).total == there, "a solution may be left for the next move");
}

#[test]
fn light_in_parts_or_without_room_for_its_rays_is_the_same() {
    let (stage, bases, mut values) = room_with_block(6000);
    values.emitted[7] = Vec3::ONE;
    let of = |table_bytes: u64, receivers: usize| {
        let settings = RadiositySettings { table_bytes, ..settings(2) };
        let (surface, mut solver) = (stage.surface(), Radiosity::new(bases.clone(), settings));
        let mut light = solver.begin(&surface, &values.lit());
        let mut parts = 0;
        while solver.advance(&surface, &values.lit(), &mut light, receivers) != RadiosityStep::Last {
            parts += 1;
        }
        assert!(solver.table().bytes() <= table_bytes);
        (light.total, parts)
    };
    let (whole, bounces) = of(u64::MAX, usize::MAX);
    let (in_parts, parts) = of(u64::MAX, 100);
    let (half_kept, _) = of(4096 * 1000, 100);
    assert!(bounces < 3 && parts > 10, "{bounces} {parts}");
    assert!(in_parts == whole && half_kept == whole);
    values.emitted[7] = Vec3::ZERO;
    let mut dark = Radiosity::new(bases.clone(), settings(2));
    assert!(solved(&mut dark, &stage, &values.lit()).total != whole, "negative control");
}

#[test]
fn the_first_leaf_stands_for_a_place_on_its_own_side() {
    let (stage, bases, _) = room_with_block(24_000);
    let tree = FunctionTree::new(&bases);
    let surface = MeshSurface::new(&stage.now.mesh, &stage.rays, &stage.two_sided, BLACK);
    let (points, _) = surface.uniform_points(512 * 20, 5);
    // Light that differs from wall to wall.
    let light = |p: &Surfel| (0.3 + smooth(p.position)) * (1.5 + p.normal.dot(Vec3::new(0.3, -0.9, 0.2)));
    let coefficients: Vec<f32> = bases.points().iter().map(light).collect();
    let exact = |at: &Surfel| {
        let mut values = Vec::new();
        bases.values(bases.sender_level(), surface.owner(at).object, at, &mut values);
        values.iter().map(|&(function, value)| coefficients[function as usize] * value).sum::<f32>()
    };
    let by = |at: &Surfel, normal: Vec3| {
        coefficients[tree.find(surface.owner(at), &Surfel { normal, ..*at }).expect("every owner has one") as usize]
    };
    // Means over as many places as a receiver has rays, near one another.
    let error = |of: &dyn Fn(&Surfel) -> f32| {
        let squared = |rays: &[Surfel]| {
            let [found, exact] = [rays.iter().map(of).sum::<f32>(), rays.iter().map(exact).sum::<f32>()];
            (found / exact - 1.0).powi(2)
        };
        (points.chunks_exact(512).map(squared).sum::<f32>() / (points.len() / 512) as f32).sqrt()
    };
    let [found, blind] = [error(&|at| by(at, at.normal)), error(&|at| by(at, -at.normal))];
    assert!(found < 0.02, "{found}");
    assert!(blind > 0.02, "negative control: {blind}");
    let is_wrong = |at: &&Surfel| {
        let function = tree.find(surface.owner(at), at).expect("every owner has one") as usize;
        assert!(bases.level(bases.sender_level()).contains(&function) && bases.owners()[function] == surface.owner(at));
        bases.points()[function].normal.dot(at.normal) < 0.5
    };
    let wrong = points.iter().filter(is_wrong).count();
    assert!(100 * wrong < points.len(), "{wrong} of {}", points.len());
}

#[test]
fn every_side_of_every_part_has_a_function_on_every_level_and_they_are_apart() {
    let specks = cuboid(Vec3::new(0.5, 0.5, 0.5), Vec3::splat(0.002));
    let stage = Stage::new(&[floor(1.0, 0.0).to_vec(), specks]);
    let bases = stage.bases(2000);
    for level in 0..bases.levels() {
        let functions = bases.level(level);
        for object in 0..2 {
            assert!(functions.clone().any(|i| bases.owners()[i].object == object), "{level} {object}");
        }
        let spacing = bases.radii()[level] / OVERLAP;
        let of_floor: Vec<&Surfel> =
            functions.filter(|&i| bases.owners()[i].object == 0).map(|i| &bases.points()[i]).collect();
        for (i, a) in of_floor.iter().enumerate() {
            assert!(of_floor[..i].iter().all(|b| a.position.distance(b.position) >= 0.999 * spacing));
        }
    }
    let near = bases.len() as f32 / 2000.0;
    assert!((0.6..1.5).contains(&near), "{}", bases.len());
}
