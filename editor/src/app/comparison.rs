//! The comparison with a reference: begun anew when the picture is another, measured again when only what is shown is.

use super::{pictures::Pictures, state::EditorState};
use crate::{
    jobs::{
        Wake,
        comparison::{ComparisonEvent, ComparisonThread, ReferencePicture, TestPicture},
        measure::{MeasureEvent, MeasureRequest, MeasureThread, Measured, ShownMap, ShownPixels},
        render_thread::Factory,
    },
    panels::comparison::{ComparisonContext, ComparisonPanel, KindChoice},
    viewport::compare::Compared,
};
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_core::image::Region;
use lapidary_render::Post;
use std::{path::PathBuf, sync::Arc};

/// Both threads; they are there while something is compared.
struct Jobs {
    tracing: ComparisonThread,
    measuring: MeasureThread,
}

/// What measures depend on, small enough to compare every frame.
#[derive(PartialEq)]
struct Asked {
    pictures: u64,
    surfaces_only: bool,
    region: Option<Region>,
    map: ShownMap,
    top: Option<f32>,
    post: Post,
}

/// Pictures, measures and what they are shown by.
pub struct Comparison {
    factory: Factory,
    wake: Wake,
    jobs: Option<Jobs>,
    test: Option<Arc<TestPicture>>,
    reference: Option<ReferencePicture>,
    /// Counts the pictures that came: places in memory are used again.
    pictures: u64,
    measured: Option<Box<Measured>>,
    /// Why nothing is traced, and why what was traced cannot be measured.
    trace_problem: Option<String>,
    measure_problem: Option<String>,
    /// Counts what was compared, to tell measures of what was before.
    generation: u64,
    asked: Option<Asked>,
    shown: Option<(TextureHandle, [u32; 2])>,
    map: Option<TextureHandle>,
}

impl Comparison {
    /// With nothing to compare yet.
    pub fn new(factory: Factory, wake: Wake) -> Self {
        Self {
            factory,
            wake,
            jobs: None,
            test: None,
            reference: None,
            pictures: 0,
            measured: None,
            trace_problem: None,
            measure_problem: None,
            generation: 0,
            asked: None,
            shown: None,
            map: None,
        }
    }

    /// What the strip shows.
    pub fn context(&self) -> ComparisonContext<'_> {
        let tracing = self.jobs.as_ref().map(|jobs| &jobs.tracing);
        ComparisonContext {
            measured: self.measured.as_deref(),
            progress: tracing.map_or(0.0, ComparisonThread::progress),
            paused: tracing.is_some_and(ComparisonThread::is_paused),
            held: tracing.is_some_and(ComparisonThread::is_held),
            tracing: self.test.is_some() && self.trace_problem.is_none(),
            problem: self.trace_problem.as_deref().or(self.measure_problem.as_deref()),
        }
    }

    /// What the viewport shows.
    pub fn compared(&self, panel: &ComparisonPanel, illum_cut: u32, accent: Color32) -> Compared<'_> {
        let progress = self.jobs.as_ref().map_or(0.0, |jobs| jobs.tracing.progress());
        let reference = self.reference.as_ref();
        let waiting = || "B: the reference is on its way".to_owned();
        let noise = self.measured.as_ref().and_then(|measured| measured.noise);
        let labels = [
            panel.picture_label(illum_cut),
            reference.map_or_else(waiting, |reference| panel.reference_label(reference, noise, progress)),
        ];
        let measured = self.measured.as_deref();
        Compared {
            view: panel.shown_view(),
            swipe: panel.swipe,
            reference: self.shown.as_ref().map(|(texture, size)| (texture.id(), *size)),
            map: self.map.as_ref().zip(measured).map(|(texture, measured)| (texture.id(), measured.part)),
            field: measured.map(|measured| &measured.field),
            labels,
            region: panel.drawn_region(),
            accent,
            explained: None,
            marks: Vec::new(),
        }
    }

    /// How often something else was compared.
    #[cfg(test)]
    pub fn begun(&self) -> u64 {
        self.generation
    }

    /// Holds the tracing, or goes on.
    pub fn pause(&self, paused: bool) {
        self.jobs.iter().for_each(|jobs| jobs.tracing.pause(paused));
    }

    /// Gives the cores to other work, or goes on.
    pub fn hold(&self, held: bool) {
        self.jobs.iter().for_each(|jobs| jobs.tracing.hold(held));
    }

    /// Nothing is compared any more.
    fn end(&mut self) {
        self.jobs = None;
        self.forget();
    }

    /// What was made is of another picture.
    fn forget(&mut self) {
        (self.test, self.reference, self.measured, self.asked) = (None, None, None, None);
        (self.trace_problem, self.measure_problem) = (None, None);
        (self.shown, self.map) = (None, None);
        self.generation += 1;
    }

    fn jobs(&mut self) -> &mut Jobs {
        self.jobs.get_or_insert_with(|| Jobs {
            tracing: ComparisonThread::start(self.factory.clone(), self.wake.clone()),
            measuring: MeasureThread::start(self.wake.clone()),
        })
    }

    /// Asks for measures of what there is, unless they are known or on their way.
    fn measure(&mut self, panel: &ComparisonPanel, post: Post, [width, height]: [u32; 2]) {
        let (Some(test), Some(reference)) = (self.test.clone(), self.reference.clone()) else { return };
        let region = panel.region_in(reference.image.size, width as f32 / height.max(1) as f32);
        let asked = Asked {
            pictures: self.pictures,
            surfaces_only: panel.surfaces_only,
            region,
            map: panel.map,
            top: panel.top,
            post,
        };
        if self.asked.as_ref() == Some(&asked) {
            return;
        }
        self.asked = Some(asked);
        let (surfaces_only, map, top) = (panel.surfaces_only, panel.map, panel.top);
        let request = MeasureRequest { test, reference, surfaces_only, region, map, top, post };
        let generation = self.generation;
        self.jobs().measuring.request(generation, request);
    }

    fn take_measured(&mut self, ctx: &Context, event: MeasureEvent) {
        match event {
            MeasureEvent::Shown(pixels) => {
                let texture = self.shown.take().map(|(texture, _)| texture);
                self.shown = Some((texture_of(ctx, texture, &pixels, TextureOptions::LINEAR), pixels.size));
            }
            MeasureEvent::Measured(measured) => {
                // Each pixel of the map is an error of its own.
                self.map = Some(texture_of(ctx, self.map.take(), &measured.map, TextureOptions::NEAREST));
                (self.measured, self.measure_problem) = (Some(measured), None);
            }
            MeasureEvent::Failed(text) => self.measure_problem = Some(text),
        }
    }
}

fn texture_of(ctx: &Context, known: Option<TextureHandle>, shown: &ShownPixels, how: TextureOptions) -> TextureHandle {
    let image = ColorImage::from_rgba_unmultiplied(shown.size.map(|s| s as usize), shown.pixels.as_flattened());
    match known {
        Some(mut texture) => {
            texture.set(image, how);
            texture
        }
        None => ctx.load_texture("comparison", image, how),
    }
}

impl EditorState {
    /// Compares the picture that was asked for last, once nothing moves.
    pub(super) fn compare(&mut self) {
        let panel = &self.interface.comparison;
        if !panel.open || self.scene.shown().is_none() {
            return self.comparison.end();
        }
        let Some(picture) = self.requests.last_sent().cloned() else { return };
        let moving = picture.moving;
        let Some(request) = panel.request(picture) else { return self.comparison.end() };
        if moving && !self.comparison.jobs().tracing.is_current(&request) {
            // Rays for a picture of before would only slow down the next one, and it would be no reference for it.
            self.comparison.jobs().tracing.stop();
            return self.comparison.forget();
        }
        if self.comparison.jobs().tracing.request(request) {
            self.comparison.forget();
        }
        self.comparison.measure(panel, self.document.view.post, self.interface.viewport_size);
    }

    /// Takes what the comparison's threads have made.
    pub(super) fn collect_comparison(&mut self, ctx: &Context) {
        let Some(jobs) = &mut self.comparison.jobs else { return };
        let (traced, measured) = (jobs.tracing.events(), jobs.measuring.events());
        for event in traced {
            self.comparison.pictures += 1;
            match event {
                ComparisonEvent::Test(test) => self.comparison.test = Some(test),
                ComparisonEvent::Reference(reference) => self.comparison.reference = Some(reference),
                ComparisonEvent::Failed(text) => self.comparison.trace_problem = Some(text),
                ComparisonEvent::Remark(text) => self.messages.warning(text),
            }
        }
        let generation = self.comparison.generation;
        let current = measured.into_iter().filter(|(of, _)| *of == generation);
        current.for_each(|(_, event)| self.comparison.take_measured(ctx, event));
    }

    /// Begins or ends the comparison; there must be a picture to begin it.
    pub(super) fn toggle_comparison(&mut self) {
        if !self.interface.comparison.open && !self.can_compare() {
            self.messages.warning("There is no picture to compare; open and bake a scene first");
            return;
        }
        let panel = &mut self.interface.comparison;
        (panel.open, panel.tool) = (!panel.open, None);
    }

    /// Compares with a picture file from now on.
    pub(super) fn choose_reference(&mut self, path: PathBuf) {
        let panel = &mut self.interface.comparison;
        (panel.open, panel.kind, panel.file) = (true, KindChoice::File, Some(path));
        // The same file may have been written again.
        self.comparison.end();
    }

    /// Whether there is a picture to compare.
    pub(super) fn can_compare(&self) -> bool {
        self.scene.shown().is_some() && Pictures::shown(&self.pictures).is_some()
    }
}
