//! How far a picture is: the textures that its passes write, which samples are in them, and what is kept of the last one.

use super::{history::History, picture::Picture};
use crate::{
    device::GpuDevice,
    gpu::{
        shadows::Plan,
        targets::{Sums, Targets},
    },
    stale::LightPart,
    summed::Summed,
};

/// Targets, sums and picture, as far as they are there.
#[derive(Default)]
pub struct Progress {
    targets: Option<Targets>,
    /// What is in the sums of the targets.
    pub state: Option<SumState>,
    /// `None` after any change, until it is begun or resumed.
    pub picture: Option<Picture>,
    /// The last picture, if nothing but camera and size has changed since.
    pub history: Option<History>,
}

/// Which picture the sums have.
pub struct SumState {
    pub summed: Summed,
    /// Shadow maps of the local lights in them.
    pub plan: Plan,
    /// Which of each part's textures holds the sums.
    pub front: usize,
    /// Samples of which the pixels know what they show.
    pub marked: u32,
    /// Which of the textures holds that.
    pub marks_front: usize,
}

impl SumState {
    /// Without samples.
    pub fn new(summed: Summed, plan: Plan) -> Self {
        Self { summed, plan, front: 0, marked: 0, marks_front: 0 }
    }
}

impl Progress {
    /// Forgets all but the textures.
    pub fn forget(&mut self) {
        (self.picture, self.state, self.history) = (None, None, None);
    }

    pub fn picture(&self) -> &Picture {
        self.picture.as_ref().expect("a picture is begun before it is rendered")
    }

    pub fn state(&self) -> &SumState {
        self.state.as_ref().expect("a picture is begun before it is rendered")
    }

    pub fn targets(&self) -> &Targets {
        self.targets.as_ref().expect("a picture is begun with targets")
    }

    /// Makes room for pictures of a size.
    pub fn make_room(&mut self, gpu: &GpuDevice, size: [u32; 2]) {
        if self.targets.as_ref().is_none_or(|t| t.size != size) {
            // Freed first: two sets of a large picture may not fit.
            self.targets = None;
            self.targets = Some(Targets::new(gpu, size));
        }
    }

    /// Makes room for the parts of a light, and for what the last picture tells of them.
    pub fn set_parts(&mut self, gpu: &GpuDevice, parts: [bool; LightPart::COUNT], suns: bool) {
        let Some(targets) = &mut self.targets else { return };
        targets.set_parts(gpu, parts, suns);
        if let Some(history) = &mut self.history {
            history.prepare(gpu, targets.size);
        }
    }

    /// The other texture of each part has the sums now.
    pub fn flip(&mut self) {
        if let Some(state) = &mut self.state {
            state.front = 1 - state.front;
        }
    }

    /// Which of each part's textures is shown.
    pub fn shown(&self) -> usize {
        let front = self.state().front;
        if self.picture().lattices.filled { 1 - front } else { front }
    }

    /// What is rendered next, of a sample, writes over a sketch.
    pub fn leave_sketch(&mut self, sample: u32) {
        if let Some(picture) = &mut self.picture {
            (picture.lattices.filled, picture.seen) = (false, sample);
        }
    }

    /// All rows have a sample.
    pub fn sample_done(&mut self, sample: u32) {
        self.flip();
        if let Some(state) = &mut self.state {
            state.summed.complete = sample + 1;
        }
    }

    /// The sums of each part that the light has.
    pub fn sums(&self) -> impl Iterator<Item = (LightPart, &Sums)> {
        let front = self.shown();
        let parts = LightPart::ALL.into_iter().zip(&self.targets().parts);
        parts.filter_map(move |(part, sums)| Some((part, &sums.as_ref()?[front])))
    }
}
