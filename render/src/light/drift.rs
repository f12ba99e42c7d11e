//! How far bounced light has changed since its pixels were shaded. An edited material changes all the light that it reflects,
//! mostly by less than a display can show.

use crate::{
    baked::Baked,
    light::{
        bounce::{SourceLighting, meshless::compared::ComparedPoints},
        local::LocalLighting,
        solver::BounceLight,
    },
    shade::node_field::{NodeField, SourceField},
};
use glam::Vec3;
use lapidary_core::cut::{
    merge::merge,
    packed::{PackedCursor, VALUE_MAX},
    solid_angle,
};
use rayon::prelude::*;

/// Largest change of the light at a point, as a share of that light, that pixels keep: half an 8-bit step. The pixel's other light
/// only reduces the share.
const NOT_SEEN: f32 = 1.0 / 512.0;

/// Relative change of bounced light at surface points since their pixels were shaded. Changes accumulate over edits, so small ones
/// cannot creep.
#[derive(Default)]
pub(crate) struct Drift {
    changes: Vec<f32>,
    /// Points at which light in a basis is compared; found at the first use.
    points: Option<ComparedPoints>,
}

impl Drift {
    /// Call after all pixels are shaded again.
    pub fn reset(&mut self) {
        self.changes.clear();
    }

    /// Adds the change from one light to another. Returns the patches to shade again, one bit each; `None` means all. Every call
    /// must be for the same scene.
    pub fn add(&mut self, baked: &Baked, old: &LocalLighting, new: &LocalLighting) -> Option<u64> {
        let (changes, patches) = match (old.shown_bounce()?, new.shown_bounce()?) {
            (BounceLight::Sources(old), BounceLight::Sources(new)) => {
                let of_vertices = baked.patches().iter().map(|patch| 1 << patch).collect();
                (gathered_changes(baked, old, new)?, of_vertices)
            }
            (BounceLight::Functions(old), BounceLight::Functions(new))
                if [old, new].iter().all(|light| light.as_baked().is_none()) =>
            {
                if self.points.is_none() {
                    self.points = Some(ComparedPoints::new(baked)?);
                }
                self.points.as_ref()?.changes(old, new, share)
            }
            _ => return None,
        };
        Some(self.add_changes(changes, &patches))
    }

    /// Adds changes at points; each point belongs to some patches.
    fn add_changes(&mut self, changes: Vec<f32>, patches: &[u64]) -> u64 {
        self.changes.resize(changes.len(), 0.0);
        let mut stale = 0;
        for ((drift, change), &patches) in self.changes.iter_mut().zip(changes).zip(patches) {
            *drift += change;
            // NaN counts as a change.
            stale |= if *drift <= NOT_SEEN { 0 } else { patches };
        }
        let shaded = self.changes.iter_mut().zip(patches).filter(|(_, patches)| stale & **patches != 0);
        shaded.for_each(|(drift, _)| *drift = 0.0);
        stale
    }
}

/// Share in the light's brightest channel.
fn share(change: Vec3, light: Vec3) -> f32 {
    if change == Vec3::ZERO { 0.0 } else { change.max_element() / light.max_element() }
}

/// Relative change at each vertex: the absolute change of radiance times solid angle, summed over its cut, over the light that the
/// cut sends now.
fn gathered_changes(baked: &Baked, old: &SourceLighting, new: &SourceLighting) -> Option<Vec<f32>> {
    let cuts = &baked.dataset.indirect.as_ref()?.cuts;
    let height = new.height();
    let solid_angles: Vec<f32> = (0..=VALUE_MAX).map(solid_angle).collect();
    let fields = [old, new].map(SourceField::new);
    let of_vertex = |vertex: u32| {
        let (mut change, mut light) = (Vec3::ZERO, Vec3::ZERO);
        merge(1 << height, &mut [PackedCursor::new(height, cuts.nodes_from(vertex))], |interval, cursors| {
            let node = interval.heap_index(1 << height) as usize;
            let weight = solid_angles[usize::from(cursors[0].stored_value())] * interval.size() as f32;
            let direction = new.nodes.place[node] - baked.dataset.scene.mesh.positions[vertex as usize];
            let [before, after] = fields.map(|field| field.radiance(node, direction));
            change += (after - before).abs() * weight;
            light += after * weight;
        });
        share(change, light)
    };
    Some((0..cuts.len() as u32).into_par_iter().with_min_len(64).map(of_vertex).collect())
}
