//! A scene on a renderer that shows one look after another and redoes only what an edit changes ([`Redo`]).

pub(crate) mod ladder;
mod lighting;
mod pose_rigs;
mod posing;

#[cfg(test)]
use crate::device::Compute;
use crate::{
    Backend, BackendError, Background, Baked, BrdfSampling, CPU, EnvironmentLight, LightRig, LocalLighting, LocalRig,
    Look, Posing, Post, RenderStats, Stale, SurfaceLayers, Tier, View,
    light::{drift::Drift, implicit::detail::ImplicitDetail, situation::Situation},
};
use lapidary_core::{ground::Ground, image::Image};
use pose_rigs::PoseRigs;
use std::{ops::Range, sync::Arc, time::Instant};

/// Rows rendered at once. Drivers stop work that blocks an adapter for seconds, such as a whole large picture with thousands of
/// lights.
const BAND_ROWS: u32 = 64;

/// A scene with its renderer and lights.
pub struct LitScene<B: Backend + ?Sized = dyn Backend> {
    /// The scene as it was baked.
    baked: Baked,
    /// The current lighting.
    situation: Situation,
    /// Whether the renderer has the situation's poses.
    is_posed: bool,
    /// Poses the scene; `None` before the first pose.
    posing: Option<Posing>,
    /// Rigs that light the posed scene.
    pose_rigs: PoseRigs,
    /// How finely posed objects are lit.
    detail: ImplicitDetail,
    /// ImplicitDetail level for drags.
    drag_detail: ImplicitDetail,
    /// Whether the solver of bounced light has more steps.
    is_unsolved: bool,
    environment_rig: LightRig,
    local_rig: LocalRig,
    /// The renderer's current state; `None` after a failure, so that everything is set again.
    lit: Option<LitLook>,
    /// Counts how often the environment was lit, so that others notice new light.
    light_revision: u64,
    /// Whether all samples of the look's picture are rendered.
    finished: bool,
    /// Whether the next look recomputes its light, even if unchanged.
    relight: bool,
    /// Stale parts of the renderer's picture.
    stale: Stale,
    /// Change of the bounced light since it was shaded.
    drift: Drift,
    /// Whether pixels keep bounced light that a changed material changes invisibly.
    keeps_unseen: bool,
    remarks: Remarks,
    backend: Box<B>,
}

/// A look and its light, as the renderer has them.
struct LitLook {
    look: Look,
    local: LocalLighting,
}

/// Remarks, in sentences, on changes made to fit limits.
#[derive(Default)]
struct Remarks {
    /// Remarks on the renderer's state: appearance, environment, and local lights; and on the look. They are not repeated.
    of: [Vec<String>; 4],
    untold: Vec<String>,
}

impl Remarks {
    fn replace(&mut self, part: usize, remarks: Vec<String>) {
        self.untold.extend(remarks.iter().filter(|remark| !self.of[part].contains(remark)).cloned());
        self.of[part] = remarks;
    }
}

/// A finished picture.
#[derive(Clone, Debug)]
pub struct FinishedPicture {
    /// Scene-linear radiance, or the quantity of the view's mode.
    pub image: Image,
    /// Surface coverage of each pixel, 0 to 1.
    pub coverage: Vec<f32>,
    /// Statistics; the seconds are from the light to the last pixel.
    pub stats: RenderStats,
}

impl<B: Backend + ?Sized> LitScene<B> {
    /// Gives a scene to a renderer; takes some tenths of a second, or more with surface sources.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits.
    pub fn new(mut backend: Box<B>, baked: Baked) -> Result<Self, BackendError> {
        let (environment_rig, local_rig) = rigs(&mut *backend, &baked)?;
        Ok(Self {
            situation: Situation { compute: backend.compute(), ..Situation::unlit(&baked) },
            baked,
            is_posed: true,
            posing: None,
            pose_rigs: PoseRigs::default(),
            detail: ImplicitDetail::FINEST,
            drag_detail: ImplicitDetail::OF_A_DRAG,
            is_unsolved: false,
            environment_rig,
            local_rig,
            lit: None,
            light_revision: 0,
            finished: false,
            relight: false,
            stale: Stale::ALL,
            drift: Drift::default(),
            keeps_unseen: false,
            remarks: Remarks::default(),
            backend,
        })
    }

    /// Lets pixels keep bounced light that a changed material changes by less than half an 8-bit step. Pictures then depend on
    /// earlier ones by as little.
    pub fn keep_unseen_changes(mut self) -> Self {
        self.keeps_unseen = true;
        self
    }

    /// Computes beside the picture there, be it on an emulated device.
    #[cfg(test)]
    pub(crate) fn with_compute(mut self, compute: Compute) -> Self {
        self.situation.compute = compute;
        self
    }

    /// Gives the renderer a scene unless it already has it. Returns whether the scene is new.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits; the previous scene is kept then.
    pub fn set_scene(&mut self, baked: &Baked) -> Result<bool, BackendError> {
        if self.baked.is_same(baked) {
            return Ok(false);
        }
        let (environment_rig, local_rig) = rigs(&mut *self.backend, baked)?;
        self.environment_rig = environment_rig;
        let before = std::mem::replace(&mut self.local_rig, local_rig);
        if self.baked.is_of_same_vertices(baked) {
            self.local_rig.take_over(before);
        }
        self.situation = Situation { compute: self.backend.compute(), ..Situation::unlit(baked) };
        self.baked = baked.clone();
        (self.posing, self.pose_rigs, self.lit) = (None, PoseRigs::default(), None);
        (self.is_posed, self.is_unsolved) = (true, false);
        self.forget_pictures();
        Ok(true)
    }

    /// Records that there is no picture of the renderer's scene.
    fn forget_pictures(&mut self) {
        (self.finished, self.stale) = (false, Stale::ALL);
        self.drift = Drift::default();
    }

    /// Renders a look, unless it was rendered last. `go_on` is called before each band of rows, and may wait. Returns `None` if it
    /// returns false.
    ///
    /// # Errors
    /// A picture beyond the adapter's limits, or a lost device.
    pub fn show(
        &mut self,
        look: &Look,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<FinishedPicture>, BackendError> {
        let start = Instant::now();
        self.light(look)?;
        if !self.finished {
            self.resume(&look.view, look.sampling)?;
            if !self.render_samples(&look.view, go_on)? {
                return Ok(None);
            }
            self.finished = true;
        }
        let (image, coverage) = self.backend.read(look.view.aa)?;
        let stats = self.stats(start.elapsed().as_secs_f64())?;
        Ok(Some(FinishedPicture { image, coverage, stats }))
    }

    /// [`Self::show`] without a pause.
    ///
    /// # Errors
    /// As [`Self::show`].
    pub fn show_whole(&mut self, look: &Look) -> Result<FinishedPicture, BackendError> {
        let picture = self.show(look, &mut || true)?;
        Ok(picture.expect("nothing stops it"))
    }

    /// The picture last finished by [`Self::show`], as displayed: sRGB-encoded, row by row from the top.
    ///
    /// # Errors
    /// A lost device.
    pub fn display(&mut self, post: &Post) -> Result<Vec<[u8; 4]>, BackendError> {
        let samples = self.lit.as_ref().map_or(1, |lit| lit.look.view.aa);
        self.backend.display(post, samples)
    }

    /// Gives the renderer the changed materials and lights of a look.
    ///
    /// # Errors
    /// Sources beyond the adapter's limits, or a lost device.
    pub fn light(&mut self, look: &Look) -> Result<(), BackendError> {
        self.light_first(look, true)?;
        while self.is_unsolved {
            self.advance()?;
        }
        Ok(())
    }

    /// Makes the next look recompute its light and picture even if unchanged, for timing. Materials stay.
    pub fn forget_light(&mut self) {
        (self.relight, self.finished, self.stale) = (true, false, Stale::ALL);
    }

    /// Makes the next look recompute its picture even if unchanged, for timing. Materials and light stay.
    pub fn forget_picture(&mut self) {
        (self.finished, self.stale) = (false, Stale::ALL);
    }

    /// Starts a picture of the scene under its current light, without samples; [`Self::render_rows`] renders it step by step.
    ///
    /// # Errors
    /// A picture larger than the adapter's limits, or a lost device.
    pub fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.finished = false;
        self.stale = Stale::ALL;
        self.backend.begin(view, sampling)?;
        self.stale = Stale::NOTHING;
        Ok(())
    }

    /// [`Self::begin`] with the samples of the last picture that no edit made stale. Render all samples of all rows; kept ones take
    /// no time.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn resume(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.finished = false;
        let stale = std::mem::replace(&mut self.stale, Stale::ALL);
        self.backend.resume(view, sampling, &stale)?;
        self.stale = Stale::NOTHING;
        Ok(())
    }

    /// Whether the picture waits for no compiler; see [`Backend::is_ready`].
    ///
    /// # Errors
    /// A program that does not compile.
    pub fn is_ready(&mut self) -> Result<bool, BackendError> {
        self.backend.is_ready()
    }

    /// Adds one sample per pixel to some rows; see [`Backend::render_rows`].
    ///
    /// # Errors
    /// A lost device.
    pub fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        self.backend.render_rows(sample, rows)
    }

    /// Adds the first sample to pixels of some tiles; see [`Backend::sketch`].
    ///
    /// # Errors
    /// A lost device.
    pub fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        self.backend.sketch(stride, tiles)
    }

    /// Fills the pixels without a sample; see [`Backend::fill`].
    ///
    /// # Errors
    /// A lost device.
    pub fn fill(&mut self, most_shaded: u32) -> Result<u32, BackendError> {
        self.backend.fill(most_shaded)
    }

    /// Renders all samples of all rows. Returns whether `go_on` always returned true.
    fn render_samples(&mut self, view: &View, go_on: &mut dyn FnMut() -> bool) -> Result<bool, BackendError> {
        let height = view.size[1];
        for sample in 0..view.aa {
            for first in (0..height).step_by(BAND_ROWS as usize) {
                if !go_on() {
                    return Ok(false);
                }
                self.backend.render_rows(sample, first..height.min(first + BAND_ROWS))?;
            }
        }
        Ok(true)
    }

    fn stats(&mut self, seconds: f64) -> Result<RenderStats, BackendError> {
        let (work, name) = (self.backend.stats()?, self.backend.name());
        let adapter = (name != CPU).then_some(name);
        Ok(RenderStats {
            tier: self.tier(),
            backend: if adapter.is_some() { "gpu" } else { CPU }.into(),
            adapter,
            seconds,
            pixels_shaded: work.pixels_shaded,
            mean_merged_nodes: work.mean_merged_nodes,
            mean_brdf_evaluations: work.mean_brdf_evaluations,
        })
    }

    /// Surface properties in a look, without light.
    pub fn surfaces(&self, look: &Look) -> SurfaceLayers {
        // A shadow without a background is not a surface.
        let is_shadow = look.catches_shadows() && look.view.background == Background::Transparent;
        let ground = if is_shadow { Ground::Off } else { look.view.ground };
        look.renderer(&self.baked).surface_layers(&View { ground, ..look.view.clone() })
    }

    /// The scene.
    pub fn baked(&self) -> &Baked {
        &self.baked
    }

    /// Method by which its light is computed.
    pub fn tier(&self) -> Tier {
        let solves = |look: &Look| look.components.indirect && look.shown_solution().follows_poses();
        match self.lit.as_ref().is_some_and(|lit| solves(&lit.look)) && !self.is_unsolved {
            _ if self.situation.poses.is_empty() => Tier::Cuts,
            true => Tier::Solved,
            false => Tier::Implicit,
        }
    }

    /// The renderer.
    pub fn backend(&mut self) -> &mut B {
        &mut self.backend
    }

    /// The light of the environment, after the first look.
    pub fn environment(&self) -> Option<&Arc<EnvironmentLight>> {
        self.situation.environment.as_ref()
    }

    /// Changes whenever [`Self::environment`] changes.
    pub fn light_revision(&self) -> u64 {
        self.light_revision
    }

    /// Local lights and bounced light, after the first look.
    pub fn local(&self) -> Option<&LocalLighting> {
        self.lit.as_ref().map(|lit| &lit.local)
    }

    /// New remarks since the last call, in sentences, on changes made to fit limits. Each appears once while it holds.
    pub fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks.untold)
    }
}

/// Gives a scene to a renderer, and creates its rigs. The light rig is created in parallel, because each takes equally long.
fn rigs<B: Backend + ?Sized>(backend: &mut B, baked: &Baked) -> Result<(LightRig, LocalRig), BackendError> {
    let tree = &baked.dataset.tree;
    let environment = std::thread::scope(|threads| {
        let rig = threads.spawn(|| LightRig::new(tree));
        backend.set_scene(baked)?;
        Ok(rig.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })?;
    Ok((environment, LocalRig::new(baked)))
}

#[cfg(test)]
pub(crate) mod edits;

#[cfg(test)]
mod tests;
