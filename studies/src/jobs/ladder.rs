//! The ladder of cut sizes for the live picture, on its own thread.

use super::{Wake, guarded, shared_progress::SharedProgress, spawn};
use crate::{
    ladder::{Cuts, Found, Rung, Settings, climb},
    sheet::DisplayPicture,
};
use anyhow::{Context as _, Result};
use lapidary_render::{
    BackendFactory, Baked, LitScene, Look, Post, Preview, Progress, RenderStats, View, ViewMode,
    compare::{Metrics, compare},
};
use std::{
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{Receiver, Sender, channel},
    },
    thread::available_parallelism,
};

/// Target limit of the reference's duration in seconds.
const PATIENCE_SECS: f64 = 30.0;
/// Rays per second of one core, measured in scenes of a hundred thousand triangles.
const RAYS_A_SECOND: f64 = 4e6;
/// Longest side of the pictures in pixels, even with few lights.
const LONGEST_SIDE: f64 = 480.0;

/// Renderings per picture; the median ignores brief load from other work.
const FRAMES: usize = 3;

/// A result of the ladder.
#[derive(Debug)]
pub enum LadderEvent {
    /// A picture; its error is not known yet.
    Picture {
        /// The merged cuts.
        cuts: Cuts,
        /// As a display shows it.
        shown: DisplayPicture,
    },
    /// The reference.
    Truth {
        /// As a display shows it.
        shown: DisplayPicture,
        /// Seconds of tracing.
        seconds: f64,
        /// Description of the traced light.
        what: String,
    },
    /// A picture's figures. They improve as more of the reference is traced, and are final after [`Self::Truth`].
    Step(StepFigures),
    /// The end, with a reason if it failed.
    Ended(Result<(), String>),
}

/// Figures of one picture.
#[derive(Clone, Copy, Debug)]
pub struct StepFigures {
    /// The merged cuts.
    pub cuts: Cuts,
    /// Render time in seconds.
    pub seconds: f64,
    /// Mean nodes of the merged cut per pixel.
    pub mean_merged_nodes: f64,
    /// Differences from the reference.
    pub metrics: Metrics,
}

impl StepFigures {
    fn new(rung: &Rung, metrics: Metrics) -> Self {
        let RenderStats { seconds, mean_merged_nodes, .. } = rung.stats;
        Self { cuts: rung.cuts, seconds, mean_merged_nodes, metrics }
    }
}

/// The window's handle of the thread; dropping it ends the thread.
pub struct LadderJob {
    events: Receiver<LadderEvent>,
    progress: Arc<SharedProgress>,
}

impl LadderJob {
    /// Renders all sizes, and lit cuts, for the look of the live picture at a size of its own.
    pub fn start(factory: BackendFactory, baked: Option<Baked>, look: Look, wake: Wake) -> Self {
        let (sender, events) = channel();
        let progress = Arc::new(SharedProgress::new(wake));
        let shared = progress.clone();
        spawn("ladder", move || {
            let ended = guarded("the ladder", || climbed(&factory, baked, &look, &sender, &shared));
            tell(&sender, &shared, LadderEvent::Ended(ended));
        });
        Self { events, progress }
    }

    /// Results since the last call.
    pub fn events(&self) -> Vec<LadderEvent> {
        self.events.try_iter().collect()
    }

    /// Traced share of the reference.
    pub fn progress(&self) -> f32 {
        self.progress.share()
    }
}

impl Drop for LadderJob {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

fn tell(sender: &Sender<LadderEvent>, progress: &SharedProgress, event: LadderEvent) {
    // The receiver is gone if the window is closed.
    let _ = sender.send(event);
    progress.wake();
}

fn climbed(
    factory: &BackendFactory,
    baked: Option<Baked>,
    look: &Look,
    sender: &Sender<LadderEvent>,
    progress: &SharedProgress,
) -> Result<()> {
    let baked = baked.context("there is no picture to compare; open a scene")?;
    let (post, settings) = (look.post, Settings { frames: FRAMES, ..Settings::of(look) });
    let look = affordable_look(&baked, look);
    let mut scene = LitScene::new(factory()?, baked)?;
    let climbing = Climbing { progress, sender, rungs: Mutex::default() };
    let mut found = |found: Found| {
        if let Found::Picture(rung) = found {
            locked(&climbing.rungs).push(rung.clone());
        }
        tell(sender, progress, event_of(found, &post));
        Ok(())
    };
    climb(&mut scene, &look, &settings, None, &climbing, &mut found)?;
    Ok(())
}

/// Measures the pictures against the partial reference: every fourth pixel along each axis is ready after a sixteenth of the time,
/// and gives nearly the same figures.
struct Climbing<'a> {
    progress: &'a SharedProgress,
    sender: &'a Sender<LadderEvent>,
    rungs: Mutex<Vec<Rung>>,
}

impl Progress for Climbing<'_> {
    fn advanced(&self, done: u64, total: u64) {
        self.progress.advanced(done, total);
    }

    fn preview(&self, preview: &Preview) {
        if preview.step == 1 {
            // The complete reference is compared at the end.
            return;
        }
        let traced = preview.image.every(preview.step);
        for rung in locked(&self.rungs).iter() {
            // Pictures that cannot be compared cause an error at the end.
            if let Ok(metrics) = compare(&rung.image.every(preview.step), &traced) {
                tell(self.sender, self.progress, LadderEvent::Step(StepFigures::new(rung, metrics)));
            }
        }
    }

    fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }

    fn abandoned(&self) -> bool {
        self.progress.abandoned()
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn event_of(found: Found, post: &Post) -> LadderEvent {
    match found {
        Found::Picture(rung) => {
            LadderEvent::Picture { cuts: rung.cuts, shown: DisplayPicture::shown(&rung.image, post) }
        }
        Found::Truth(truth) => LadderEvent::Truth {
            shown: DisplayPicture::shown(&truth.image, post),
            seconds: truth.seconds,
            what: truth.what.clone(),
        },
        Found::Step(step) => LadderEvent::Step(StepFigures::new(&step.rung, step.metrics)),
    }
}

/// The live picture's look at a size whose reference traces within [`PATIENCE_SECS`].
fn affordable_look(baked: &Baked, look: &Look) -> Look {
    let sources = baked.dataset.indirect.as_ref().filter(|_| look.components.indirect);
    let lights = baked.dataset.tree.len() + sources.map_or(0, |indirect| indirect.sources.len());
    let cores = available_parallelism().map_or(1, usize::from);
    let size = affordable(look.view.size, lights, cores);
    let view = look.view.clone();
    let view = View { size, aa: 1, mode: ViewMode::Shaded, wireframe: false, region: None, ..view };
    Look { view, ..look.clone() }
}

/// `size`, reduced if a ray from each pixel to each light would take too long.
fn affordable(size: [u32; 2], lights: usize, cores: usize) -> [u32; 2] {
    let [width, height] = size.map(f64::from);
    let pixels = PATIENCE_SECS * RAYS_A_SECOND * cores as f64 / lights.max(1) as f64;
    let scale = (pixels / (width * height)).sqrt().min(LONGEST_SIDE / width.max(height)).min(1.0);
    [width, height].map(|side| (scale * side).round().max(1.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        jobs::testing::{silent, wait_for},
        ladder::SIZES,
    };
    use lapidary_core::test_scenes;
    use lapidary_render::{Appearance, CpuBackend, test_looks::plain_look};

    fn start(baked: Option<Baked>, look: Look) -> LadderJob {
        LadderJob::start(Arc::new(|| Ok(Box::new(CpuBackend::new()))), baked, look, silent())
    }

    fn ended(job: &LadderJob) -> Vec<LadderEvent> {
        let mut events = Vec::new();
        wait_for("the ladder", || {
            events.extend(job.events());
            matches!(events.last(), Some(LadderEvent::Ended(_))).then_some(())
        });
        events
    }

    #[test]
    fn every_size_has_a_picture_and_figures_and_the_reference_comes_between() {
        let baked: Baked = test_scenes::dataset(&["a"], &[]).into();
        let look = Look { appearance: Appearance::of(&baked.dataset.scene), ..plain_look(1) };
        let events = ended(&start(Some(baked), look.clone()));
        let picture = |e: &LadderEvent| if let LadderEvent::Picture { cuts, .. } = e { Some(*cuts) } else { None };
        let pictures: Vec<Cuts> = events.iter().filter_map(picture).collect();
        let all: Vec<Cuts> = SIZES.map(Cuts::Refine).into_iter().chain([Cuts::Lit(look.tau)]).collect();
        assert_eq!(pictures, all, "lit pictures are compared with refined ones");
        assert!(events[..all.len()].iter().all(|e| matches!(e, LadderEvent::Picture { .. })), "before all else");
        let truth = events.iter().position(|e| matches!(e, LadderEvent::Truth { .. })).unwrap();
        assert!(
            matches!(&events[truth], LadderEvent::Truth { what, .. } if what.contains("samples of the environment"))
        );
        let figures = |events: &[LadderEvent]| {
            let of = |e: &LadderEvent| if let LadderEvent::Step(step) = e { Some(*step) } else { None };
            events.iter().filter_map(of).collect::<Vec<_>>()
        };
        let (early, last) = (figures(&events[..truth]), figures(&events[truth..]));
        assert_eq!(last.iter().map(|step| step.cuts).collect::<Vec<_>>(), all);
        // Once for each grid: a sixteenth and a quarter of the 64 x 48 pixels.
        let pixels: Vec<usize> = early.iter().step_by(all.len()).map(|step| step.metrics.pixels).collect();
        assert_eq!((pixels, last[0].metrics.pixels), (vec![16 * 12, 32 * 24], 64 * 48));
        let error = |step: &StepFigures| step.metrics.rmse;
        assert!(error(&early[all.len()]) < 4.0 * error(&last[0]) && error(&last[0]) < 4.0 * error(&early[all.len()]));
        assert!(matches!(events.last(), Some(LadderEvent::Ended(Ok(())))));
    }

    #[test]
    fn without_a_scene_the_reason_is_told() {
        let events = ended(&start(None, plain_look(1)));
        let [LadderEvent::Ended(Err(reason))] = &events[..] else { panic!("{events:?}") };
        assert!(reason.contains("open a scene"), "{reason}");
    }

    #[test]
    fn the_size_is_what_half_a_minute_allows() {
        assert_eq!(affordable([1000, 700], 32_768, 2), [102, 72], "240 million rays");
        assert_eq!(affordable([100, 70], 256, 2), [100, 70], "never enlarged");
        assert_eq!(affordable([1000, 500], 16, 16), [480, 240], "no larger than a tile needs");
        assert_eq!(affordable([2, 1], usize::MAX, 1), [1, 1]);
    }
}
