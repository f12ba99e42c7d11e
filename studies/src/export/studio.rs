//! Renders finished pictures of one scene, one look after another; of a look that follows another only what differs is done
//! again. The live view has a renderer of its own (`jobs/render_thread`), which can be interrupted at any band of rows.

use crate::{
    fading,
    sheet::DisplayPicture,
    terminal::Interrupted,
    whole_picture::{BAND_ROWS, stats},
};
use anyhow::{Result, bail};
use lapidary_core::image::Image;
use lapidary_render::{
    Backend, Baked, LightRig, LocalRig, Look, RenderStats, Renderer, SceneLighting, SurfaceLayers, View,
};
use std::{sync::Arc, time::Instant};

/// A scene with what renders it.
pub struct Studio {
    backend: Box<dyn Backend>,
    baked: Baked,
    rig: LightRig,
    local: LocalRig,
    /// What the renderer has, and the environment's light in it.
    last: Option<(Look, Arc<SceneLighting>)>,
    /// Whether its picture is finished.
    finished: bool,
    /// What had to be done to make something fit, each once.
    told: Vec<String>,
    /// How many of them were taken.
    taken: usize,
}

/// A finished picture.
#[derive(Clone, Debug)]
pub struct Taken {
    /// Scene-linear radiance, or what the view's mode shows.
    pub image: Image,
    /// How much of each pixel is covered by surfaces, 0 to 1.
    pub coverage: Vec<f32>,
    /// As a display shows it.
    pub shown: DisplayPicture,
    /// How it was made.
    pub stats: RenderStats,
}

impl Studio {
    /// Gives the scene to the renderer; some tenths of a second, and more with surface sources.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits.
    pub fn new(mut backend: Box<dyn Backend>, baked: Baked) -> Result<Self> {
        backend.set_scene(&baked)?;
        let (rig, local) = (LightRig::new(&baked.dataset.tree), LocalRig::new(&baked));
        Ok(Self { backend, baked, rig, local, last: None, finished: false, told: Vec::new(), taken: 0 })
    }

    /// The scene.
    pub fn baked(&self) -> &Baked {
        &self.baked
    }

    /// Renders a picture.
    ///
    /// # Errors
    /// A lost device, a picture beyond the adapter's limits, or [`Interrupted`] soon after `cancelled` says so.
    pub fn take(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<Taken> {
        let start = Instant::now();
        let known = self.last.as_ref().filter(|_| self.finished);
        if !known.is_some_and(|(known, _)| known.same_picture(look)) {
            self.finished = false;
            self.render(look, cancelled)?;
            self.finished = true;
        }
        let View { aa, size, .. } = look.view;
        let (image, coverage) = self.backend.read(aa)?;
        let stats = stats(&mut *self.backend, start.elapsed().as_secs_f64())?;
        let shown = DisplayPicture { size, pixels: self.backend.display(&look.post, aa)? };
        Ok(Taken { image, coverage, shown, stats })
    }

    fn render(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<()> {
        self.light(look)?;
        self.backend.begin(&look.view, look.sampling)?;
        let View { aa, size, .. } = look.view;
        for sample in 0..aa {
            for first in (0..size[1]).step_by(BAND_ROWS as usize) {
                if cancelled() {
                    bail!(Interrupted);
                }
                self.backend.render_rows(sample, first..size[1].min(first + BAND_ROWS))?;
            }
        }
        Ok(())
    }

    /// What the surfaces of a look are, without light.
    pub fn surfaces(&self, look: &Look) -> SurfaceLayers {
        let mut renderer = Renderer::new(self.baked.clone());
        renderer.set_appearance(look.appearance.fitted(&self.baked.dataset.scene.materials).0);
        renderer.surface_layers(&look.view)
    }

    /// What had to be done to make something fit since the last call, in sentences; none is told twice.
    pub fn remarks(&mut self) -> Vec<String> {
        let new = self.told[self.taken..].to_vec();
        self.taken = self.told.len();
        new
    }

    /// Gives the renderer materials and light, as far as they differ from those it has.
    fn light(&mut self, look: &Look) -> Result<()> {
        let last = self.last.take();
        if !last.as_ref().is_some_and(|(known, _)| known.same_appearance(look)) {
            let remarks = self.backend.set_appearance(&look.appearance)?;
            self.tell(remarks);
            self.local.set_appearance(&look.appearance);
        }
        let lighting = match last {
            Some((known, lighting)) if known.same_environment(look) => lighting,
            _ => {
                let lighting = Arc::new(self.rig.lighting(&look.light, look.illum_cut));
                let remarks = self.backend.set_light(&look.light, &lighting)?;
                self.tell(remarks);
                lighting
            }
        };
        self.local.set_environment(Some(&lighting));
        self.local.set_lights(&look.lights);
        let local = self.local.lighting(look.components, look.solution, look.illum_cut);
        let remarks = self.backend.set_local_lighting(&local)?;
        self.tell(remarks);
        let energy = local.energy.map(|energy| fading::in_picture(energy, look.solution));
        self.tell(energy.and_then(fading::remark).into_iter().collect());
        self.last = Some((look.clone(), lighting));
        Ok(())
    }

    fn tell(&mut self, remarks: Vec<String>) {
        let new = remarks.into_iter().filter(|remark| !self.told.contains(remark)).collect::<Vec<_>>();
        self.told.extend(new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes;
    use lapidary_render::{Appearance, CpuBackend, test_scenes::look as test_look};

    #[test]
    fn pictures_do_not_depend_on_those_before_them() {
        let baked: Baked = test_scenes::dataset(&["a"], &[]).into();
        let studio = || Studio::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
        let base = Look { appearance: Appearance::of(&baked.dataset.scene), ..test_look() };
        let mut looks = vec![base.clone(); 7];
        // Darker: the brightest pixels are clipped.
        looks[1].post.exposure = -3.0;
        looks[2].light.intensity = 3.0;
        looks[3].lights = [].into();
        looks[4].components.environment = false;
        looks[5].appearance.materials[0].parameters.roughness = 0.1;
        looks[6].view.camera.eye.x += 0.3;
        let mut one = studio();
        let pictures: Vec<Taken> = looks.iter().map(|look| one.take(look, &|| false).unwrap()).collect();
        for (look, picture) in looks.iter().zip(&pictures) {
            let alone = studio().take(look, &|| false).unwrap();
            assert!(alone.image == picture.image && alone.shown == picture.shown);
            assert_eq!(alone.stats.pixels_shaded, picture.stats.pixels_shaded);
        }
        assert!(pictures[0].image == pictures[1].image && pictures[0].shown != pictures[1].shown, "only exposed");
        assert!(pictures[2..].iter().all(|picture| picture.image != pictures[0].image), "negative control");
    }

    #[test]
    fn a_cancelled_picture_is_not_taken_for_a_finished_one() {
        let baked: Baked = test_scenes::dataset(&["a"], &[]).into();
        let mut studio = Studio::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
        let look = Look { appearance: Appearance::of(&baked.dataset.scene), ..test_look() };
        let error = studio.take(&look, &|| true).unwrap_err();
        assert!(error.is::<Interrupted>());
        let taken = studio.take(&look, &|| false).unwrap();
        assert!(taken.image.pixels.iter().any(|pixel| pixel.max_element() > 0.0));
    }
}
