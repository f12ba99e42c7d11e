//! Renders finished pictures of one scene for files, look by look.

use crate::{missing_light, sheet::DisplayPicture, terminal::Interrupted};
use anyhow::{Result, bail};
use lapidary_core::image::Image;
use lapidary_render::{Backend, Baked, LitScene, Look, RenderStats, SurfaceLayers};

/// A lit scene for pictures, with the remarks about them.
pub struct Studio {
    scene: LitScene,
    /// Remarks on adjustments and missing light, each once.
    told: Vec<String>,
    /// Number of remarks already returned.
    handed_out: usize,
}

/// A finished picture.
#[derive(Clone, Debug)]
pub struct Taken {
    /// Scene-linear radiance, or the quantity of the view's mode.
    pub image: Image,
    /// Surface coverage of each pixel, 0 to 1.
    pub coverage: Vec<f32>,
    /// As a display shows it.
    pub shown: DisplayPicture,
    /// Render statistics.
    pub stats: RenderStats,
}

impl Studio {
    /// Gives the scene to the renderer; takes some tenths of a second, or more with surface sources.
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
    /// A lost device, a picture beyond the adapter's limits, or [`Interrupted`] soon after `cancelled` returns true.
    pub fn take(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<Taken> {
        let picture = self.scene.show(look, &mut || !cancelled())?;
        self.tell();
        let Some(picture) = picture else { bail!(Interrupted) };
        let shown = DisplayPicture { size: look.view.size, pixels: self.scene.display(&look.post)? };
        Ok(Taken { image: picture.image, coverage: picture.coverage, shown, stats: picture.stats })
    }

    /// Surface properties in a look, without light.
    pub fn surfaces(&self, look: &Look) -> SurfaceLayers {
        self.scene.surfaces(look)
    }

    /// New remarks since the last call, in sentences; each appears once.
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
