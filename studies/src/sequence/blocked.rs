//! Frames that are black, as of a camera behind a wall.

use super::SequenceFrame;
use lapidary_render::{Baked, shows_light};

/// Most frames that are looked at, evenly spread.
const LOOKED_AT: usize = 360;

/// The numbers of the frames that show no light. Of long sequences some are looked at.
pub fn blocked_frames(frames: &[SequenceFrame], baked: &Baked) -> Vec<u32> {
    // Objects that move from frame to frame count where they are in the first.
    let moved = frames.first().map(|frame| &frame.look.poses).filter(|poses| !poses.is_empty());
    let posed = moved.and_then(|poses| baked.posed(poses).ok());
    let baked = posed.as_ref().unwrap_or(baked);
    let looked_at = frames.iter().step_by(frames.len().div_ceil(LOOKED_AT).max(1));
    looked_at.filter(|frame| !shows_light(baked, &frame.look)).map(|frame| frame.number).collect()
}

/// Says so, with a remedy; `None` without such frames.
pub fn blocked_words(blocked: &[u32], frames: usize) -> Option<String> {
    let (first, last) = (blocked.first()?, blocked.last()?);
    let which = if first == last { format!("frame {first}") } else { format!("from frame {first} to {last}") };
    Some(format!(
        "at least {} of {frames} frames are black, since no light reaches what the camera sees there, as behind a wall ({which}); move it \
         closer, or turn the scene instead",
        blocked.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{SequenceSettings, Turn, plan};
    use glam::Vec3;
    use lapidary_core::{
        dataset::Dataset,
        lights::{Emission, Light},
        test_scenes::{self, scene_of},
    };
    use lapidary_render::{Look, test_looks::look};

    #[test]
    fn frames_behind_a_wall_are_told_and_those_inside_the_room_are_not() {
        let scene = scene_of(&test_scenes::room(Vec3::ZERO, Vec3::splat(2.0)));
        let two_sided = vec![false; scene.mesh.triangles.len()];
        let baked = Baked::from(Dataset { scene, two_sided, ..test_scenes::dataset(&["a"], &[]) });
        // A lamp in the room, and no sky.
        let mut look = look();
        look.view.camera.target = Vec3::ZERO;
        look.components.environment = false;
        look.lights = [Light { emission: Emission::Point, position: Vec3::Y, ..look.lights[0].clone() }].into();
        let frames = |look: &Look, distance: f32| {
            let mut look = look.clone();
            look.view.camera.eye = look.view.camera.target + distance * Vec3::Z;
            let settings = SequenceSettings { turn: Some(Turn::Camera), frames: 8, ..Default::default() };
            blocked_frames(&plan(&look, &settings).unwrap(), &baked)
        };
        assert_eq!(frames(&look, 0.5), [0; 0], "negative control: in the room");
        let outside = frames(&look, 4.0);
        assert_eq!(outside, (1..=8).collect::<Vec<_>>());
        look.components.environment = true;
        assert_eq!(frames(&look, 9.0), [0; 0], "negative control: the sky is seen beside the room");
        look.illumination.intensity = 0.0;
        assert_eq!(frames(&look, 9.0).len(), 8, "a black sky");
        let words = blocked_words(&outside, 8).unwrap();
        assert!(words.contains("at least 8 of 8") && words.contains("from frame 1 to 8"), "{words}");
        assert_eq!(blocked_words(&[], 8), None);
    }
}
