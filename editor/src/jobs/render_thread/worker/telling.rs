//! Messages to the window: pictures, requested pictures, and failures.

use super::{HOLES_SHARE, LinearPicture, PictureStage, RenderEvent, RenderRequest, RenderedFrame, Restarts, Worker};
use crate::control_names::remedy_control;
use lapidary_render::{BackendError, Remedy};
use std::time::Instant;

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

    pub(super) fn failed(&mut self, error: BackendError) {
        let BackendError::DeviceLost { reason } = &error else { return self.give_up(error.text(remedy_control)) };
        self.reset();
        self.begun = None;
        if self.restarts.allow(Instant::now()) {
            self.outbox.event(RenderEvent::Remark(error.text(remedy_control)));
            self.stage = PictureStage::Begin;
        } else {
            self.give_up(format!(
                "the graphics device was lost more than {} times within a minute ({reason}); update its driver, or {}",
                Restarts::MOST,
                remedy_control(Remedy::Cpu)
            ));
        }
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
