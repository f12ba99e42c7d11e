//! How far the bounced light has moved since the pixels that it shows in were shaded. An edited material changes
//! the light of all that it shines on, most of it by less than a display can show.

use crate::{
    baked::Baked,
    light::{
        bounce::{SourceLighting, meshless::compared::ComparedPoints},
        local::LocalLighting,
        solver::BounceLight,
    },
};
use glam::Vec3;
use lapidary_core::cut::{
    merge::merge,
    packed::{PackedCursor, VALUE_MAX},
    solid_angle,
};
use rayon::prelude::*;

/// Largest change of the light at a point, as a share of it, that is left in the picture: half a step of 8 bits. The
/// pixel's other light only makes it less.
const NOT_SEEN: f32 = 1.0 / 512.0;

/// The change of the bounced light at points of the surfaces since their pixels were shaded, as a share of it. Changes of
/// many edits are added, so that small ones cannot creep.
#[derive(Default)]
pub(crate) struct Drift {
    changes: Vec<f32>,
    /// Where light in a basis is compared; found at the first use.
    points: Option<ComparedPoints>,
}

impl Drift {
    /// All pixels are shaded again.
    pub fn reset(&mut self) {
        self.changes.clear();
    }

    /// Adds the change from one light to another. Returns the patches that are to be shaded again, one bit each; `None` for
    /// all. It is always called for one scene.
    pub fn add(&mut self, baked: &Baked, old: &LocalLighting, new: &LocalLighting) -> Option<u64> {
        let (changes, patches) = match (old.shown_bounce()?, new.shown_bounce()?) {
            (BounceLight::Sources(old), BounceLight::Sources(new)) => {
                let of_vertices = baked.patches().iter().map(|patch| 1 << patch).collect();
                (gathered_changes(baked, old, new)?, of_vertices)
            }
            (BounceLight::Functions(old), BounceLight::Functions(new)) => {
                if self.points.is_none() {
                    self.points = Some(ComparedPoints::new(baked)?);
                }
                self.points.as_ref()?.changes(old, new, share)
            }
            _ => return None,
        };
        Some(self.add_changes(changes, &patches))
    }

    /// Adds changes at points, each of which is in some patches.
    fn add_changes(&mut self, changes: Vec<f32>, patches: &[u64]) -> u64 {
        self.changes.resize(changes.len(), 0.0);
        let mut stale = 0;
        for ((drift, change), &patches) in self.changes.iter_mut().zip(changes).zip(patches) {
            *drift += change;
            // NaN is a change.
            stale |= if *drift <= NOT_SEEN { 0 } else { patches };
        }
        let shaded = self.changes.iter_mut().zip(patches).filter(|(_, patches)| stale & **patches != 0);
        shaded.for_each(|(drift, _)| *drift = 0.0);
        stale
    }
}

/// Of the light in its brightest channel.
fn share(change: Vec3, light: Vec3) -> f32 {
    if change == Vec3::ZERO { 0.0 } else { change.max_element() / light.max_element() }
}

/// Sums over the nodes of each vertex's cut: the change of their radiance times their solid angle, whether brighter or
/// darker, over the light that they send now.
fn gathered_changes(baked: &Baked, old: &SourceLighting, new: &SourceLighting) -> Option<Vec<f32>> {
    let cuts = &baked.dataset.indirect.as_ref()?.cuts;
    let height = new.height();
    let solid_angles: Vec<f32> = (0..=VALUE_MAX).map(solid_angle).collect();
    let of_vertex = |vertex: u32| {
        let (mut change, mut light) = (Vec3::ZERO, Vec3::ZERO);
        merge(1 << height, &mut [PackedCursor::new(height, cuts.nodes_from(vertex))], |interval, cursors| {
            let node = interval.heap_index(1 << height) as usize;
            let weight = solid_angles[usize::from(cursors[0].stored_value())] * interval.size() as f32;
            let (before, after) = (old.nodes.radiance[node], new.nodes.radiance[node]);
            change += (after - before).abs() * weight;
            light += after * weight;
        });
        share(change, light)
    };
    Some((0..cuts.len() as u32).into_par_iter().with_min_len(64).map(of_vertex).collect())
}
