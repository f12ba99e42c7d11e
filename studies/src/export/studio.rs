//! Renders finished pictures of one scene for files, look by look.

use crate::{
    missing_light,
    sheet::DisplayPicture,
    terminal::{Interrupted, remedy_option},
};
use anyhow::{Result, bail};
use lapidary_core::image::Image;
use lapidary_render::{Backend, BackendError, Baked, CPU, CpuBackend, LitScene, Look, RenderStats, SurfaceLayers};

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
    /// Gives the scene to the renderer; takes some tenths of a second, or more with surface sources. Where an adapter has no room for
    /// it, the CPU has.
    ///
    /// # Errors
    /// A dataset that the CPU refuses.
    pub fn new(backend: Box<dyn Backend>, baked: Baked) -> Result<Self> {
        let adapter = backend.name();
        let (scene, remark) = match LitScene::new(backend, baked.clone()) {
            Ok(scene) => (scene, None),
            Err(error) => on_cpu(&adapter, error, baked)?,
        };
        Ok(Self { scene, told: remark.into_iter().collect(), handed_out: 0 })
    }

    /// The scene.
    pub fn baked(&self) -> &Baked {
        self.scene.baked()
    }

    /// Renders a picture. Where an adapter fails, the CPU goes on.
    ///
    /// # Errors
    /// What the CPU cannot do either, or [`Interrupted`] soon after `cancelled` returns true.
    pub fn take(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<Taken> {
        let mut picture = self.scene.show(look, &mut || !cancelled());
        if let Err(error) = picture {
            let adapter = self.scene.backend().name();
            let (scene, remark) = on_cpu(&adapter, error, self.scene.baked().clone())?;
            self.scene = scene;
            self.told.extend(remark);
            picture = self.scene.show(look, &mut || !cancelled());
        }
        let picture = picture?;
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

/// The scene on the CPU after an error of an adapter, with a remark that says so.
///
/// # Errors
/// An error that the CPU would have, too.
fn on_cpu(adapter: &str, error: BackendError, baked: Baked) -> Result<(LitScene, Option<String>), BackendError> {
    let remark = Some(adapter).filter(|name| *name != CPU).and_then(|name| error.cpu_instead(name, remedy_option));
    if remark.is_none() {
        return Err(error);
    }
    let cpu: Box<dyn Backend> = Box::new(CpuBackend::new());
    Ok((LitScene::new(cpu, baked)?, remark))
}
