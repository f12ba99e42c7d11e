//! Options that pose objects: individually, and by the animation in a file.

use crate::values;
use crate::{
    outputs::CommandFiles,
    sequence::{Motion, Times},
    terminal::Console,
};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::{
    animation::{BoundAnimation, Playback},
    scene::{Scene, pose::Poses},
};
use lapidary_interchange::{animation, import::ImportOptions};
use std::{path::PathBuf, str::FromStr};

/// Poses of objects.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Pose")]
pub struct PoseArgs {
    /// Time of the animation at which objects are posed, in seconds, clamped to its beginning and end
    #[arg(long, value_name = "SECONDS", value_parser = values::finite, allow_hyphen_values = true)]
    time: Option<f32>,
    #[command(flatten)]
    objects: ObjectArgs,
    #[command(flatten)]
    clip: ClipArgs,
}

/// Poses of objects over the frames.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Pose")]
pub struct MotionArgs {
    /// Time of the animation in seconds: FROM..TO plays it from the first frame to the last in equal steps; one number is the time
    /// of all frames, or of the first frame with --fps
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    time: Option<TimeSpan>,
    /// Frames per second of the animation [default: from --time FROM..TO]
    #[arg(long, value_name = "N", value_parser = values::positive)]
    fps: Option<f32>,
    /// Repeat the animation after its end instead of holding its last pose
    #[arg(long = "loop")]
    looped: bool,
    #[command(flatten)]
    objects: ObjectArgs,
    #[command(flatten)]
    clip: ClipArgs,
}

/// Poses of single objects.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Pose")]
struct ObjectArgs {
    /// Objects moved from where they were baked: {"objects": {"NAME": {"translate": [X,Y,Z], "rotate_degrees": [X,Y,Z], "scale":
    /// S}}}, each turned about its center in the order X, Y, Z; applied on top of an animation
    #[arg(long, value_name = "FILE.json")]
    pose: Option<PathBuf>,
}

/// An animation in a file.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Pose")]
struct ClipArgs {
    /// glTF file from which the scene was baked; its animation poses the scene
    #[arg(long, value_name = "FILE.gltf")]
    animation: Option<PathBuf>,
    /// Scene of the file that was baked, if it has several, by name or by number from 0 [default: the file's default scene]
    #[arg(long, value_name = "NAME|NUMBER", requires = "animation")]
    scene: Option<String>,
    /// Name of an animation in the file [default: the first]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// A time in seconds, or a range from the first frame to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TimeSpan {
    from: f32,
    to: Option<f32>,
}

impl FromStr for TimeSpan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once("..") {
            Some((from, to)) => Ok(Self { from: values::finite(from)?, to: Some(values::finite(to)?) }),
            None => Ok(Self { from: values::finite(text)?, to: None }),
        }
    }
}

impl PoseArgs {
    /// Adds the files that these options read.
    pub fn files(&self, files: CommandFiles) -> CommandFiles {
        self.clip.files(self.objects.files(files))
    }

    /// Poses of a scene's objects; none without a file.
    ///
    /// # Errors
    /// A file that cannot be read, or poses of missing objects.
    pub fn read(&self, scene: &Scene, options: &ImportOptions, console: Console) -> Result<Poses> {
        let poses = self.objects.read(scene)?;
        match self.time {
            Some(seconds) => {
                let motion = self.clip.played(Times::at(seconds), Playback::Once, scene, options, console)?;
                Ok(motion.moment(0, 1).poses(&poses)?)
            }
            None => self.clip.must_be_absent().map(|()| poses),
        }
    }
}

impl MotionArgs {
    /// Adds the files that these options read.
    pub fn files(&self, files: CommandFiles) -> CommandFiles {
        self.clip.files(self.objects.files(files))
    }

    /// Poses shared by all frames, and the animation.
    ///
    /// # Errors
    /// A file that cannot be read, poses of missing objects, or contradictory options.
    pub fn read(&self, scene: &Scene, options: &ImportOptions, console: Console) -> Result<(Poses, Option<Motion>)> {
        let poses = self.objects.read(scene)?;
        let Some(times) = self.times()? else { return self.clip.must_be_absent().map(|()| (poses, None)) };
        let playback = if self.looped { Playback::Loop } else { Playback::Once };
        Ok((poses, Some(self.clip.played(times, playback, scene, options, console)?)))
    }

    fn times(&self) -> Result<Option<Times>> {
        Ok(Some(match (self.time, self.fps) {
            (None, None) if self.looped => bail!("--loop goes with --time or --fps; add one, or leave it out"),
            (None, None) => return Ok(None),
            (Some(TimeSpan { to: Some(_), .. }), Some(_)) => {
                bail!("--time FROM..TO says how fast the animation plays; leave --fps out, or give --time FROM alone")
            }
            (Some(TimeSpan { from, to: Some(to) }), None) => Times::Span { from, to },
            (Some(TimeSpan { from, to: None }), None) => Times::at(from),
            (time, Some(fps)) => Times::Rate { from: time.map_or(0.0, |time| time.from), fps },
        }))
    }
}

impl ObjectArgs {
    fn files(&self, files: CommandFiles) -> CommandFiles {
        files.reads(&self.pose)
    }

    fn read(&self, scene: &Scene) -> Result<Poses> {
        Ok(self.pose.as_deref().map(|path| Poses::read(path, scene)).transpose()?.unwrap_or_default())
    }
}

impl ClipArgs {
    fn files(&self, files: CommandFiles) -> CommandFiles {
        files.reads(&self.animation)
    }

    /// The clip of the animation, bound to a scene.
    fn played(
        &self,
        times: Times,
        playback: Playback,
        scene: &Scene,
        options: &ImportOptions,
        console: Console,
    ) -> Result<Motion> {
        let Some(path) = &self.animation else {
            bail!("a dataset holds no animation; add --animation FILE.gltf, the file that it was baked of");
        };
        let options = ImportOptions { scene: self.scene.clone(), ..options.clone() };
        let animation = animation::read(path, &options)?;
        let clip = animation.clip(self.clip.as_deref())?;
        animation.warnings.iter().for_each(|warning| console.warning(warning));
        Ok(Motion { animation: BoundAnimation::new(animation, scene)?.into(), clip, times, playback })
    }

    /// Rejects animation options without a time.
    fn must_be_absent(&self) -> Result<()> {
        if self.animation.is_some() || self.clip.is_some() {
            bail!("an animation poses at a time; add --time SECONDS, or leave out --animation and --clip");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_one_or_two_numbers_or_a_rate() {
        let args =
            |time: Option<&str>, fps| MotionArgs { time: time.map(|t| t.parse().unwrap()), fps, ..Default::default() };
        let times = |time, fps| args(time, fps).times().map_err(|error| error.to_string());
        assert_eq!(times(None, None), Ok(None));
        assert_eq!(times(Some("0.5..2"), None), Ok(Some(Times::Span { from: 0.5, to: 2.0 })));
        assert_eq!(times(Some("0.5"), None), Ok(Some(Times::Span { from: 0.5, to: 0.5 })));
        assert_eq!(times(Some("0.5"), Some(24.0)), Ok(Some(Times::Rate { from: 0.5, fps: 24.0 })));
        assert_eq!(times(None, Some(24.0)), Ok(Some(Times::Rate { from: 0.0, fps: 24.0 })));
        assert!(times(Some("0..2"), Some(24.0)).unwrap_err().contains("leave --fps out"));
        for text in ["", "a", "1..", "1..nan"] {
            assert!(text.parse::<TimeSpan>().is_err(), "{text}");
        }
    }
}
