//! The scene of a picture as rays see it: with its ground shown, hidden or catching shadows.

use crate::{
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::Backdrop,
        surface::{FirstHit, Surfaces},
    },
    stale::Marks,
    view::View,
};
use glam::Vec3;
use lapidary_core::{ground::Ground, ray::Hit, scene::Mesh};

/// The scene of a picture. By default maps are looked up at points.
#[derive(Clone, Copy)]
pub(crate) struct SeenScene<'a> {
    pub view: &'a View,
    pub backdrop: &'a Backdrop,
    /// The mesh, including its ground if any.
    pub mesh: &'a Mesh,
    pub surfaces: Surfaces<'a>,
}

impl<'a> SeenScene<'a> {
    pub fn new(renderer: &'a Renderer, view: &'a View, backdrop: &'a Backdrop) -> Self {
        let (mesh, surfaces) = (&renderer.dataset.scene.mesh, Surfaces::of(renderer));
        Self { view, backdrop, mesh, surfaces }
    }

    /// The scene that the mirrors of a picture show, if there are any and they do.
    pub fn in_mirrors(
        renderer: &'a Renderer,
        view: &'a View,
        sampling: BrdfSampling,
        backdrop: &'a Backdrop,
    ) -> Option<Self> {
        let shows = view.mirrors && sampling != BrdfSampling::Once && renderer.mirrors != Marks::default();
        shows.then(|| Self::new(renderer, view, backdrop))
    }

    /// A ray's hit, or the next one behind a hidden ground. The ground is always hidden from below.
    pub fn past_hidden_ground(
        &self,
        hit: Option<Hit>,
        ray: (Vec3, Vec3),
        threshold: impl Fn(u32) -> f32,
    ) -> Option<Hit> {
        let is_seen = self.view.ground() != Ground::Off;
        self.surfaces.past_ground(hit, ray, is_seen, threshold)
    }

    /// A camera ray's hit as seen. A ground that catches shadows reflects the background.
    pub fn seen(&self, hit: Option<Hit>, direction: Vec3) -> FirstHit {
        self.seen_before(hit, direction, Backdrop::caught)
    }

    /// What a mirror shows along a ray. A ground that catches shadows reflects the environment there, whatever the background.
    pub fn mirrored(&self, ray @ (origin, direction): (Vec3, Vec3), threshold: impl Fn(u32) -> f32) -> FirstHit {
        let first = self.surfaces.hit_above(origin, direction, &threshold);
        self.seen_before(self.past_hidden_ground(first, ray, threshold), direction, Backdrop::caught_in_mirrors)
    }

    fn seen_before(
        &self,
        hit: Option<Hit>,
        direction: Vec3,
        caught: impl Fn(&Backdrop, Vec3) -> Option<Vec3>,
    ) -> FirstHit {
        let seen = self.surfaces.seen_at(hit, direction);
        let is_ground = hit.is_some_and(|hit| self.mesh.is_ground(hit.triangle));
        match (seen, is_ground.then(|| caught(self.backdrop, direction)).flatten()) {
            (FirstHit::Surface(point), Some(reflectance)) => FirstHit::Surface(point.catching(reflectance).into()),
            (seen, _) => seen,
        }
    }
}
