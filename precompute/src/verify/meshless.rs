//! The meshless operator: recomputed links of some functions, and transported light against rays.

use super::Again;
use crate::meshless::transport::recompute::recompute_links;
use glam::Vec3;
use lapidary_core::{
    mesh_surface::MeshSurface,
    meshless::{MeshlessBake, Projection, Transport, irradiance},
    sphere::{cosine_direction, frame_around},
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;
use serde::Serialize;
use std::f32::consts::{PI, TAU};

/// Most functions with recomputed links: each needs about a hundred coarser ones.
const FUNCTIONS: usize = 64;
/// Points at which light is compared, and rays from each.
const POINTS: usize = 128;
const RAYS: usize = 512;

/// Results of a verification of the meshless basis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshlessVerification {
    /// Functions whose links were recomputed with new rays, including the ones they depend on.
    pub functions: usize,
    /// Number of these functions whose links differ from the stored ones by more than rounding.
    pub different_functions: usize,
    /// Points at which a bounce was compared with rays.
    pub points: usize,
    /// Relative root mean square error of its irradiance. The light varies smoothly over the scene.
    pub error: f64,
    /// Its mean irradiance relative to the rays' mean.
    pub energy: f64,
}

impl MeshlessVerification {
    /// `None` without a meshless basis.
    pub(super) fn of(again: &Again) -> Option<Self> {
        let bake = again.dataset.meshless.as_deref()?;
        let (surface, mut random) = (&again.surface, again.random());
        let picked = picked_functions(bake, again.count.min(FUNCTIONS), &mut random);
        let links = recompute_links(surface, &bake.basis, &again.dataset.settings.meshless, &picked);
        let stored = rows_of(&bake.transport);
        let differs = |(receiver, row): &&(usize, Vec<_>)| !agree(row, &stored[*receiver], bake.transport.scale());
        let pairs = compare_light(bake, surface, &mut random);
        let sum = |f: &dyn Fn(&(f32, f32)) -> f32| pairs.iter().map(|pair| f64::from(f(pair))).sum::<f64>();
        let squares = sum(&|(rays, _)| rays * rays).max(f64::MIN_POSITIVE);
        Some(Self {
            functions: links.len(),
            different_functions: links.iter().filter(differs).count(),
            points: pairs.len(),
            error: (sum(&|(rays, links)| (rays - links).powi(2)) / squares).sqrt(),
            energy: sum(&|p| p.1) / sum(&|p| p.0).max(f64::MIN_POSITIVE),
        })
    }

    /// Whether the links agree.
    pub(super) fn agrees(&self) -> bool {
        self.different_functions == 0
    }

    /// The result in sentences, one per line.
    pub(super) fn text(&self) -> String {
        let Self { functions, different_functions, points, error, energy } = self;
        format!(
            "made the links of {functions} functions again: {different_functions} differ; a smooth light at {points} points: \
             {:.1} % error against rays, {energy:.3} of the energy\n",
            100.0 * error
        )
    }
}

/// Random functions, equally many per level.
fn picked_functions(bake: &MeshlessBake, count: usize, random: &mut fastrand::Rng) -> Vec<usize> {
    let levels = bake.basis.levels();
    (0..levels).flat_map(|level| random.choose_multiple(bake.basis.level(level), count.div_ceil(levels))).collect()
}

/// The stored links by receiver, in ascending order of senders.
fn rows_of(transport: &Transport) -> Vec<Vec<(u32, Vec3)>> {
    let mut rows = vec![Vec::new(); transport.receivers()];
    transport.links().for_each(|(sender, receiver, vector)| rows[receiver].push((sender as u32, vector)));
    rows
}

/// Whether two rows have the same senders, and vectors that differ by at most half a packed step.
fn agree(made: &[(u32, Vec3)], stored: &[(u32, Vec3)], scale: f32) -> bool {
    let same = |(a, b): (&(u32, Vec3), &(u32, Vec3))| a.0 == b.0 && (a.1 - b.1).abs().max_element() <= 0.51 * scale;
    made.len() == stored.len() && made.iter().zip(stored).all(same)
}

/// Irradiance by rays and by the operator at points of random functions of the finest level, from surfaces whose radiance is a wave
/// of the scene's size.
fn compare_light(bake: &MeshlessBake, surface: &MeshSurface, random: &mut fastrand::Rng) -> Vec<(f32, f32)> {
    let (basis, levels) = (&bake.basis, bake.basis.levels());
    let radiance = smooth_light(surface);
    let sent: Vec<Vec3> = basis.sender_points().iter().map(|p| Vec3::splat(radiance(p))).collect();
    let sent = Projection::new(basis, basis.sender_levels()).pull_push(&sent);
    let received = bake.transport.apply(&sent, 0.0, 0..basis.len());
    let seeds: Vec<(usize, u64)> =
        random.choose_multiple(basis.level(levels - 1), POINTS).into_iter().map(|i| (i, i as u64)).collect();
    let pair = |&(function, seed): &(usize, u64)| {
        let point = &basis.points()[function];
        let vector = basis.evaluate(levels, point.position, point.normal, &received);
        (by_rays(surface, point, &radiance, seed), irradiance(&vector, point.normal).x)
    };
    seeds.par_iter().map(pair).collect()
}

/// Radiance that is a wave of the scene's size.
pub(super) fn smooth_light(surface: &MeshSurface) -> impl Fn(&Surfel) -> f32 + Sync + use<> {
    let wave = Vec3::new(1.0, 0.7, 0.4) * (TAU / surface.bounds().diagonal());
    move |at| 1.0 + 0.9 * at.position.dot(wave).cos()
}

/// Irradiance at a point by rays.
pub(super) fn by_rays(surface: &MeshSurface, at: &Surfel, radiance: impl Fn(&Surfel) -> f32, seed: u64) -> f32 {
    let (frame, origin) = (frame_around(at.normal), at.position + at.normal * surface.offset());
    let mut random = fastrand::Rng::with_seed(!seed);
    let ray = |i: usize| {
        let direction = frame * cosine_direction((i as f32 + random.f32()) / RAYS as f32, random.f32());
        surface.first_hit(origin, direction).map_or(0.0, |hit| radiance(&hit))
    };
    (0..RAYS).map(ray).sum::<f32>() * (PI / RAYS as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bake::{
            BakeJob, bake,
            settings::{Preset, resolve},
        },
        observer::Silent,
        test_scenes::{cuboid, room, scene_of},
        verify::verify,
    };
    use lapidary_core::{
        dataset::{BakeParts, BakeSettings, Dataset, MeshlessSettings},
        meshless::PackedLink,
    };
    use lapidary_interchange::image;

    fn baked() -> Dataset {
        let folder = tempfile::tempdir().unwrap();
        let mut triangles = room(Vec3::ZERO, Vec3::new(1.0, 0.7, 0.8));
        triangles.extend(cuboid(Vec3::new(0.3, -0.4, 0.2), Vec3::splat(0.2)));
        let meshless = MeshlessSettings { levels: 3, sender_levels: 2, rays: 128, ..Default::default() };
        let settings = BakeSettings { mode: BakeParts::MESHLESS, meshless, lights: 256, ..Preset::Draft.settings() };
        let job = BakeJob::new(
            resolve(BakeSettings { max_vertices: None, ..settings }).unwrap(),
            folder.path().join("a.cuts"),
        );
        bake(scene_of(&triangles), &job, &Silent).unwrap();
        Dataset::read(&job.output, image::decode).unwrap()
    }

    /// The dataset with other links of the same layout.
    fn damaged(dataset: &Dataset, damage: impl Fn(usize, PackedLink) -> PackedLink) -> Dataset {
        let mut damaged = dataset.clone();
        let transport = &mut std::sync::Arc::make_mut(damaged.meshless.as_mut().unwrap()).transport;
        let links = transport.packed().iter().enumerate().map(|(i, &link)| damage(i, link)).collect();
        let size = [transport.receivers(), transport.senders()];
        *transport = Transport::from_parts(size, transport.scale(), transport.offsets().to_vec(), links).unwrap();
        damaged
    }

    #[test]
    fn fresh_links_agree_and_damaged_ones_do_not() {
        let dataset = baked();
        let good = verify(&dataset, 64);
        let found = good.meshless.clone().unwrap();
        assert!(good.passed && found.functions > 64 && found.points == POINTS, "{good:?}");
        assert!(found.error < 0.06 && (found.energy - 1.0).abs() < 0.03, "{found:?}");

        let dimmed = damaged(&dataset, |_, link| PackedLink { vector: link.vector.map(|v| v / 2), ..link });
        let dimmed = verify(&dimmed, 64);
        let of = dimmed.meshless.unwrap();
        assert!(!dimmed.passed && of.energy < 0.6 && of.error > 0.3, "{of:?}");

        let nudge = |v: i16| if v > i16::MAX - 3 { v - 3 } else { v + 3 };
        let nudged = damaged(&dataset, |_, link| PackedLink { vector: link.vector.map(nudge), ..link });
        assert!(!verify(&nudged, 64).passed, "three steps are noticed");

        let mut moved = dataset.clone();
        moved.settings.meshless.epsilon *= 1.5;
        assert!(!verify(&moved, 64).passed, "links of another epsilon");
    }
}
