//! The picture that is being made: its targets, and what its passes read.

use super::{GpuBackend, Loaded, groups::Groups};
use crate::{
    error::BackendError,
    gpu::{
        addition::{Addition, PictureInputs},
        light::{GpuLight, GpuMap, GpuSources},
        meshless::GpuMeshless,
        targets::Targets,
    },
    remedy::Remedy,
    sampling::BrdfSampling,
    shade::background::caught_per_radiance,
    stale::Part,
    view::{Background, View},
    view_mode::ViewMode,
};
use glam::{Vec2, Vec3};
use lapidary_core::{environment::Environment, image::Image};
use std::sync::Arc;

/// The picture that is being made.
pub struct Picture {
    pub view: View,
    pub sampling: BrdfSampling,
    pub offsets: Vec<Vec2>,
    pub count_top: f32,
    pub groups: Groups,
    /// Passes beside the merges.
    pub additions: Vec<Addition>,
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

    /// Whether the ground tells the share of the light that it lets through, for an alpha channel.
    pub fn lets_light_through(&self) -> bool {
        self.catches.is_some() && self.view.background == Background::Transparent
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
    /// An error for a picture that the adapter has no room for.
    pub(super) fn check_size(&self, size: [u32; 2]) -> Result<(), BackendError> {
        let limit = u64::from(self.gpu.limits.max_texture_dimension_2d);
        let longest = u64::from(size[0].max(size[1]));
        self.gpu.within("the sides of the picture", "pixels", longest, limit, Remedy::SmallerPicture)?;
        let bytes = u64::from(size[0].next_multiple_of(256)) * u64::from(size[1]) * 16;
        let limit = self.gpu.limits.max_buffer_size;
        self.gpu.within("the pixels of the picture", "bytes", bytes, limit, Remedy::SmallerPicture)
    }

    /// Gets a picture ready. It reuses the resources of the previous picture where possible.
    pub(super) fn prepared(&mut self, view: &View, sampling: BrdfSampling) -> Result<Picture, BackendError> {
        if self.targets.as_ref().is_none_or(|t| t.size != view.size) {
            // Freed first: two sets of a large picture may not fit.
            self.targets = None;
            self.targets = Some(Targets::new(&self.gpu, view.size));
        }
        let (before, baked) = (self.sources.take(), self.loaded().scene.sources.as_ref());
        let shown = self.bounce.sources.as_ref().zip(baked);
        let make = |(lighting, baked)| GpuSources::new(&self.gpu, &self.passes.lit, baked, lighting, before);
        self.sources = shown.map(make).transpose()?;
        let (light, dark) = self.light_or_dark();
        let catches = self.light.as_ref().and_then(|(light, environment)| {
            self.loaded().scene.ground.as_ref()?;
            caught_per_radiance(view, environment, light.intensity, self.local.components.environment)
        });
        // In a part of a picture that hides its background it catches one that does not shine there.
        let environment = self.light.as_ref().filter(|_| catches.is_some()).map_or(dark, |(_, map)| map.clone());
        let blur = match view.background {
            Background::Blurred(width) => Some(width),
            _ => None,
        };
        self.map = Some(GpuMap::new(&self.gpu, &environment, blur, self.map.take()));
        let map = self.map.as_ref().map(|m| m.view.clone()).expect("it was just made");
        let parts = self.parts(view.mode);
        if let Some(targets) = &mut self.targets {
            targets.set_parts(&self.gpu, parts);
        }
        if let Some(history) = &mut self.history {
            history.prepare(&self.gpu, view.size);
        }
        let additions = self.additions(view)?;
        let groups = self.groups(self.loaded(), &light, &map, self.targets());
        // As on the CPU and in the legend, whether the environment is shown or not.
        let illum_cut = self.light.as_ref().map_or(0, |(light, _)| light.tree.max_nodes);
        let count_top = view.mode.count_top(sampling, illum_cut);
        let offsets = view.pixel_offsets();
        Ok(Picture {
            view: view.clone(),
            sampling,
            offsets,
            count_top,
            groups,
            additions,
            lattices: Lattices::default(),
            catches,
            seen: 0,
        })
    }

    /// The parts of the light. Counts of merged nodes have one for each tree.
    fn parts(&self, mode: ViewMode) -> [bool; Part::COUNT] {
        let shaded = mode == ViewMode::Shaded;
        let lights = |part| shaded && self.local_lights.has(part);
        Part::ALL.map(|part| match part {
            Part::Environment => true,
            Part::Bounce => {
                let shows_basis = (shaded || mode.is_of_basis()) && self.bounce.functions.is_some();
                self.sources.is_some() || shows_basis || shaded && self.bounce.is_of_vertices
            }
            Part::Direct | Part::Added => lights(part),
        })
    }

    /// The environment if it is shown.
    pub(super) fn shown_environment(&self) -> Option<&(GpuLight, Arc<Environment>)> {
        self.light.as_ref().filter(|_| self.local.components.environment)
    }

    /// The light, or none where there is none yet.
    fn light_or_dark(&mut self) -> (GpuLight, Arc<Environment>) {
        if let Some(shown) = self.shown_environment() {
            return shown.clone();
        }
        let height = self.loaded().scene.tree_height;
        let make = || {
            let map = Image::filled([1, 1], Vec3::ZERO);
            (GpuLight::dark(&self.gpu, height), Environment::new(String::new(), map).into())
        };
        self.dark.get_or_insert_with(make).clone()
    }

    /// Local lights, and bounced light that no merge gathers, as far as they are shown.
    fn additions(&mut self, view: &View) -> Result<Vec<Addition>, BackendError> {
        let shaded = view.mode == ViewMode::Shaded;
        let (Some(Loaded { scene, materials, .. }), Some(targets)) = (&self.scene, &self.targets) else {
            return Ok(Vec::new());
        };
        let layouts = &self.passes.layouts;
        let picture = PictureInputs { gpu: &self.gpu, layouts, scene, materials, frame: &self.frame, targets };
        let mut additions = Vec::new();
        if shaded {
            additions = self.local_lights.prepare(&picture, &self.passes.direct);
        }
        if let Some(light) = self.bounce.functions.as_ref().filter(|_| shaded || view.mode.is_of_basis()) {
            additions.extend(self.meshless.prepare(&picture, &self.passes.meshless, light, view.basis)?);
        }
        if shaded && self.bounce.is_of_vertices {
            additions.extend(GpuMeshless::without_functions(&picture, &self.passes.meshless));
        }
        Ok(additions)
    }
}
