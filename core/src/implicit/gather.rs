//! Light from the views of leaves (implicit visibility, 4.3 and 4.4): bounce by bounce, gathered by leaves and pulled up.

use super::{direct::EMPTY, views::Views};
use crate::{
    implicit::disc_forest::DiscForest,
    transport::{BounceEnergy, LightTransport, Series, Surfaces},
};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, ops::Range};

/// Radiance of the sky by unit direction.
pub type Sky<'a> = &'a (dyn Fn(Vec3) -> Vec3 + Sync);

/// Light and reflectance of the leaves of a forest, one entry each.
#[derive(Clone, Copy)]
pub struct Lighting<'a> {
    /// Diffuse reflectance, 0 to 1 per channel.
    pub reflectance: &'a [Vec3],
    /// Emitted radiance: area lights are emitting surfaces (4.4).
    pub emitted: &'a [Vec3],
    /// Irradiance by light outside the bins, such as point lights and suns.
    pub received: &'a [Vec3],
    /// Light in empty bins (4.4).
    pub sky: Sky<'a>,
}

/// Irradiance of the leaves of a forest, one entry each.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafLight {
    /// Irradiance from the sky and emitting leaves, without [`Lighting::received`].
    pub direct: Vec<Vec3>,
    /// Irradiance from all bounces.
    pub bounced: Vec<Vec3>,
    /// Energy per bounce.
    pub energy: BounceEnergy,
}

impl LeafLight {
    /// The Neumann series up to `bounces`.
    pub fn new(forest: &DiscForest, views: &Views, lighting: &Lighting, bounces: u32) -> Self {
        let transport = LeafTransport { forest, views };
        let emitted: Vec<Vec3A> = lighting.emitted.iter().map(|&radiance| radiance.into()).collect();
        let direct =
            add(&transport.bounce(&emitted, 0..transport.senders()), &views.irradiance_of_sky(forest, lighting.sky));
        let surfaces = LeafSurfaces { forest, reflectance: lighting.reflectance };
        // Emitted light has arrived with the direct light.
        let series = Series::new(&transport, &surfaces, add(&direct, lighting.received), None).with_bounces(bounces);
        Self { energy: series.energy(), bounced: series.received, direct }
    }
}

/// One bounce between leaves by their views: radiance to irradiance, `E = π/n² Σ L` over n x n bins.
struct LeafTransport<'a> {
    forest: &'a DiscForest,
    views: &'a Views,
}

impl LightTransport for LeafTransport<'_> {
    type Sent = Vec3A;
    type Received = Vec3;

    fn senders(&self) -> usize {
        self.views.leaves()
    }

    fn bounce(&self, sent: &[Vec3A], receivers: Range<usize>) -> Vec<Vec3> {
        let radiance = self.forest.pull(sent);
        let seen = |&node: &u32| if node == EMPTY { Vec3A::ZERO } else { radiance[node as usize] };
        let gather = |leaf: u32| self.views.of_leaf(leaf).iter().map(seen).sum::<Vec3A>();
        let weight = self.views.layout().cells.weight();
        of_leaves(receivers, |leaf| Vec3::from(gather(leaf)) * weight)
    }
}

/// Diffuse surfaces of the leaves.
struct LeafSurfaces<'a> {
    forest: &'a DiscForest,
    reflectance: &'a [Vec3],
}

impl Surfaces<LeafTransport<'_>> for LeafSurfaces<'_> {
    /// Irradiance of the leaves.
    type Arriving = Vec<Vec3>;

    fn arriving(&self, received: Vec<Vec3>) -> Vec<Vec3> {
        received
    }

    fn reflected(&self, irradiance: &Vec<Vec3>) -> Vec<Vec3A> {
        irradiance.iter().zip(self.reflectance).map(|(e, rho)| (*e * *rho * FRAC_1_PI).into()).collect()
    }

    fn mean_irradiance(&self, irradiance: &Vec<Vec3>) -> Vec3 {
        let discs = self.forest.discs();
        let energy: Vec3 = irradiance.iter().zip(discs).map(|(e, disc)| *e * disc.area).sum();
        energy / discs.iter().map(|disc| disc.area).sum::<f32>().max(f32::MIN_POSITIVE)
    }
}

impl Views {
    /// Irradiance of each leaf from the sky in its empty bins.
    pub fn irradiance_of_sky(&self, forest: &DiscForest, sky: Sky) -> Vec<Vec3> {
        let layout = self.layout();
        let directions: Vec<Vec3> = (0..layout.cells.len()).map(|cell| layout.cells.direction_of(cell)).collect();
        let gather = |leaf: u32| {
            let frame = layout.frame_of(&forest.discs()[leaf as usize]);
            let empty = directions.iter().zip(self.of_leaf(leaf)).filter(|(_, node)| **node == EMPTY);
            empty.map(|(&direction, _)| sky(frame * direction)).sum::<Vec3>()
        };
        of_leaves(0..self.leaves(), |leaf| gather(leaf) * layout.cells.weight())
    }
}

fn of_leaves(leaves: Range<usize>, value: impl Fn(u32) -> Vec3 + Sync) -> Vec<Vec3> {
    leaves.into_par_iter().with_min_len(64).map(|leaf| value(leaf as u32)).collect()
}

fn add(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}
