//! What the pictures are held against: the same lights without cuts.

use super::Subject;
use crate::{report::text::grouped, whole_picture::whole_picture};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    Backend, BrdfSampling, Components, CpuBackend, LightRig, LocalLighting, LocalRig, Progress, Renderer, SampledLight,
    Solution,
};
use std::{sync::Arc, time::Instant};

/// A reference picture.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The picture, scene-linear.
    pub image: Image,
    /// What was traced, as a sentence's end: "every one of ...".
    pub what: String,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Truth {
    /// Traces every sample of all lights of the subject. Unfinished if `progress` was cancelled.
    ///
    /// # Errors
    /// None on this machine's cores; a renderer's where one is asked.
    pub fn trace(subject: &Subject, progress: &dyn Progress) -> Result<Self> {
        let start = Instant::now();
        let image = every_sample(subject, &subject.renderer(), progress)?;
        Ok(Self { image, what: what(subject), seconds: start.elapsed().as_secs_f64() })
    }
}

/// All light samples of the environment, shadow rays to local lights, and a ray from every pixel to every surface source. The
/// bounces of the meshless basis, which has no such samples, are as in any picture.
///
/// # Errors
/// As [`Truth::trace`].
pub fn every_sample(subject: &Subject, renderer: &Renderer, progress: &dyn Progress) -> Result<Image> {
    let components = subject.components;
    let bounced = components.indirect.then(|| bounced(subject));
    let sources = bounced.as_ref().and_then(|lighting| lighting.indirect.as_deref());
    let base = bounced.as_ref().filter(|_| sources.is_none()).map(|l| interpolated(subject, l)).transpose()?;
    let light = SampledLight {
        environment: components.environment.then_some(&subject.light),
        lights: if components.direct { &subject.lights } else { &[] },
        sources,
        base: base.as_ref(),
    };
    Ok(renderer.sampled(&subject.view, light, progress))
}

/// Bounced light of the subject. All samples of the environment shine on the sources: no illumination cut has a part in it.
fn bounced(subject: &Subject) -> LocalLighting {
    let samples = subject.dataset().tree.len() as u32;
    let environment = LightRig::new(&subject.dataset().tree).lighting(&subject.light, samples);
    let mut rig = LocalRig::new(&subject.baked);
    rig.set_appearance(&subject.appearance.fitted(&subject.dataset().scene.materials).0);
    rig.set_environment(Some(&Arc::new(environment)));
    rig.set_lights(&subject.lights);
    rig.lighting(Components { indirect: true, ..Components::NONE }, subject.solution, samples)
}

/// Bounced light that vertices hold, and nothing else.
fn interpolated(subject: &Subject, lighting: &LocalLighting) -> Result<Image> {
    let mut backend = CpuBackend::new();
    backend.set_scene(&subject.baked)?;
    backend.set_appearance(&subject.appearance)?;
    backend.set_local_lighting(lighting)?;
    Ok(whole_picture(&mut backend, &subject.view, BrdfSampling::default())?.0)
}

/// What [`every_sample`] traces for a subject.
fn what(subject: &Subject) -> String {
    let Components { environment, direct, indirect } = subject.components;
    let mut parts = Vec::new();
    if environment {
        let samples = grouped(subject.dataset().tree.len() as u64);
        parts.push(format!("every one of {samples} samples of the environment with a shadow ray at every pixel"));
    }
    if direct && !subject.lights.is_empty() {
        parts.push(format!("shadow rays to {} local lights", subject.lights.len()));
    }
    match (subject.solution, subject.dataset().indirect.as_ref()) {
        _ if !indirect => {}
        (Solution::Cuts | Solution::CutsMeshless, Some(baked)) => {
            let sources = grouped(baked.sources.len() as u64);
            parts.push(format!("a ray from every pixel to every one of {sources} surface sources"));
        }
        _ => parts.push("bounced light of the meshless basis as in all pictures".into()),
    }
    parts.join("; ")
}
