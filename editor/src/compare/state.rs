//! The comparison with a reference: its threads, their results, and their last requests.

use super::panel::{self, ComparisonContext, ComparisonPanel, Subject};
use crate::{actions::Action, document::looks::LookState, viewport::compare::Compared, widgets::texture_of};
use egui::{Color32, Context, TextureHandle, TextureOptions, Ui};
use lapidary_core::image::Region;
use lapidary_render::{BackendFactory, Baked, Post};
use lapidary_studies::{
    jobs::{
        Wake,
        comparison::{ComparisonThread, ReferencePicture, TestPicture},
        measure::{MeasureEvent, MeasureRequest, MeasureThread, Measured, ShownMap},
    },
    ladder::Cuts,
};
use std::sync::Arc;

/// Both threads; they exist while something is compared.
pub struct Jobs {
    pub tracing: ComparisonThread,
    pub measuring: MeasureThread,
}

/// Inputs of the measurements, small enough to compare every frame.
#[derive(PartialEq)]
pub struct Asked {
    pub pictures: u64,
    pub surfaces_only: bool,
    pub region: Option<Region>,
    pub map: ShownMap,
    pub top: Option<f32>,
    pub post: Post,
}

/// A look, and the bake in which it is shown.
pub struct Followed {
    pub state: LookState,
    pub baked: Baked,
}

/// State of the comparison: pictures, measures, textures.
pub struct Comparison {
    /// The strip under the viewport.
    pub panel: ComparisonPanel,
    pub factory: BackendFactory,
    pub wake: Wake,
    pub jobs: Option<Jobs>,
    pub test: Option<Arc<TestPicture>>,
    pub reference: Option<ReferencePicture>,
    /// Counts pictures that arrived, since addresses are reused.
    pub pictures: u64,
    pub measured: Option<Box<Measured>>,
    /// Why tracing and measuring failed.
    pub trace_problem: Option<String>,
    pub measure_problem: Option<String>,
    /// Counts looks that were compared with, to tell them apart.
    pub looks_asked: u64,
    /// The look that is compared with.
    pub followed: Option<Followed>,
    /// Counts comparisons, to drop measures of earlier ones.
    pub generation: u64,
    pub asked: Option<Asked>,
    pub shown: Option<(TextureHandle, [u32; 2])>,
    pub map: Option<TextureHandle>,
}

impl Comparison {
    /// With nothing to compare yet.
    pub fn new(factory: BackendFactory, wake: Wake) -> Self {
        Self {
            panel: ComparisonPanel::default(),
            factory,
            wake,
            jobs: None,
            test: None,
            reference: None,
            pictures: 0,
            measured: None,
            trace_problem: None,
            measure_problem: None,
            looks_asked: 0,
            followed: None,
            generation: 0,
            asked: None,
            shown: None,
            map: None,
        }
    }

    /// Contents of the strip, without its subject.
    pub fn context(&self) -> ComparisonContext<'_> {
        let tracing = self.jobs.as_ref().map(|jobs| &jobs.tracing);
        ComparisonContext {
            measured: self.measured.as_deref(),
            progress: tracing.map_or(0.0, ComparisonThread::progress),
            paused: tracing.is_some_and(ComparisonThread::is_paused),
            held: tracing.is_some_and(ComparisonThread::is_held),
            tracing: self.test.is_some() && self.trace_problem.is_none(),
            problem: self.trace_problem.as_deref().or(self.measure_problem.as_deref()),
            subject: Subject::default(),
        }
    }

    /// Shows the strip.
    pub fn show(&mut self, ui: &mut Ui, subject: Subject, actions: &mut Vec<Action>) {
        // Taken out, since its context borrows the rest.
        let mut panel = std::mem::take(&mut self.panel);
        panel::show(ui, &mut panel, &ComparisonContext { subject, ..self.context() }, actions);
        self.panel = panel;
    }

    /// Contents of the viewport.
    pub fn compared(&self, cuts: Cuts, accent: Color32) -> Compared<'_> {
        let panel = &self.panel;
        let progress = self.jobs.as_ref().map_or(0.0, |jobs| jobs.tracing.progress());
        let reference = self.reference.as_ref();
        let waiting = || panel.waiting_label().to_owned();
        let noise = self.measured.as_ref().and_then(|measured| measured.noise);
        let labels = [
            panel.picture_label(cuts),
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

    /// Number of comparisons.
    #[cfg(test)]
    pub fn begun(&self) -> u64 {
        self.generation
    }

    /// Pauses tracing, or continues.
    pub fn pause(&self, paused: bool) {
        self.jobs.iter().for_each(|jobs| jobs.tracing.pause(paused));
    }

    /// Leaves the cores to other work, or continues.
    pub fn hold(&self, held: bool) {
        self.jobs.iter().for_each(|jobs| jobs.tracing.hold(held));
    }

    /// Nothing is compared any more.
    pub fn end(&mut self) {
        (self.jobs, self.followed) = (None, None);
        self.forget();
    }

    /// The results belong to another picture.
    pub fn forget(&mut self) {
        (self.test, self.reference, self.measured, self.asked) = (None, None, None, None);
        (self.trace_problem, self.measure_problem) = (None, None);
        (self.shown, self.map) = (None, None);
        self.generation += 1;
    }

    pub fn jobs(&mut self) -> &mut Jobs {
        self.jobs.get_or_insert_with(|| Jobs {
            tracing: ComparisonThread::start(self.factory.clone(), self.wake.clone()),
            measuring: MeasureThread::start(self.wake.clone()),
        })
    }

    /// Requests measures of the present pictures, unless they are known or requested.
    pub fn measure(&mut self, post: Post, [width, height]: [u32; 2]) {
        let (Some(test), Some(reference)) = (self.test.clone(), self.reference.clone()) else { return };
        let panel = &self.panel;
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

    pub fn take_measured(&mut self, ctx: &Context, event: MeasureEvent) {
        match event {
            MeasureEvent::Shown(pixels) => {
                let texture = self.shown.take().map(|(texture, _)| texture);
                self.shown =
                    Some((texture_of(ctx, "comparison", texture, &pixels, TextureOptions::LINEAR), pixels.size));
            }
            MeasureEvent::Measured(measured) => {
                // Each pixel of the map is an error of its own.
                self.map = Some(texture_of(ctx, "comparison", self.map.take(), &measured.map, TextureOptions::NEAREST));
                (self.measured, self.measure_problem) = (Some(measured), None);
            }
            MeasureEvent::Failed(text) => self.measure_problem = Some(text),
        }
    }
}
