//! Visibility of leaves and the light they receive, in one pose after another: on the cores here, on a graphics adapter in
//! [`super::gpu_sight`].

use super::{covered::Open, cuts::NewCuts, gloss::Gloss, gpu_sight::GpuSight, vertices::VertexLeaves};
use crate::device::{Compute, DeviceCuts, SeenLight, VertexPlanes};
use glam::Vec3;
use lapidary_core::{
    implicit::{BinLayout, Bins, Drag, LeafLight, Lighting, Views, disc_forest::DiscForest, forest::SurfelForest},
    scene::Mesh,
    surfel::Surfel,
};
use std::{borrow::Cow, collections::BTreeSet, ops::Range};

/// What is asked of the light of vertices where visibility is.
pub struct VertexLighting<'a> {
    /// Light of the leaves and the bounces to follow, unless that of the last call stays.
    pub relight: Option<(Lighting<'a>, u32)>,
    pub beside: &'a VertexLeaves,
    pub open: &'a Open,
    /// `VERTEX_...` of each vertex.
    pub states: &'a [u32],
    /// The glossy leaves on their mesh.
    pub gloss: &'a Gloss,
    pub mesh: &'a Mesh,
    pub surfels: &'a [Surfel],
    /// What they reflect toward which eye, if they do so.
    pub reflection: Option<Reflection>,
    /// Light as baked, from which a pose differs; `None` for that light itself.
    pub as_baked: Option<&'a VertexPlanes>,
}

/// What glossy leaves reflect toward the eye: the sky, and maybe other leaves.
#[derive(Clone, Copy)]
pub struct Reflection {
    /// Position of the eye in meters.
    pub eye: Vec3,
    /// Whether they reflect other leaves, too.
    pub has_sent: bool,
}

/// Visibility of the leaves of a forest.
pub trait LeafSight: Send {
    /// Recomputes visibility. The forest was updated to `positions`, the vertices in meters; `changed` are the objects moved since
    /// the last call. Visibility of the others is kept as long as `changed` stays the same.
    fn look(&mut self, forest: &SurfelForest, positions: &[Vec3], changed: &BTreeSet<u32>);

    /// Visibility of at least these leaves. The forest must not have changed since the last look.
    fn views(&mut self, forest: &DiscForest, leaves: Range<u32>) -> Cow<'_, Views>;

    /// New cuts made where visibility is; `None` if views have to tell. The forest must not have changed since the last look.
    fn cuts(&mut self, _: &DiscForest, _: &NewCuts) -> Option<DeviceCuts> {
        None
    }

    /// Whether [`Self::at_vertices`] lights vertices beside glossy leaves on a mesh. If not, the cores do.
    fn lights_vertices(&mut self, _: &Gloss, _: &Mesh, _: &[Surfel]) -> bool {
        false
    }

    /// Light of vertices made where visibility is, after [`Self::lights_vertices`]; `None` if the cores have to make it. The forest must
    /// not have changed since the last look.
    fn at_vertices(&mut self, _: &DiscForest, _: &VertexLighting) -> Option<VertexPlanes> {
        None
    }

    /// Light of the leaves with `bounces` bounces. The forest must not have changed since the last look.
    fn light(&mut self, forest: &DiscForest, lighting: &Lighting, bounces: u32) -> SeenLight;
}

/// Visibility by the cores or an adapter, for a forest on a mesh with `vertices` vertices.
pub fn sight(compute: &Compute, forest: &SurfelForest, vertices: usize, layout: BinLayout) -> Box<dyn LeafSight> {
    let Compute::Device(device) = compute else { return Box::new(CoreSight::new(layout)) };
    match GpuSight::new(device, forest, vertices, layout) {
        Some(sight) => Box::new(sight),
        None => Box::new(CoreSight::new(layout)),
    }
}

/// Leaf visibility, computed by the cores.
pub struct CoreSight {
    layout: BinLayout,
    views: Views,
    /// Stored visibility of unmoved objects while the same objects move.
    drag: Option<Drag>,
}

impl CoreSight {
    /// Creates the state before the first look.
    pub fn new(layout: BinLayout) -> Self {
        Self { layout, views: Views::of_nodes(layout, 0, Vec::new()), drag: None }
    }

    /// Recomputes visibility, as [`LeafSight::look`].
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
        // The sky's light is found once.
        let received: Vec<Vec3> = lighting.received.iter().zip(&of_sky).map(|(light, sky)| *light + *sky).collect();
        let without_sky = Lighting { received: &received, sky: &|_| Vec3::ZERO, ..*lighting };
        let LeafLight { direct, bounced, .. } = LeafLight::new(forest, &self.views, &without_sky, bounces);
        let direct = direct.iter().zip(&of_sky).map(|(direct, sky)| *direct + *sky).collect();
        SeenLight { of_sky, direct, bounced }
    }
}
