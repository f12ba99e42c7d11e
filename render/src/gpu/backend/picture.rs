//! The picture that is being made: its targets, and what its passes read.

use super::{GpuBackend, groups::Groups};
use crate::{
    device::{
        layout,
        pass::{Pass, compile_now},
    },
    error::BackendError,
    gpu::passes::{PartPass, check},
    post::Post,
    sampling::BrdfSampling,
    shade::mirrors::DEEPEST,
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::{Vec2, Vec3};

/// The picture that is being made.
pub struct Picture {
    pub view: View,
    pub offsets: Vec<Vec2>,
    pub count_top: f32,
    /// Corners of the triangles that it shows.
    pub corners: u32,
    pub groups: Groups,
    /// The passes that add samples.
    pub passes: Vec<PartPass>,
    /// Those that give the light of what one mirror shows, and of what a mirror in it shows; none without mirrors.
    pub mirrored: [Vec<PartPass>; DEEPEST as usize],
    /// All that a sample takes, and its display.
    pub needed: Vec<Pass>,
    pub lattices: Lattices,
    /// Reflectance of a ground that catches shadows for a radiance of 1 behind it, if there is one.
    pub catches: Option<Vec3>,
    /// The sample of which the deferred buffers tell.
    pub seen: u32,
}

impl Picture {
    /// Where a sample is in its pixel.
    pub fn offset(&self, sample: u32) -> Vec2 {
        self.offsets[sample as usize % self.offsets.len()]
    }

    /// Whether mirrors show the scene.
    pub fn has_mirrors(&self) -> bool {
        self.groups.mirrored.is_some()
    }

    /// Whether the ground tells the share of the light that it lets through, for an alpha channel.
    pub fn lets_light_through(&self) -> bool {
        self.catches.is_some() && self.view.background == Background::Transparent
    }

    /// Uniforms of what a display shows of it.
    pub fn display(&self, post: &Post) -> layout::Display {
        layout::Display {
            exposure: post.exposure.exp2(),
            count_top: self.count_top,
            tone_map: post.tone_map as u32,
            view_mode: self.view.mode as u32,
            transparent: u32::from(self.view.background == Background::Transparent),
            lets_light_through: u32::from(self.lets_light_through()),
            samples: self.view.aa.max(1),
            vignette: post.vignette,
        }
    }
}

/// How far the lattices of the first sample are.
#[derive(Clone, Debug, Default)]
pub struct Lattices {
    /// Stride of the finest one that is complete.
    pub complete: Option<u32>,
    /// Stride of the one in the making, and its tiles that are done.
    pub making: Option<(u32, Vec<u32>)>,
    /// Whether what is shown is filled between them.
    pub filled: bool,
    /// Whether it ever was.
    pub was_filled: bool,
}

impl Lattices {
    /// Notes tiles of a lattice; `all` of them complete it.
    pub fn add(&mut self, stride: u32, tiles: &[u32], all: u32) {
        let mut done = self.making.take().filter(|(making, _)| *making == stride).map_or(Vec::new(), |(_, done)| done);
        done.extend(tiles);
        if done.len() >= all as usize {
            self.complete = Some(stride);
        }
        (self.making, self.filled) = (Some((stride, done)), false);
    }

    /// Whether a tile has its first sample.
    pub fn has_sample(&self, tile: u32) -> bool {
        self.making.as_ref().is_some_and(|(stride, done)| *stride == 1 && done.contains(&tile))
    }
}

impl GpuBackend {
    /// Gets a picture ready. It reuses the resources of the previous picture where possible.
    pub(super) fn prepared(&mut self, view: &View, sampling: BrdfSampling) -> Result<Picture, BackendError> {
        let Self { pipelines, shown, progress } = self;
        progress.make_room(pipelines.gpu(), view.size);
        let catches = shown.upload(pipelines, view, sampling)?;
        let mirrors = shown.prepare_mirrors(pipelines, view, sampling);
        progress.set_parts(
            pipelines.gpu(),
            shown.parts(view.mode, mirrors),
            shown.prepare_suns(&pipelines.device, view),
        );
        let groups = Groups::new(pipelines.gpu(), &pipelines.uniforms, shown, progress);
        if view.mode == ViewMode::Shaded && !shown.local.shown_lights().is_empty() {
            // Shadow maps are drawn before the picture begins.
            check([&pipelines.passes.shadow].into_iter())?;
        }
        let (passes, mirrored) = shown.passes(pipelines, (view, sampling), (&groups, progress.targets()))?;
        let needed = pipelines.passes.of_picture([&passes, &mirrored[0], &mirrored[1]]);
        compile_now(needed.iter().cloned());
        // As on the CPU and in the legend, whether the environment is shown or not.
        let illum_cut = shown.environment.light.as_ref().map_or(0, |(light, _)| light.tree.max_nodes);
        Ok(Picture {
            view: view.clone(),
            offsets: view.pixel_offsets(),
            count_top: view.mode.count_top(sampling, illum_cut),
            corners: 3 * shown.loaded().scene.triangles_shown(view),
            groups,
            passes,
            mirrored,
            needed,
            lattices: Lattices::default(),
            catches,
            seen: 0,
        })
    }
}
