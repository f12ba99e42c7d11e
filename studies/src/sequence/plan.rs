//! Contents of each frame of a sequence, decided before any is rendered.

use super::{Moment, Motion, Spin, Sweep, Turn, Value, error::SweepError};
use lapidary_core::{animation::AnimationError, lights::LightProblem};
use lapidary_render::Look;
use thiserror::Error;

/// Most frames of a sequence: an hour at 30 per second.
pub const MAX_FRAMES: u32 = 108_000;

/// Name of a turn in files and captions.
const TURN: &str = "turn";

/// Why a sequence cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// No frames.
    #[error("a sequence needs at least one frame; ask for 1 or more")]
    NoFrames,
    /// Too many frames.
    #[error("{0} frames are more than the limit of {MAX_FRAMES}; give fewer")]
    TooMany(u32),
    /// All frames would be equal.
    #[error(
        "nothing changes from frame to frame; turn something (--turn in a command), sweep a parameter (--sweep) or play an animation (--time FROM..TO or --fps)"
    )]
    Still,
    /// A quantity is swept twice.
    #[error("{0} is swept twice; leave one of the sweeps out")]
    Twice(String),
    /// There are no lights to turn.
    #[error("there are no local lights to turn; add some, or turn something else")]
    NoLights,
    /// A sweep does not fit the scene.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A camera has no direction.
    #[error("in frame {0} the camera's eye and target are the same point; change the sweep")]
    NoDirection(u32),
    /// A light cannot shine.
    #[error("in frame {frame} the light \"{name}\" cannot shine: {source}")]
    Light {
        /// Frame number.
        frame: u32,
        /// Name of the light.
        name: String,
        /// The light's problem.
        source: LightProblem,
    },
}

/// A requested sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceSettings {
    /// Number of frames.
    pub frames: u32,
    /// Number of the first frame.
    pub first: u32,
    /// What turns, if anything.
    pub turn: Option<Turn>,
    /// An object that turns alone, in place of all, if the object turns.
    pub spin: Option<Spin>,
    /// Angle in degrees, counter-clockwise seen from above. After whole turns the last frame is one step before the first.
    pub degrees: f32,
    /// Parameters that change from the first frame to the last.
    pub sweeps: Vec<Sweep>,
    /// The animation, if any.
    pub motion: Option<Motion>,
}

impl Default for SequenceSettings {
    fn default() -> Self {
        Self {
            frames: 48,
            first: 1,
            turn: Some(Turn::Object),
            spin: None,
            degrees: 360.0,
            sweeps: Vec::new(),
            motion: None,
        }
    }
}

/// A frame.
#[derive(Clone, Debug)]
pub struct SequenceFrame {
    /// Frame number, as in its file names.
    pub number: u32,
    /// Varying values by name.
    pub values: Vec<(String, Value)>,
    /// The look of the frame, without deformations at its moment: see [`Self::posed`].
    pub look: Look,
    /// Its moment in an animation.
    pub moment: Option<Moment>,
}

/// The frames of a sequence that varies a look.
///
/// # Errors
/// Settings that give no sequence or do not fit the scene in some frame.
pub fn plan(base: &Look, settings: &SequenceSettings) -> Result<Vec<SequenceFrame>, PlanError> {
    check(base, settings)?;
    (0..settings.frames).map(|index| frame(base, settings, index)).collect()
}

fn check(base: &Look, settings: &SequenceSettings) -> Result<(), PlanError> {
    let SequenceSettings { frames, turn, sweeps, motion, .. } = settings;
    if *frames == 0 {
        return Err(PlanError::NoFrames);
    }
    if *frames > MAX_FRAMES {
        return Err(PlanError::TooMany(*frames));
    }
    if turn.is_none() && sweeps.is_empty() && !motion.as_ref().is_some_and(Motion::plays) {
        return Err(PlanError::Still);
    }
    if *turn == Some(Turn::Lights) && base.lights.is_empty() {
        return Err(PlanError::NoLights);
    }
    for (i, sweep) in sweeps.iter().enumerate() {
        sweep.check_form()?;
        if sweeps[..i].iter().any(|other| other.label() == sweep.label()) {
            return Err(PlanError::Twice(sweep.label()));
        }
    }
    Ok(())
}

fn frame(base: &Look, settings: &SequenceSettings, index: u32) -> Result<SequenceFrame, PlanError> {
    let (mut look, mut values) = (base.clone(), Vec::new());
    let number = settings.first.saturating_add(index);
    let share = if settings.frames > 1 { index as f32 / (settings.frames - 1) as f32 } else { 0.0 };
    // Sweeps first; the turn then moves their results.
    for sweep in &settings.sweeps {
        sweep.apply(&mut look, share)?;
        values.push((sweep.label(), sweep.value(share)));
    }
    if let Some(turn) = settings.turn {
        let degrees = settings.turned(index);
        match settings.spin.filter(|_| turn == Turn::Object) {
            Some(spin) => spin.apply(&mut look, degrees),
            None => turn.apply(&mut look, degrees),
        }
        values.insert(0, (format!("{TURN}-{}", turn.name()), Value::Number(degrees)));
    }
    let moment = settings.motion.as_ref().map(|motion| {
        let moment = motion.moment(index, settings.frames);
        values.push((motion.label(), Value::Number(moment.seconds)));
        moment
    });
    validate(number, &look)?;
    Ok(SequenceFrame { number, values, look, moment })
}

impl SequenceSettings {
    /// Angle of the turn in frame `index`.
    fn turned(&self, index: u32) -> f32 {
        let whole = self.degrees != 0.0 && self.degrees % 360.0 == 0.0;
        let steps = if whole { self.frames } else { self.frames.saturating_sub(1).max(1) };
        (f64::from(self.degrees) * f64::from(index) / f64::from(steps)) as f32
    }
}

/// Rejects combinations of individually valid values.
fn validate(number: u32, look: &Look) -> Result<(), PlanError> {
    if look.view.camera.eye == look.view.camera.target {
        return Err(PlanError::NoDirection(number));
    }
    for light in look.lights.iter() {
        let problem = |source| PlanError::Light { frame: number, name: light.name.clone(), source };
        light.validate().map_err(problem)?;
    }
    Ok(())
}

impl SequenceFrame {
    /// The look with objects posed by the animation; thousands of such frames would not fit in memory.
    ///
    /// # Errors
    /// Vertices out of range.
    pub fn posed(&self) -> Result<Look, AnimationError> {
        let posed = self.moment.as_ref().map(|moment| moment.poses(&self.look.poses)).transpose()?;
        Ok(Look { poses: posed.unwrap_or_else(|| self.look.poses.clone()), ..self.look.clone() })
    }

    /// Caption on a contact sheet.
    pub fn caption(&self) -> Vec<String> {
        let value = |(name, value): &(String, Value)| match name.strip_prefix(TURN).and_then(|t| t.strip_prefix('-')) {
            Some(turned) => format!("{turned} {value}°"),
            None => format!("{name} {value}"),
        };
        let number = std::iter::once(format!("frame {}", self.number));
        number.chain(self.values.iter().map(value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_render::test_looks::look;

    fn sweeps(texts: &[&str]) -> SequenceSettings {
        let sweeps = texts.iter().map(|text| text.parse().unwrap()).collect();
        SequenceSettings { frames: 5, turn: None, sweeps, ..Default::default() }
    }

    fn degrees(settings: &SequenceSettings) -> Vec<f32> {
        plan(&look(), settings).unwrap().iter().map(|frame| frame.values[0].1.number()).collect()
    }

    #[test]
    fn a_whole_turn_does_not_repeat_its_first_frame_and_a_part_of_one_ends_where_it_says() {
        let turn = |degrees, frames| SequenceSettings { degrees, frames, ..Default::default() };
        assert_eq!(degrees(&turn(360.0, 4)), [0.0, 90.0, 180.0, 270.0]);
        assert_eq!(degrees(&turn(-720.0, 2)), [0.0, -360.0]);
        assert_eq!(degrees(&turn(90.0, 4)), [0.0, 30.0, 60.0, 90.0]);
        assert_eq!(degrees(&turn(90.0, 1)), [0.0]);
    }

    #[test]
    fn sweeps_run_together_from_the_first_frame_to_the_last() {
        let frames = plan(&look(), &sweeps(&["roughness=0..1", "exposure=2..-2"])).unwrap();
        let values = |frame: &SequenceFrame| {
            (frame.number, frame.look.appearance.materials[1].parameters.number("roughness"), frame.look.post.exposure)
        };
        let all: Vec<_> = frames.iter().map(values).collect();
        assert_eq!(all, [(1, 0.0, 2.0), (2, 0.25, 1.0), (3, 0.5, 0.0), (4, 0.75, -1.0), (5, 1.0, -2.0)]);
        assert_eq!(frames[1].caption(), ["frame 2", "roughness 0.25", "exposure 1"]);
    }

    #[test]
    fn a_turn_takes_what_is_swept_along() {
        let settings =
            SequenceSettings { turn: Some(Turn::Camera), degrees: 180.0, frames: 2, ..sweeps(&["eye=0,1,2..0,1,4"]) };
        let frames = plan(&look(), &settings).unwrap();
        let eye = frames[1].look.view.camera.eye;
        let center = look().view.camera.target;
        let expected = Vec3::new(2.0 * center.x, 1.0, 2.0 * center.z - 4.0);
        assert!((eye - expected).length() < 1e-5, "{eye}");
        assert_eq!(frames[1].caption(), ["frame 2", "camera 180°", "eye 0, 1, 4"]);
    }

    #[test]
    fn what_makes_no_sequence_is_refused() {
        let refused = |settings: &SequenceSettings| plan(&look(), settings).unwrap_err();
        let still = sweeps(&[]);
        assert_eq!(refused(&still), PlanError::Still);
        let settings = SequenceSettings::default();
        assert_eq!(refused(&SequenceSettings { frames: 0, ..settings.clone() }), PlanError::NoFrames);
        assert_eq!(refused(&SequenceSettings { frames: 200_000, ..settings.clone() }), PlanError::TooMany(200_000));
        assert_eq!(refused(&sweeps(&["fov=20..30", "fov=30..20"])), PlanError::Twice("fov".into()));
        let dark = Look { lights: [].into(), ..look() };
        let lights = SequenceSettings { turn: Some(Turn::Lights), ..settings };
        assert_eq!(plan(&dark, &lights).unwrap_err(), PlanError::NoLights);
        assert!(plan(&look(), &lights).is_ok(), "negative control");
    }

    #[test]
    fn a_frame_that_cannot_be_is_told_before_any_is_rendered() {
        let target = "0.1,0.3,0";
        let through = plan(&look(), &sweeps(&[&format!("eye=9,0,0..{target}")])).unwrap_err();
        assert_eq!(through, PlanError::NoDirection(5));
        let onto = plan(&look(), &sweeps(&["light-position=1,1,1..0,0.2,0"])).unwrap_err();
        assert!(matches!(onto, PlanError::Light { frame: 5, .. }), "{onto}");
    }
}
