//! How far the bounced light that vertices gather has moved since their pixels were shaded. An edited material changes
//! the light of all that it shines on, most of it by less than a display can show.

use crate::{
    baked::Baked,
    light::{bounce::SourceLighting, local::LocalLighting},
};
use glam::{Mat3A, Vec3};
use lapidary_core::cut::{
    merge::merge,
    packed::{PackedCursor, VALUE_MAX},
    solid_angle,
};
use rayon::prelude::*;

/// Largest change of a vertex's gathered light, as a share of it, that is left in the picture: half a step of 8 bits. The
/// pixel's other light only makes it less.
const NOT_SEEN: f32 = 1.0 / 512.0;

/// The change of each vertex's gathered light since its pixels were shaded, as a share of it. Changes of many edits are
/// added, so that small ones cannot creep.
#[derive(Default)]
pub(crate) struct Drift(Vec<f32>);

impl Drift {
    /// All pixels are shaded again.
    pub fn reset(&mut self) {
        self.0.clear();
    }

    /// Adds the change from one light to another. Returns the patches that are to be shaded again, one bit each; `None` for
    /// all.
    pub fn add(&mut self, baked: &Baked, old: &LocalLighting, new: &LocalLighting) -> Option<u64> {
        let changes = changes(baked, old, new)?;
        let patches = baked.patches();
        self.0.resize(changes.len(), 0.0);
        let mut stale = 0;
        for ((drift, change), &patch) in self.0.iter_mut().zip(changes).zip(&*patches) {
            *drift += change;
            // NaN is a change.
            stale |= u64::from(!(*drift <= NOT_SEEN)) << patch;
        }
        let shaded = self.0.iter_mut().zip(&*patches).filter(|(_, patch)| stale >> **patch & 1 != 0);
        shaded.for_each(|(drift, _)| *drift = 0.0);
        Some(stale)
    }
}

/// Change of each vertex's light as a share of it; `None` if both are not of one kind.
fn changes(baked: &Baked, old: &LocalLighting, new: &LocalLighting) -> Option<Vec<f32>> {
    match (old.shown_indirect(), new.shown_indirect()) {
        (Some(old), Some(new)) => return gathered_changes(baked, old, new),
        (None, None) => {}
        _ => return None,
    }
    let (old, new) = old.shown_vertex_irradiance().zip(new.shown_vertex_irradiance())?;
    if old.back.len() != new.back.len() {
        return None;
    }
    let side = |old: &[Mat3A], new: &[Mat3A]| -> Vec<f32> {
        old.par_iter().zip(new).map(|(old, new)| share(lengths(*new - *old), lengths(*new))).collect()
    };
    let (front, back) = (side(&old.front, &new.front), side(&old.back, &new.back));
    let of_both = |(vertex, front): (usize, f32)| back.get(vertex).map_or(front, |&back| front + back);
    Some(front.into_iter().enumerate().map(of_both).collect())
}

fn lengths(vector: Mat3A) -> Vec3 {
    Vec3::new(vector.x_axis.length(), vector.y_axis.length(), vector.z_axis.length())
}

/// Of the light in its brightest channel.
fn share(change: Vec3, light: Vec3) -> f32 {
    if change == Vec3::ZERO { 0.0 } else { change.max_element() / light.max_element() }
}

/// Sums over the nodes of each vertex's cut: the change of their radiance times their solid angle, whether brighter or
/// darker, over the light that they send now.
fn gathered_changes(baked: &Baked, old: &SourceLighting, new: &SourceLighting) -> Option<Vec<f32>> {
    let cuts = &baked.dataset.indirect.as_ref()?.cuts;
    let height = new.tree.height();
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
