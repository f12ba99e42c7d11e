//! The reference of the pictures: the same lights without cuts.

use crate::report::text::grouped;
use anyhow::{Result, bail};
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_render::{BackendError, Baked, Components, CpuBackend, LitScene, Look, Progress, Renderer, SampledLight};
use std::time::Instant;

/// A reference picture.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The picture, scene-linear.
    pub image: Image,
    /// Description of the traced light, as the end of a sentence: "every one of ...".
    pub what: String,
    /// Wall-clock seconds.
    pub seconds: f64,
}

impl Truth {
    /// Traces every sample of all lights of a look. Incomplete if `progress` was cancelled.
    ///
    /// # Errors
    /// None on this machine's cores; a renderer's if one is used.
    pub fn trace(baked: &Baked, look: &Look, progress: &dyn Progress) -> Result<Self> {
        let start = Instant::now();
        let image = every_sample(baked, look, &look.renderer(baked), progress)?;
        Ok(Self { image, what: what(&baked.dataset, look), seconds: start.elapsed().as_secs_f64() })
    }
}

/// Why a picture by all samples is impossible.
pub const BOUNCES_AS_BAKED: &str = "the sources of bounced light are where they were baked; compare posed objects with light paths, or without bounced light";

/// All light samples of the environment, shadow rays to local lights, and a ray from every pixel to every surface source. Bounces
/// of the meshless basis, which has no such samples, are as in any picture. `renderer` must have the look's scene.
///
/// # Errors
/// As [`Truth::trace`].
pub fn every_sample(baked: &Baked, look: &Look, renderer: &Renderer, progress: &dyn Progress) -> Result<Image> {
    let components = look.components;
    if components.indirect && !look.poses.is_empty() {
        bail!(BOUNCES_AS_BAKED);
    }
    let mut bounced = components.indirect.then(|| Bounced::new(baked, look)).transpose()?;
    let base = bounced.as_mut().map(Bounced::of_basis).transpose()?.flatten();
    let light = SampledLight {
        environment: components.environment.then_some(&look.illumination),
        lights: if components.direct { &look.lights } else { &[] },
        emission: components.direct,
        sources: bounced.as_ref().and_then(|bounced| bounced.scene.local()?.sources().map(|lighting| &**lighting)),
        base: base.as_ref(),
    };
    Ok(renderer.sampled(&look.view, light, progress))
}

/// Bounced light of a look alone. All samples of the environment light the sources, without an illumination cut.
struct Bounced {
    scene: LitScene<CpuBackend>,
    look: Look,
}

impl Bounced {
    fn new(baked: &Baked, look: &Look) -> Result<Self, BackendError> {
        let look = Look {
            components: Components { indirect: true, ..Components::NONE },
            illum_cut: baked.dataset.tree.len() as u32,
            sampling: Default::default(),
            ..look.clone()
        };
        let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone())?;
        scene.light(&look)?;
        Ok(Self { scene, look })
    }

    /// Its picture if the basis holds the light; `None` if sources send it.
    fn of_basis(&mut self) -> Result<Option<Image>, BackendError> {
        if self.scene.local().is_some_and(|local| local.sources().is_some()) {
            return Ok(None);
        }
        Ok(Some(self.scene.show_whole(&self.look)?.image))
    }
}

/// Description of what [`every_sample`] traces for a look.
fn what(dataset: &Dataset, look: &Look) -> String {
    let Components { environment, direct, indirect } = look.components;
    let mut parts = Vec::new();
    if environment {
        let samples = grouped(dataset.tree.len() as u64);
        parts.push(format!("every one of {samples} samples of the environment with a shadow ray at every pixel"));
    }
    if direct && !look.lights.is_empty() {
        parts.push(format!("shadow rays to {} local lights", look.lights.len()));
    }
    match dataset.indirect.as_ref().filter(|_| look.solution.needs().sources()) {
        _ if !indirect => {}
        Some(baked) => {
            let sources = grouped(baked.sources.len() as u64);
            parts.push(format!("a ray from every pixel to every one of {sources} surface sources"));
        }
        _ => parts.push("bounced light of the meshless basis as in all pictures".into()),
    }
    parts.join("; ")
}
