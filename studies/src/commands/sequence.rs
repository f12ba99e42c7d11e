//! `lapidary sequence`: turntables, sweeps and animations as image sequences.

use crate::{
    args::{LocalLightArgs, MotionArgs, PictureArgs, ViewArgs, warn_of_buried},
    export::{LayerList, Studio, has_extension, is_exr, wanted_layers},
    outputs::CommandFiles,
    sequence::{
        Existing, FrameNames, Motion, SequenceEnd, SequenceSettings, SequenceTask, SheetTask, Spin, Sweep, Turn,
        blocked_frames, blocked_words, plan, sequence_files,
    },
    terminal::{Console, Outcome, ProgressReporter, StepProgress},
};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::scene::Scene;
use lapidary_render::{Look, Renderer};
use std::{path::PathBuf, time::Instant};

/// Options of `sequence`.
#[derive(Args, Clone, Debug)]
pub struct SequenceArgs {
    /// Turn this about the vertical through the camera's target
    #[arg(long, value_enum)]
    turn: Option<Turn>,
    /// Object that turns alone about its own center, with --turn object
    #[arg(long, value_name = "NAME", requires = "turn")]
    turn_only: Option<String>,
    /// Angle of the turn in degrees, counter-clockwise seen from above. For whole turns the last frame is one step before the
    /// first, so the sequence loops
    #[arg(long, value_name = "DEG", default_value = "360", value_parser = crate::values::finite, allow_hyphen_values = true, requires = "turn")]
    degrees: f32,
    /// Parameter to vary from the first frame to the last: NAME=FROM..TO in equal steps, or NAME=log:FROM..TO in equal ratios; may
    /// be given several times. NAME is a parameter of a BRDF model, as roughness, base-color or coat-weight (`lapidary models`
    /// lists them, with _ for -), bump or normal (of all materials, or of one with @MATERIAL), rotation, intensity, exposure,
    /// illum-cut (with --brdf refine or once), lit-cuts, light-intensity (a factor; of all lights, or of one with @LIGHT),
    /// light-position, light-target (X,Y,Z..X,Y,Z), eye, target, fov, f-number or focus
    #[arg(long, value_name = "SWEEP", allow_hyphen_values = true)]
    sweep: Vec<Sweep>,
    /// Number of frames
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=108_000))]
    frames: u32,
    /// Number of the first frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=9_999_999))]
    first: u32,
    /// Files to write, with #### for the frame number: DIR/frame.####.png (as displayed), .exr or .hdr
    /// (scene-linear); may be given several times. DIR is created; frame.json in it describes each frame
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Layers of exr files, as for `render`
    #[arg(long, value_name = "LIST")]
    layers: Option<LayerList>,
    /// Write a contact sheet of all frames
    #[arg(long, value_name = "FILE.png")]
    contact_sheet: Option<PathBuf>,
    /// Frames per row of the contact sheet [default: about as many as rows]
    #[arg(long, value_name = "N", requires = "contact_sheet", value_parser = clap::value_parser!(u32).range(1..=100))]
    columns: Option<u32>,
    /// Continue and keep existing frames
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace existing frames
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    motion: MotionArgs,
}

/// Renders the sequence, or its first part at Ctrl-C.
///
/// # Errors
/// Unreadable or unwritable files, or contradictory options.
pub fn run(args: &SequenceArgs, console: Console) -> Result<Outcome> {
    let outputs = args.outputs()?;
    let interrupt = ProgressReporter::interruptible(console);
    args.view.check_memory(1 + args.layers.as_ref().map_or(0, LayerList::most))?;
    let mut viewed = args.view.resolve(&args.local, console)?;
    viewed.view.aa = args.view.smooth_samples(&viewed.view.camera);
    let (poses, motion) = args.motion.read(&viewed.baked.dataset.scene, &args.view.import_options(), console)?;
    viewed.poses = poses;
    let look = args.picture.look(&viewed)?;
    let settings = SequenceSettings { spin: args.spin(&viewed.baked.dataset.scene, &look)?, ..args.settings(motion) };
    let task = SequenceTask {
        frames: plan(&look, &settings)?,
        outputs,
        layers: wanted_layers(args.layers.as_ref(), &look)?,
        existing: args.existing(),
        sheet: args.sheet(),
    };
    let blocked = blocked_words(&blocked_frames(&task.frames, &viewed.baked), task.frames.len());
    blocked.into_iter().for_each(|words| console.warning(words));
    let prepared = task.prepare(&viewed.baked.dataset)?;
    let start = Instant::now();
    let baked = viewed.baked.clone();
    let mut studio = Studio::new(args.picture.device.open()?, baked.clone())?;
    warn_of_buried(&Renderer::new(baked), &viewed.local.lights, console);
    let progress = StepProgress::new("sequence", "frames", &interrupt, console.quiet);
    let end = task.run(prepared, &mut studio, &progress);
    progress.finish();
    studio.remarks().iter().for_each(|remark| console.warning(remark));
    tell(&task, end?, start, console)
}

fn tell(task: &SequenceTask, end: SequenceEnd, start: Instant, console: Console) -> Result<Outcome> {
    let SequenceEnd { rendered, kept, cancelled } = end;
    let record = task.record_path();
    if cancelled {
        let (done, all) = (rendered + kept, task.frames.len());
        console
            .note(format_args!("stopped: {done} of {all} frames are there; --resume continues ({})", record.display()));
        return Ok(Outcome::Interrupted);
    }
    let kept = if kept > 0 { format!(", {kept} were there") } else { String::new() };
    let seconds = start.elapsed().as_secs_f64();
    console.summary(format_args!("{}: {rendered} frames in {seconds:.1} s{kept}", record.display()))?;
    Ok(Outcome::Done)
}

impl SequenceArgs {
    /// Files that it reads and writes.
    ///
    /// # Errors
    /// Names that do not form a sequence.
    pub fn files(&self) -> Result<CommandFiles> {
        let outputs = self.outputs()?;
        let files = self.motion.files(self.view.files(&self.local).reads(&self.picture.backplate));
        let numbers = self.first..self.first + self.frames;
        Ok(sequence_files(files, &outputs, numbers, self.existing(), self.contact_sheet.as_deref()))
    }

    fn outputs(&self) -> Result<Vec<FrameNames>> {
        if self.layers.is_some() && !self.out.iter().any(|path| is_exr(path)) {
            bail!("only exr files hold layers; add --out DIR/frame.####.exr, or leave --layers out");
        }
        // The sheet's folder may be the frames' folder, which is created later.
        if let Some(sheet) = self.contact_sheet.as_ref().filter(|sheet| !has_extension(sheet, "png")) {
            bail!("a contact sheet is a png file; end its name in .png ({})", sheet.display());
        }
        self.out.iter().map(|path| FrameNames::new(path)).collect()
    }

    fn settings(&self, motion: Option<Motion>) -> SequenceSettings {
        let Self { frames, first, turn, degrees, sweep, .. } = self;
        SequenceSettings {
            frames: *frames,
            first: *first,
            turn: *turn,
            spin: None,
            degrees: *degrees,
            sweeps: sweep.clone(),
            motion,
        }
    }

    /// The object that turns alone.
    fn spin(&self, scene: &Scene, look: &Look) -> Result<Option<Spin>> {
        let Some(wanted) = &self.turn_only else { return Ok(None) };
        if self.turn != Some(Turn::Object) {
            bail!("--turn-only names an object; add --turn object");
        }
        let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        match names.iter().position(|name| name == wanted) {
            Some(object) => Ok(Some(Spin::about_center(scene, object as u32, look))),
            None => bail!("the scene has no object \"{wanted}\"; it has {}", names.join(", ")),
        }
    }

    fn existing(&self) -> Existing {
        match (self.resume, self.overwrite) {
            (true, _) => Existing::Resume,
            (false, true) => Existing::Overwrite,
            (false, false) => Existing::Refuse,
        }
    }

    fn sheet(&self) -> Option<SheetTask> {
        let columns = self.columns.map(|columns| columns as usize);
        self.contact_sheet.clone().map(|path| SheetTask { path, columns })
    }
}
