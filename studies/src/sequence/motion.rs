//! A file's animation, played over the frames of a sequence.

use lapidary_core::{
    animation::{AnimationError, BoundAnimation, Playback},
    scene::pose::Poses,
};
use std::sync::Arc;

/// A clip and its playback.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The animation, bound to the scene.
    pub animation: Arc<BoundAnimation>,
    /// Index of the clip.
    pub clip: usize,
    /// Times of the frames.
    pub times: Times,
    /// Behavior after its end.
    pub playback: Playback,
}

/// Times of frames in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Times {
    /// From the first frame to the last in equal steps.
    Span {
        /// Time of the first frame.
        from: f32,
        /// Time of the last frame.
        to: f32,
    },
    /// A constant frame rate.
    Rate {
        /// Time of the first frame.
        from: f32,
        /// Frames per second, above 0.
        fps: f32,
    },
}

impl Times {
    /// One time for all frames.
    pub fn at(seconds: f32) -> Self {
        Self::Span { from: seconds, to: seconds }
    }
}

/// The animation at one frame.
#[derive(Clone, Debug)]
pub struct Moment {
    motion: Motion,
    /// Time in the clip, in seconds.
    pub seconds: f32,
}

impl PartialEq for Motion {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.animation, &other.animation)
            && (self.clip, self.times, self.playback) == (other.clip, other.times, other.playback)
    }
}

impl Motion {
    /// Whether frames have different times.
    pub fn plays(&self) -> bool {
        !matches!(self.times, Times::Span { from, to } if from == to)
    }

    /// Name of the time in files and captions.
    pub fn label(&self) -> String {
        format!("time@{}", self.clip().name)
    }

    /// The moment of a frame in a sequence of `frames` frames.
    pub fn moment(&self, index: u32, frames: u32) -> Moment {
        let seconds = match self.times {
            Times::Span { from, to } => from + (to - from) * (index as f32 / frames.saturating_sub(1).max(1) as f32),
            Times::Rate { from, fps } => (f64::from(from) + f64::from(index) / f64::from(fps)) as f32,
        };
        Moment { motion: self.clone(), seconds: self.clip().time_at(seconds, self.playback) }
    }

    fn clip(&self) -> &lapidary_core::animation::Clip {
        &self.animation.clips()[self.clip]
    }
}

impl Moment {
    /// `poses` with the animation's deformations.
    ///
    /// # Errors
    /// Vertices out of range.
    pub fn poses(&self, poses: &Poses) -> Result<Poses, AnimationError> {
        self.motion.animation.poses_at(self.motion.clip, self.seconds, poses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bundled::DataFolder,
        sequence::{SequenceSettings, plan},
    };
    use lapidary_core::animation::ClipTime;
    use lapidary_interchange::{
        animation,
        import::{ImportOptions, import},
    };
    use lapidary_render::test_looks::look;

    fn motion(times: Times, playback: Playback) -> Motion {
        let path = DataFolder::find(None).unwrap().scene("bending-tower");
        let scene = import(&path).unwrap().scene;
        let animation = animation::read(&path, &ImportOptions::default()).unwrap();
        Motion { animation: BoundAnimation::new(animation, &scene).unwrap().into(), clip: 0, times, playback }
    }

    #[test]
    fn frames_are_even_in_time_and_a_loop_begins_again() {
        let seconds = |times, playback| {
            let motion = motion(times, playback);
            (0..5).map(|frame| motion.moment(frame, 5).seconds).collect::<Vec<_>>()
        };
        assert_eq!(seconds(Times::Span { from: 0.0, to: 2.0 }, Playback::Once), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(seconds(Times::Rate { from: 1.0, fps: 2.0 }, Playback::Once), [1.0, 1.5, 2.0, 2.0, 2.0]);
        assert_eq!(seconds(Times::Rate { from: 1.0, fps: 2.0 }, Playback::Loop), [1.0, 1.5, 0.0, 0.5, 1.0]);
    }

    #[test]
    fn each_frame_of_a_plan_is_posed_at_its_time() {
        let motion = motion(Times::Span { from: 0.0, to: 1.0 }, Playback::Once);
        let settings = |motion| SequenceSettings { frames: 3, turn: None, motion: Some(motion), ..Default::default() };
        let frames = plan(&look(), &settings(motion.clone())).unwrap();
        let poses: Vec<Poses> = frames.iter().map(|frame| frame.posed().unwrap().poses).collect();
        let time = ClipTime { clip: "Bend".into(), seconds: 0.5 };
        assert_eq!(poses[1], motion.animation.poses_at(0, 0.5, &Poses::default()).unwrap().at(time.clone()));
        assert_eq!((poses[1].clip_time(), poses[0].clip_time()), (Some(&time), None));
        assert!(poses[0].is_empty() && poses[1] != poses[2], "negative control");
        assert_eq!(frames[1].caption(), ["frame 2", "time@Bend 0.5"]);
        let still = Motion { times: Times::Span { from: 1.0, to: 1.0 }, ..motion };
        assert!(plan(&look(), &settings(still)).is_err());
    }
}
