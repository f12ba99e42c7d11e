//! Messages to the window: pictures, requested pictures, and failures.

use super::{
    Adapter, COMPILER_SILENCE, HOLES_SHARE, LinearPicture, PictureStage, RenderEvent, RenderRequest, RenderedFrame,
    Worker,
};
use crate::control_names::remedy_control;
use lapidary_render::{BackendError, Remedy};
use std::{sync::atomic::Ordering::SeqCst, time::Instant};

impl Adapter {
    /// The one that renders.
    fn name(&self) -> Option<&String> {
        if let Self::Used(name) = self { name.as_ref() } else { None }
    }
}

impl Worker {
    /// Publishes the present picture.
    pub(super) fn publish(&mut self, request: &RenderRequest) -> Result<(), BackendError> {
        let (Some(begun), Some(scene)) = (&mut self.begun, &mut self.scene) else { return Ok(()) };
        let Some((lighting, local)) = scene.environment().cloned().zip(scene.local().cloned()) else { return Ok(()) };
        let (dataset, light_revision) = (scene.baked().dataset.clone(), self.lights_before + scene.light_revision());
        let (is_sketch, tier, detail) = (begun.complete == 0, scene.tier(), scene.detail());
        if is_sketch {
            let shaded = self.sketch_pace.pixels_within(f64::from(HOLES_SHARE * self.budget_ms));
            begun.holes = scene.fill(shaded)?;
        }
        let backend = scene.backend();
        let frame = RenderedFrame {
            dataset,
            pixels: backend.display(&request.look.post, begun.complete)?,
            size: begun.size,
            tier,
            detail,
            full_size: begun.full_size,
            samples: begun.complete,
            of_samples: request.look.view.aa.max(1),
            stats: if request.moving || is_sketch { self.stats } else { backend.stats()? },
            millis: begun.millis,
            lighting,
            light_revision,
            local,
            backend: backend.name(),
        };
        self.reported = None;
        self.stats = frame.stats;
        self.outbox.frame(frame);
        Ok(())
    }

    /// Sends the complete picture to the requests that wait.
    pub(super) fn answer_reads(&mut self) -> Result<(), BackendError> {
        while let Some(&id) = self.reads.first() {
            let result = match (&self.begun, &mut self.scene) {
                (Some(begun), Some(scene)) => {
                    let (image, coverage) = scene.backend().read(begun.complete)?;
                    Ok(LinearPicture { image, coverage })
                }
                _ => Err("there is no picture; open a scene or a dataset first".into()),
            };
            self.reads.remove(0);
            self.outbox.event(RenderEvent::Picture { id, result });
        }
        Ok(())
    }

    /// Whether the next picture has waited for shaders for so long that the window says so; it is woken when that changes.
    pub(super) fn tell_compiles(&self) {
        let compiles = self.compiles_since.is_some_and(|since| since.elapsed() >= COMPILER_SILENCE);
        if self.shared.compiles.swap(compiles, SeqCst) != compiles {
            self.outbox.wake();
        }
    }

    /// Starts a lost device again, if that did not happen too often; otherwise the CPU goes on.
    pub(super) fn failed(&mut self, error: BackendError) {
        let is_lost = matches!(error, BackendError::DeviceLost { .. });
        let restarts = is_lost && self.restarts.allow(Instant::now());
        let cpu_instead = |adapter: &String| error.cpu_instead(adapter, remedy_control);
        let remark = match self.adapter.name().and_then(cpu_instead) {
            _ if restarts => error.text(remedy_control),
            Some(remark) => {
                self.adapter = match (&error, self.wanted.as_deref()) {
                    (BackendError::Limit { remedy: Remedy::SmallerPicture, .. }, Some(request)) => {
                        Adapter::TooLarge(request.look.view.size)
                    }
                    (BackendError::Limit { .. }, Some(RenderRequest { baked: Some(baked), .. })) => {
                        Adapter::Refused(baked.clone())
                    }
                    _ => Adapter::GivenUp,
                };
                remark
            }
            None => return self.give_up(error.text(remedy_control)),
        };
        self.reset();
        (self.stage, self.begun) = (PictureStage::Begin, None);
        self.outbox.event(RenderEvent::Remark(remark));
    }

    /// Reports a failure, and renders nothing until a request changes something.
    pub(super) fn give_up(&mut self, reason: String) {
        (self.stage, self.begun, self.redisplay) = (PictureStage::Rest, None, false);
        for id in std::mem::take(&mut self.reads) {
            self.outbox.event(RenderEvent::Picture { id, result: Err(reason.clone()) });
        }
        if self.reported.as_ref() != Some(&reason) {
            self.outbox.event(RenderEvent::Failed(reason.clone()));
            self.reported = Some(reason);
        }
    }
}
