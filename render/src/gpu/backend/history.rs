//! What is kept of a picture for one from another camera. Twin of `cpu/sketch/history.rs`.

use super::{GpuBackend, picture::Picture, pipelines::Pipelines, progress::Progress};
use crate::{
    backend::Backend,
    device::{GpuDevice, layout::PastUniforms, storage},
    error::BackendError,
    gpu::{
        draw::encode_areas,
        groups::{Added, Past},
        targets::{Sums, Target, format, target},
    },
    stale::LightPart,
};
use lapidary_core::image::Region;

/// The last picture.
pub struct History {
    size: [u32; 2],
    past: PastUniforms,
    /// By [`LightPart`], as far as the light had them: values, and places on surfaces.
    parts: [Option<Sums>; LightPart::COUNT],
    /// What it tells of the pixels of the new picture, by [`LightPart`], and their size.
    predicted: [Option<Target>; LightPart::COUNT],
    predicted_size: [u32; 2],
    is_predicted: bool,
}

impl History {
    /// Makes room for what it tells of a picture of `size`.
    pub fn prepare(&mut self, gpu: &GpuDevice, size: [u32; 2]) {
        let fits = self.predicted_size == size;
        for (predicted, part) in self.predicted.iter_mut().zip(&self.parts) {
            let known = predicted.take().filter(|_| fits);
            *predicted = part.as_ref().map(|_| known.unwrap_or_else(|| target(gpu, "predicted", format::FLOATS, size)));
        }
        (self.predicted_size, self.is_predicted) = (size, false);
    }

    /// What it tells of a part of the light.
    pub fn predicted(&self, part: LightPart) -> Option<&Target> {
        self.predicted[part as usize].as_ref()
    }
}

impl GpuBackend {
    /// Keeps a picture that was sketched for one from another camera. What was never shown tells less than the picture
    /// before it.
    pub(super) fn remember(&mut self) -> Result<(), BackendError> {
        let (is_complete, lattices) = (self.progress.state().summed.complete > 0, &self.progress.picture().lattices);
        let (is_filled, is_shown) = (lattices.filled, is_complete || lattices.was_filled);
        if lattices.making.is_none() || !is_shown {
            return Ok(());
        }
        if !is_complete && !is_filled {
            self.fill(0)?;
        }
        let Self { pipelines, progress, .. } = self;
        progress.make_history(pipelines.gpu());
        pipelines.submit(|encoder| progress.encode_history(pipelines, encoder))
    }
}

impl Progress {
    /// Room for what is kept of the picture. That of the last one is used again.
    fn make_history(&mut self, gpu: &GpuDevice) {
        let before = self.history.take();
        let (targets, size) = (self.targets(), self.targets().size);
        let has = |part: LightPart| part != LightPart::Added && targets.parts[part as usize].is_some();
        let wanted = LightPart::ALL.map(has);
        let predicted_size = before.as_ref().map_or([0, 0], |before| before.predicted_size);
        let (fits, before) =
            (before.as_ref().is_some_and(|before| before.size == size), before.map(|b| (b.parts, b.predicted)));
        let (parts, predicted) = before.unwrap_or_default();
        let mut parts = if fits { parts } else { Default::default() };
        for (part, wanted) in parts.iter_mut().zip(wanted) {
            *part = part.take().filter(|_| wanted).or_else(|| wanted.then(|| Sums::new(gpu, size)));
        }
        let past = past(self.picture());
        self.history = Some(History { size, past, parts, predicted, predicted_size, is_predicted: true });
    }

    fn encode_history(&self, pipelines: &Pipelines, encoder: &mut wgpu::CommandEncoder) {
        let Some(history) = &self.history else { return };
        let (gpu, passes) = (pipelines.gpu(), &pipelines.passes);
        let (groups, targets, shown) = (&self.picture().groups, self.targets(), self.shown());
        let whole = [Region::whole(targets.size)];
        for part in LightPart::ALL {
            let bound = history.parts[part as usize].as_ref().zip(groups.sums[part as usize].as_ref());
            let Some((to, sums)) = bound else { continue };
            // A new picture has all of its local lights in one part.
            let added = targets.parts[LightPart::Added as usize].as_ref().filter(|_| part == LightPart::Direct);
            let added = added.map_or(&targets.nothing, |sums| &sums[shown]);
            let marks = &targets.marks[self.state().marks_front].view;
            let added = Added { added_value: &added.value.view, added_work: &added.work.view, marks }.bind(gpu);
            let bound = [&groups.scene, &added, &sums[shown]];
            encode_areas(encoder, &passes.history, &groups.frame, &bound, &[&to.value, &to.work], &whole);
        }
    }

    /// Whether the pixels of the picture are yet to be found in the last one; they will be.
    pub fn take_unpredicted(&mut self) -> bool {
        self.history.as_mut().is_some_and(|history| !std::mem::replace(&mut history.is_predicted, true))
    }

    /// Finds the pixels of the picture in the last one.
    pub fn encode_predicted(&self, pipelines: &Pipelines, encoder: &mut wgpu::CommandEncoder) {
        let Some(history) = &self.history else { return };
        let (gpu, passes) = (pipelines.gpu(), &pipelines.passes);
        let past = &storage(gpu, "past", bytemuck::bytes_of(&history.past));
        let (groups, front) = (&self.picture().groups, self.state().front);
        let whole = [Region::whole(self.targets().size)];
        for part in LightPart::ALL {
            let kept = history.parts[part as usize].as_ref().zip(history.predicted(part));
            let Some(((from, to), sums)) = kept.zip(groups.sums[part as usize].as_ref()) else { continue };
            let past = Past { past, past_value: &from.value.view, past_place: &from.work.view }.bind(gpu);
            let bound = [&groups.scene, &past, &sums[front]];
            encode_areas(encoder, &passes.predict, &groups.frame, &bound, &[to], &whole);
        }
    }
}

/// The camera of a picture, and where its pixels' samples are.
fn past(picture: &Picture) -> PastUniforms {
    let projection = picture.view.projection_of(picture.seen);
    PastUniforms {
        world_from_view: [0, 1, 2].map(|i| projection.world_from_view.col(i).extend(0.0).to_array()),
        eye: projection.eye.to_array(),
        focal: projection.focal,
        center: (projection.center - picture.offset(picture.seen)).to_array(),
        size: picture.view.size,
    }
}
