//! A renderer that renders nothing and only counts calls.

use super::*;

/// Calls to the renderer, and its behavior.
#[derive(Default)]
pub struct Log {
    pub made: u32,
    pub scenes: u32,
    pub appearances: u32,
    pub lights: u32,
    /// Size and samples of each picture.
    pub begun: Vec<([u32; 2], u32)>,
    /// Stride and tile of first samples.
    pub sketched: Vec<(u32, u32)>,
    /// Sample and rows of the others.
    pub rows: Vec<(u32, Range<u32>)>,
    pub displays: u32,
    pub local: Vec<LocalLighting>,
    pub micros_per_pixel: u64,
    /// Number of calls to render pixels that lose the device.
    pub losses: u32,
    pub panics: u32,
    pub refuse_scenes: bool,
    /// Whether shaders are being compiled.
    pub compiles: bool,
    /// What the compiler says against them.
    pub error: Option<String>,
}

pub type Shared = Arc<Mutex<Log>>;

pub struct Fake {
    pub log: Shared,
    pub view: Option<View>,
}

fn lost() -> BackendError {
    BackendError::DeviceLost { reason: "unplugged".into() }
}

impl Fake {
    fn size(&self) -> [u32; 2] {
        self.view.as_ref().unwrap().size
    }

    /// Takes the time of `pixels` pixels.
    fn render(&self, pixels: u64, note: impl FnOnce(&mut Log)) -> Result<(), BackendError> {
        let mut log = self.log.lock().unwrap();
        if log.losses > 0 {
            log.losses -= 1;
            return Err(lost());
        }
        if log.panics > 0 {
            log.panics -= 1;
            drop(log);
            panic!("a mistake");
        }
        note(&mut log);
        let pause = Duration::from_micros(log.micros_per_pixel * pixels);
        drop(log);
        std::thread::sleep(pause);
        Ok(())
    }
}

impl Backend for Fake {
    fn name(&self) -> String {
        "fake".into()
    }

    fn set_scene(&mut self, _: &Baked) -> Result<(), BackendError> {
        let mut log = self.log.lock().unwrap();
        log.scenes += 1;
        let too_large = BackendError::Limit {
            what: "the cuts",
            needed: 2,
            limit: 1,
            unit: "bytes",
            adapter: "fake".into(),
            remedy: Remedy::SmallerCuts,
        };
        if log.refuse_scenes { Err(too_large) } else { Ok(()) }
    }

    fn pose(&mut self, _: &Baked, _: Option<&DeviceCuts>) -> Result<(), BackendError> {
        Ok(())
    }

    fn set_appearance(&mut self, _: &Appearance) -> Result<Vec<String>, BackendError> {
        self.log.lock().unwrap().appearances += 1;
        Ok(Vec::new())
    }

    fn set_light(&mut self, _: &Illumination, _: &Arc<EnvironmentLight>) -> Result<Vec<String>, BackendError> {
        self.log.lock().unwrap().lights += 1;
        Ok(Vec::new())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.log.lock().unwrap().local.push(lighting.clone());
        Ok(Vec::new())
    }

    fn begin(&mut self, view: &View, _: BrdfSampling) -> Result<(), BackendError> {
        self.log.lock().unwrap().begun.push((view.size, view.aa));
        self.view = Some(view.clone());
        Ok(())
    }

    fn is_ready(&mut self) -> Result<bool, BackendError> {
        let log = self.log.lock().unwrap();
        log.error.clone().map_or(Ok(!log.compiles), |error| Err(BackendError::Driver(error)))
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        let pixels = u64::from(rows.end - rows.start) * u64::from(self.size()[0]);
        self.render(pixels, |log| log.rows.push((sample, rows)))
    }

    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        let all = Tiles::of(self.size());
        let pixels: u64 = tiles.iter().map(|&tile| all.region(tile).pixels()).sum();
        // The coarsest lattice traces all pixels, each at an eighth of the cost of shading.
        let share = if stride == STRIDES[0] { 0.125 } else { share_of_lattice(stride) };
        let pixels = pixels as f64 * share;
        self.render(pixels as u64, |log| log.sketched.extend(tiles.iter().map(|&tile| (stride, tile))))
    }

    fn fill(&mut self, _: u32) -> Result<u32, BackendError> {
        Ok(0)
    }

    /// The eye's x in red, the exposure in green.
    fn display(&mut self, post: &Post, _: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        self.log.lock().unwrap().displays += 1;
        let view = self.view.as_ref().unwrap();
        let pixels = view.size[0] as usize * view.size[1] as usize;
        Ok(vec![[view.camera.eye.x as u8, post.exposure as u8, 0, 255]; pixels])
    }

    fn read(&mut self, _: u32) -> Result<(Image, Vec<f32>), BackendError> {
        let size = self.view.as_ref().unwrap().size;
        Ok((Image::filled(size, Vec3::ONE), vec![1.0; size[0] as usize * size[1] as usize]))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        Ok(PictureStats::default())
    }
}
