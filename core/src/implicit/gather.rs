//! Light from what leaves see (implicit visibility, 4.3 and 4.4): bounce by bounce, gathered by leaves and pulled up.

use super::{
    direct::{CELLS, EMPTY},
    views::Views,
};
use crate::surfel::disc_forest::DiscForest;
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Radiance of the sky by unit direction.
pub type Sky<'a> = &'a (dyn Fn(Vec3) -> Vec3 + Sync);

/// What lights the leaves of a forest, one entry each.
#[derive(Clone, Copy)]
pub struct Lighting<'a> {
    /// Diffuse reflectance, 0 to 1 per channel.
    pub reflectance: &'a [Vec3],
    /// Radiance that they emit: area lights are surfaces that send (4.4).
    pub emitted: &'a [Vec3],
    /// Irradiance by light that bins do not see, as that of points and suns.
    pub received: &'a [Vec3],
    /// What empty bins see (4.4).
    pub sky: Sky<'a>,
}

/// Irradiance of the leaves of a forest, one entry each.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafLight {
    /// By what emits: the sky and other leaves, without [`Lighting::received`].
    pub direct: Vec<Vec3>,
    /// By all bounces.
    pub bounced: Vec<Vec3>,
}

impl LeafLight {
    /// The Neumann series up to so many bounces.
    pub fn new(forest: &DiscForest, views: &Views, lighting: &Lighting, bounces: usize) -> Self {
        let direct = add(
            &views.irradiance(&forest.pull(&wide(lighting.emitted))),
            &views.irradiance_of_sky(forest, lighting.sky),
        );
        let mut light = Self { bounced: vec![Vec3::ZERO; direct.len()], direct };
        let mut last = add(&light.direct, lighting.received);
        for _ in 0..bounces {
            let sent: Vec<Vec3A> =
                last.iter().zip(lighting.reflectance).map(|(e, r)| (*e * *r * FRAC_1_PI).into()).collect();
            last = views.irradiance(&forest.pull(&sent));
            light.bounced = add(&light.bounced, &last);
        }
        light
    }
}

impl Views {
    /// Irradiance of each leaf from the radiance of nodes, without the sky: `E = π/400 Σ L`.
    pub fn irradiance(&self, radiance: &[Vec3A]) -> Vec<Vec3> {
        let seen = |&node: &u32| if node == EMPTY { Vec3A::ZERO } else { radiance[node as usize] };
        let gather = |leaf: u32| self.of_leaf(leaf).iter().map(seen).sum::<Vec3A>();
        self.of_leaves(|leaf| Vec3::from(gather(leaf)) * CELLS.weight())
    }

    /// Irradiance of each leaf from the sky in its empty bins.
    pub fn irradiance_of_sky(&self, forest: &DiscForest, sky: Sky) -> Vec<Vec3> {
        let gather = |leaf: u32| {
            let cells = self.directions(forest, leaf).zip(self.of_leaf(leaf));
            cells.filter(|(_, node)| **node == EMPTY).map(|(direction, _)| sky(direction)).sum::<Vec3>()
        };
        self.of_leaves(|leaf| gather(leaf) * CELLS.weight())
    }

    fn of_leaves(&self, value: impl Fn(u32) -> Vec3 + Sync) -> Vec<Vec3> {
        (0..self.leaves() as u32).into_par_iter().with_min_len(64).map(&value).collect()
    }
}

fn add(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}

fn wide(values: &[Vec3]) -> Vec<Vec3A> {
    values.iter().map(|&value| value.into()).collect()
}
