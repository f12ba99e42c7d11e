//! Takes finished pictures of one scene, one look after another, for files.

use crate::{missing_light, sheet::DisplayPicture, terminal::Interrupted};
use anyhow::{Result, bail};
use lapidary_core::image::Image;
use lapidary_render::{Backend, Baked, LitScene, Look, RenderStats, SurfaceLayers};

/// A lit scene that pictures are taken of, and what is to be told of them.
pub struct Studio {
    scene: LitScene,
    /// What had to be done to make something fit, and what the light lacks, each once.
    told: Vec<String>,
    /// How many of them were handed out.
    handed_out: usize,
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
    pub fn new(backend: Box<dyn Backend>, baked: Baked) -> Result<Self> {
        Ok(Self { scene: LitScene::new(backend, baked)?, told: Vec::new(), handed_out: 0 })
    }

    /// The scene.
    pub fn baked(&self) -> &Baked {
        self.scene.baked()
    }

    /// Renders a picture.
    ///
    /// # Errors
    /// A lost device, a picture beyond the adapter's limits, or [`Interrupted`] soon after `cancelled` says so.
    pub fn take(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<Taken> {
        let picture = self.scene.show(look, &mut || !cancelled())?;
        self.tell();
        let Some(picture) = picture else { bail!(Interrupted) };
        let shown = DisplayPicture { size: look.view.size, pixels: self.scene.display(&look.post)? };
        Ok(Taken { image: picture.image, coverage: picture.coverage, shown, stats: picture.stats })
    }

    /// What the surfaces of a look are, without light.
    pub fn surfaces(&self, look: &Look) -> SurfaceLayers {
        self.scene.surfaces(look)
    }

    /// What is to be told since the last call, in sentences; none is told twice.
    pub fn remarks(&mut self) -> Vec<String> {
        let new = self.told[self.handed_out..].to_vec();
        self.handed_out = self.told.len();
        new
    }

    fn tell(&mut self) {
        let energy = self.scene.local().and_then(|local| local.energy);
        let missing = energy.and_then(missing_light::remark);
        for remark in self.scene.remarks().into_iter().chain(missing) {
            if !self.told.contains(&remark) {
                self.told.push(remark);
            }
        }
    }
}
