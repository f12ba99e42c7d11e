//! The thread's work: for each request the picture with cuts, then the reference.

use super::{ComparisonEvent, ComparisonRequest, Control, OtherLook, ReferenceKind, ReferencePicture, TestPicture};
use crate::{
    jobs::{Wake, guarded},
    ladder::every_sample,
};
use anyhow::{Result, bail};
use lapidary_core::{image::Image, scene::pose::Poses};
use lapidary_interchange::image;
use lapidary_render::{
    BackendError, BackendFactory, Baked, LitScene, Look, PathPicture, PathSettings, PictureStats, Preview, Progress,
    Renderer, View, ViewMode, predicted_error,
};
use std::{
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, Sender},
    },
    time::{Duration, Instant},
};

/// Longest side of a reference file; the picture is rendered at the same size.
const LONGEST_SIDE: u32 = 4096;

/// Time between two previews of light paths; each costs a pass over the picture and its metrics.
const PREVIEW_INTERVAL: Duration = Duration::from_millis(700);

/// Sends events to the window.
pub struct Outbox {
    /// Events with the number of their comparison.
    pub events: Sender<(u64, ComparisonEvent)>,
    /// Notifies the window.
    pub wake: Wake,
}

/// State of the thread.
pub struct Worker {
    control: Arc<Control>,
    outbox: Outbox,
    factory: BackendFactory,
    /// The picture with cuts, on its own renderer.
    scene: Option<LitScene>,
    /// Retraces the previous scene.
    renderer: Option<Casting>,
}

impl Worker {
    /// Starts idle.
    pub fn new(factory: BackendFactory, control: Arc<Control>, outbox: Outbox) -> Self {
        Self { control, outbox, factory, scene: None, renderer: None }
    }

    /// Works until the window closes.
    pub fn run(mut self, inbox: &Receiver<(u64, Box<ComparisonRequest>)>) {
        while let Ok(first) = inbox.recv() {
            let (number, request) = inbox.try_iter().last().unwrap_or(first);
            if let Err(text) = guarded("the comparison", || self.compare(number, &request)) {
                self.renderer = None;
                self.scene = None;
                self.tell(number, ComparisonEvent::Failed(text));
            }
        }
    }

    fn tell(&self, number: u64, event: ComparisonEvent) {
        // The receiver is gone if the window is closed.
        let _ = self.outbox.events.send((number, event));
        (self.outbox.wake)();
    }

    fn is_wanted(&self, number: u64) -> bool {
        self.control.wanted() == number
    }

    fn compare(&mut self, number: u64, request: &ComparisonRequest) -> Result<()> {
        let Some(baked) = request.baked.clone() else { bail!("there is no picture to compare; open a scene") };
        let loaded = match &request.kind {
            ReferenceKind::File(path) => Some(read(path)?),
            _ => None,
        };
        let view = comparison_view(request, loaded.as_ref());
        if !self.is_wanted(number) {
            return Ok(());
        }
        let Some(mut test) = self.test_picture(number, request, &baked, &view)? else { return Ok(()) };
        // It is no error if another look is another picture.
        if !matches!(request.kind, ReferenceKind::Look(_)) {
            test.predicted = self.predicted(number, request, &baked, &view)?;
        }
        if !self.is_wanted(number) {
            return Ok(());
        }
        self.tell(number, ComparisonEvent::Test(Arc::new(test)));
        let other = match &request.kind {
            ReferenceKind::Look(other) => self.other(number, request, other, &baked, &view)?,
            _ if request.kind.is_traced() => return self.trace(number, request, &baked, &view),
            _ => loaded,
        };
        let Some(image) = other else { return Ok(()) };
        let reference = ReferencePicture { image: image.into(), step: 1, noise: None, finished: true, seconds: 0.0 };
        self.tell(number, ComparisonEvent::Reference(reference));
        Ok(())
    }

    /// The renderer with this scene.
    fn scene_of(&mut self, baked: &Baked) -> Result<&mut LitScene, BackendError> {
        let scene = match self.scene.take() {
            Some(mut scene) => {
                scene.set_scene(baked)?;
                scene
            }
            None => LitScene::new((self.factory)()?, baked.clone())?,
        };
        Ok(self.scene.insert(scene))
    }

    /// The picture rendered like the live one, on the same kind of renderer; `None` if superseded.
    fn test_picture(
        &mut self,
        number: u64,
        request: &ComparisonRequest,
        baked: &Baked,
        view: &View,
    ) -> Result<Option<TestPicture>> {
        let look = Look { view: view.clone(), ..request.look.clone() };
        let control = self.control.clone();
        let scene = self.scene_of(baked)?;
        // Compute the light first: the picture's time excludes it, and a picture rendered before reports its time again.
        scene.light(&look)?;
        scene.forget_picture();
        let remarks = scene.remarks();
        let mut waited = Duration::ZERO;
        let picture = scene.show(&look, &mut || {
            let wanted = control.wanted() == number;
            if wanted {
                waited += control.wait(number);
            }
            wanted
        })?;
        for remark in remarks {
            let _ = self.outbox.events.send((number, ComparisonEvent::Remark(remark)));
        }
        Ok(picture.map(|picture| TestPicture {
            image: picture.image,
            coverage: picture.coverage,
            predicted: None,
            millis: 1e3 * (picture.stats.seconds - waited.as_secs_f64()).max(0.0),
            stats: PictureStats::from(&picture.stats),
        }))
    }

    /// The view in another look; `None` if superseded.
    fn other(
        &mut self,
        number: u64,
        request: &ComparisonRequest,
        other: &OtherLook,
        baked: &Baked,
        view: &View,
    ) -> Result<Option<Image>> {
        let look = Look { poses: request.look.poses.clone(), view: view.clone(), ..(other.make)()? };
        let control = self.control.clone();
        let picture = self.scene_of(baked)?.show(&look, &mut || {
            control.wait(number);
            control.wanted() == number
        })?;
        Ok(picture.map(|picture| picture.image))
    }

    /// The predicted error of the picture, if all its clusters belong to the environment.
    fn predicted(
        &mut self,
        number: u64,
        request: &ComparisonRequest,
        baked: &Baked,
        view: &View,
    ) -> Result<Option<Image>> {
        let look = &request.look;
        let Some(lighting) = self.scene.as_ref().and_then(LitScene::environment).cloned() else { return Ok(None) };
        // Clusters of moved objects differ from the bake's.
        let is_posed = !look.poses.is_empty();
        if is_posed || !look.components.environment || !baked.dataset.settings.mode.environment() {
            return Ok(None);
        }
        let renderer = renderer_of(&mut self.renderer, baked, look);
        let wanted = Wanted { number, control: &self.control };
        let predicted = predicted_error(renderer, view, &lighting, look.sampling, &wanted)?;
        Ok(predicted.map(|predicted| predicted.expected))
    }

    fn trace(&mut self, number: u64, request: &ComparisonRequest, baked: &Baked, view: &View) -> Result<()> {
        let look = &request.look;
        let renderer = renderer_of(&mut self.renderer, baked, look);
        self.control.wait(number);
        let progress = TracingProgress::new(number, &self.control, &self.outbox);
        let (image, noise) = match request.kind {
            ReferenceKind::Paths { spp } => {
                let PathPicture { image, noise, .. } = paths(renderer, look, view, spp, &progress);
                (image, noise)
            }
            _ => {
                let look = Look { view: view.clone(), ..look.clone() };
                (every_sample(baked, &look, renderer, &progress)?, None)
            }
        };
        if !progress.abandoned() {
            let (image, seconds) = (Arc::new(image), progress.seconds());
            progress.tell(ReferencePicture { image, step: 1, noise, finished: true, seconds });
        }
        Ok(())
    }
}

/// Light paths with as many bounces as the shown solution.
fn paths(renderer: &Renderer, look: &Look, view: &View, spp: u32, progress: &dyn Progress) -> PathPicture {
    let bounces = if look.components.indirect { look.solution.bounces() } else { 0 };
    let settings = PathSettings { bounces, components: look.components, ..PathSettings::direct(spp) };
    renderer.path_picture(view, &look.illumination, &look.lights, settings, progress)
}

/// A ray caster and its scene.
struct Casting {
    of: Baked,
    poses: Poses,
    renderer: Renderer,
}

/// The ray caster for a look; rebuilt for a new or differently posed scene.
fn renderer_of<'a>(known: &'a mut Option<Casting>, baked: &Baked, look: &Look) -> &'a mut Renderer {
    let renderer = match known.take() {
        Some(Casting { of, poses, mut renderer }) if of.is_same(baked) && poses == look.poses => {
            renderer.set_appearance(look.appearance.fitted(&baked.dataset.scene.materials).0);
            renderer
        }
        _ => look.renderer(baked),
    };
    &mut known.insert(Casting { of: baked.clone(), poses: look.poses.clone(), renderer }).renderer
}

/// A lit view at the comparison's size. Traced references sample the pixel centers, and so does the picture with cuts then; another
/// program's picture is filtered, like the live picture.
fn comparison_view(request: &ComparisonRequest, loaded: Option<&Image>) -> View {
    let live = &request.look.view;
    View {
        size: loaded.map_or(request.size(), |image| image.size),
        aa: if request.kind.is_traced() { 1 } else { live.aa.max(1) },
        mode: ViewMode::Shaded,
        wireframe: false,
        region: request.region,
        ..live.clone()
    }
}

fn read(path: &Path) -> Result<Image> {
    let image = image::read(path)?;
    let [width, height] = image.size;
    if width.max(height) > LONGEST_SIDE {
        bail!(
            "the reference has {width} x {height} pixels, more than {LONGEST_SIDE} along a side; make it smaller ({})",
            path.display()
        );
    }
    Ok(image)
}

/// Progress that only stops for a newer comparison.
struct Wanted<'a> {
    number: u64,
    control: &'a Control,
}

impl Progress for Wanted<'_> {
    fn advanced(&self, _done: u64, _total: u64) {
        self.control.wait(self.number);
    }

    fn cancelled(&self) -> bool {
        self.control.wanted() != self.number
    }
}

/// Forwards a reference's progress and obeys the window's signals.
struct TracingProgress<'a> {
    number: u64,
    control: &'a Control,
    outbox: &'a Outbox,
    start: Instant,
    paused: Mutex<Duration>,
    previewed: Mutex<Instant>,
}

impl<'a> TracingProgress<'a> {
    fn new(number: u64, control: &'a Control, outbox: &'a Outbox) -> Self {
        let start = Instant::now();
        Self { number, control, outbox, start, paused: Mutex::default(), previewed: start.into() }
    }

    /// Seconds of tracing alone.
    fn seconds(&self) -> f64 {
        self.start.elapsed().saturating_sub(*locked(&self.paused)).as_secs_f64()
    }

    fn tell(&self, reference: ReferencePicture) {
        let _ = self.outbox.events.send((self.number, ComparisonEvent::Reference(reference)));
        (self.outbox.wake)();
    }
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress for TracingProgress<'_> {
    fn advanced(&self, done: u64, total: u64) {
        if self.abandoned() {
            return;
        }
        self.control.advanced(done, total);
        (self.outbox.wake)();
        *locked(&self.paused) += self.control.wait(self.number);
    }

    fn preview(&self, preview: &Preview) {
        let image = Arc::new(preview.image.clone());
        let (step, noise, seconds) = (preview.step, preview.noise, self.seconds());
        self.tell(ReferencePicture { image, step, noise, finished: false, seconds });
        *locked(&self.previewed) = Instant::now();
    }

    fn wants_preview(&self, passes: u32) -> bool {
        passes == 1 || locked(&self.previewed).elapsed() > PREVIEW_INTERVAL
    }

    fn abandoned(&self) -> bool {
        self.control.wanted() != self.number
    }
}
