//! What leaves see, and their light by it, under one pose after another: on the cores here, on a graphics adapter in
//! [`super::gpu_sight`].

use super::gpu_sight::GpuSight;
use crate::device::{Compute, SeenLight};
use glam::Vec3;
use lapidary_core::implicit::{
    BinLayout, Bins, Drag, LeafLight, Lighting, Views, disc_forest::DiscForest, forest::SurfelForest,
};
use std::{borrow::Cow, collections::BTreeSet, ops::Range};

/// What the leaves of a forest see.
pub trait LeafSight: Send {
    /// Looks anew. `positions` are those of the vertices in meters, to which the forest was updated, and `changed` the objects that
    /// moved since the last call. While they are always the same, what is seen of the others is kept.
    fn look(&mut self, forest: &SurfelForest, positions: &[Vec3], changed: &BTreeSet<u32>);

    /// What some leaves see, and maybe more. The forest is as it was at the last look.
    fn views(&mut self, forest: &DiscForest, leaves: Range<u32>) -> Cow<'_, Views>;

    /// Their light with so many bounces. The forest is as it was at the last look.
    fn light(&mut self, forest: &DiscForest, lighting: &Lighting, bounces: u32) -> SeenLight;
}

/// What looks for the leaves of a forest on a mesh of so many vertices.
pub fn sight(compute: &Compute, forest: &SurfelForest, vertices: usize, layout: BinLayout) -> Box<dyn LeafSight> {
    let Compute::Device(device) = compute else { return Box::new(CoreSight::new(layout)) };
    match GpuSight::new(device, forest, vertices, layout) {
        Some(sight) => Box::new(sight),
        None => Box::new(CoreSight::new(layout)),
    }
}

/// What leaves see, found by the cores.
pub struct CoreSight {
    layout: BinLayout,
    views: Views,
    /// While the same objects move: what is seen of the others.
    drag: Option<Drag>,
}

impl CoreSight {
    /// Before the first look.
    pub fn new(layout: BinLayout) -> Self {
        Self { layout, views: Views::of_nodes(layout, 0, Vec::new()), drag: None }
    }

    /// Looks anew, as [`LeafSight::look`].
    pub fn see(&mut self, forest: &DiscForest, changed: &BTreeSet<u32>) {
        let known = self.drag.take().filter(|drag| drag.objects() == changed);
        self.views = if changed.is_empty() {
            Bins::walk(forest, self.layout, &|_| true).views()
        } else {
            let begin = || Drag::begin(forest, self.layout, changed.clone());
            self.drag.insert(known.unwrap_or_else(begin)).frame(forest)
        };
    }
}

impl LeafSight for CoreSight {
    fn look(&mut self, forest: &SurfelForest, _: &[Vec3], changed: &BTreeSet<u32>) {
        self.see(forest.discs(), changed);
    }

    fn views(&mut self, _: &DiscForest, _: Range<u32>) -> Cow<'_, Views> {
        Cow::Borrowed(&self.views)
    }

    fn light(&mut self, forest: &DiscForest, lighting: &Lighting, bounces: u32) -> SeenLight {
        let of_sky = self.views.irradiance_of_sky(forest, lighting.sky);
        // The sky is looked at once.
        let received: Vec<Vec3> = lighting.received.iter().zip(&of_sky).map(|(light, sky)| *light + *sky).collect();
        let without_sky = Lighting { received: &received, sky: &|_| Vec3::ZERO, ..*lighting };
        let LeafLight { direct, bounced, .. } = LeafLight::new(forest, &self.views, &without_sky, bounces);
        let direct = direct.iter().zip(&of_sky).map(|(direct, sky)| *direct + *sky).collect();
        SeenLight { of_sky, direct, bounced }
    }
}
