//! Renders finished pictures of one scene for files, look by look.

use crate::{
    missing_light,
    sheet::DisplayPicture,
    terminal::{Interrupted, remedy_option},
};
use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    Backend, BackendError, Background, Baked, CPU, CpuBackend, LitScene, Look, RenderStats, SurfaceLayers,
};

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
        let taken = self.take_once(look, cancelled).or_else(|error| {
            let adapter = self.scene.backend().name();
            let (scene, remark) = on_cpu(&adapter, error, self.scene.baked().clone())?;
            self.scene = scene;
            self.told.extend(remark);
            self.take_once(look, cancelled)
        });
        let taken = taken?;
        self.tell();
        taken.ok_or_else(|| Interrupted.into())
    }

    /// On the renderer that there is; `None` soon after `cancelled` returns true.
    fn take_once(&mut self, look: &Look, cancelled: &dyn Fn() -> bool) -> Result<Option<Taken>, BackendError> {
        let Some(picture) = self.scene.show(look, &mut || !cancelled())? else { return Ok(None) };
        let mut shown = DisplayPicture { size: look.view.size, pixels: self.scene.display(&look.post)? };
        let is_seen_through = look.view.background == Background::Transparent;
        if let Some(plate) = look.backplate.as_ref().filter(|_| is_seen_through) {
            plate.behind(&mut shown.pixels, shown.size);
        }
        Ok(Some(Taken { image: picture.image, coverage: picture.coverage, shown, stats: picture.stats }))
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

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::dataset;
    use lapidary_render::{
        Appearance, BrdfSampling, DeviceCuts, EnvironmentLight, Illumination, LocalLighting, PictureStats, Post, View,
        test_looks::plain_look,
    };
    use std::{ops::Range, sync::Arc};

    /// An adapter that has room for scenes, and is lost when it renders; or that has no room.
    struct Failing {
        has_room: bool,
    }

    impl Backend for Failing {
        fn name(&self) -> String {
            "a card".into()
        }

        fn set_scene(&mut self, _: &Baked) -> Result<(), BackendError> {
            if self.has_room { Ok(()) } else { Err(BackendError::Driver("out of memory".into())) }
        }

        fn pose(&mut self, _: &Baked, _: Option<&DeviceCuts>) -> Result<(), BackendError> {
            Ok(())
        }

        fn set_appearance(&mut self, _: &Appearance) -> Result<Vec<String>, BackendError> {
            Ok(Vec::new())
        }

        fn set_light(&mut self, _: &Illumination, _: &Arc<EnvironmentLight>) -> Result<Vec<String>, BackendError> {
            Ok(Vec::new())
        }

        fn set_local_lighting(&mut self, _: &LocalLighting) -> Result<Vec<String>, BackendError> {
            Ok(Vec::new())
        }

        fn begin(&mut self, _: &View, _: BrdfSampling) -> Result<(), BackendError> {
            Ok(())
        }

        fn render_rows(&mut self, _: u32, _: Range<u32>) -> Result<(), BackendError> {
            Err(BackendError::DeviceLost { reason: "unplugged".into() })
        }

        fn sketch(&mut self, _: u32, _: &[u32]) -> Result<(), BackendError> {
            unreachable!("commands make no sketches")
        }

        fn fill(&mut self, _: u32) -> Result<u32, BackendError> {
            unreachable!("commands make no sketches")
        }

        fn display(&mut self, _: &Post, _: u32) -> Result<Vec<[u8; 4]>, BackendError> {
            unreachable!("it has no picture")
        }

        fn read(&mut self, _: u32) -> Result<(Image, Vec<f32>), BackendError> {
            unreachable!("it has no picture")
        }

        fn stats(&mut self) -> Result<PictureStats, BackendError> {
            unreachable!("it has no picture")
        }
    }

    #[test]
    fn where_an_adapter_fails_the_cpu_makes_the_same_picture_and_says_so() {
        let baked: Baked = Arc::new(dataset(&["a"], &[])).into();
        let mut look = plain_look(1);
        look.appearance = Appearance::of(&baked.dataset.scene);
        let take = |backend: Box<dyn Backend>| {
            let mut studio = Studio::new(backend, baked.clone()).unwrap();
            (studio.take(&look, &|| false).unwrap(), studio.remarks())
        };
        let (expected, remarks) = take(Box::new(CpuBackend::new()));
        assert!(remarks.is_empty(), "negative control: {remarks:?}");
        for (has_room, why) in [(true, "unplugged"), (false, "out of memory")] {
            let (taken, remarks) = take(Box::new(Failing { has_room }));
            assert!(taken.image == expected.image && taken.stats.backend == CPU);
            assert!(matches!(&remarks[..], [one] if one.contains("\"a card\"") && one.contains(why)), "{remarks:?}");
        }
        let mut studio = Studio::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
        assert!(studio.take(&look, &|| true).unwrap_err().is::<Interrupted>());
    }
}
