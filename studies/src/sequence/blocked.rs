//! Frames that are black because the camera is behind a wall.

use super::SequenceFrame;
use glam::Vec2;
use lapidary_render::Baked;

/// Rays in each direction of a frame.
const RAYS: u32 = 9;

/// The numbers of the frames most of whose rays meet a surface from behind, where it is not seen.
pub fn blocked_frames(frames: &[SequenceFrame], baked: &Baked) -> Vec<u32> {
    // Objects that move from frame to frame count where they are in the first.
    let moved = frames.first().map(|frame| &frame.look.poses).filter(|poses| !poses.is_empty());
    let posed = moved.and_then(|poses| baked.posed(poses).ok());
    let baked = posed.as_ref().unwrap_or(baked);
    let two_sided = &baked.dataset.two_sided;
    let intersector = baked.intersector();
    let is_black = |frame: &&SequenceFrame| {
        let view = &frame.look.view;
        let size = Vec2::new(view.size[0] as f32, view.size[1] as f32);
        let projection = view.projection();
        let sees_back = |ray: u32| {
            let share = Vec2::new((ray % RAYS) as f32 + 0.5, (ray / RAYS) as f32 + 0.5) / RAYS as f32;
            let (origin, direction) = projection.ray(share * size);
            let hit = intersector.closest_hit(origin, direction);
            hit.is_some_and(|hit| hit.back_face && !two_sided[hit.triangle as usize])
        };
        2 * (0..RAYS * RAYS).filter(|&ray| sees_back(ray)).count() as u32 > RAYS * RAYS
    };
    frames.iter().filter(is_black).map(|frame| frame.number).collect()
}

/// Says so, with a remedy; `None` without such frames.
pub fn blocked_words(blocked: &[u32], frames: usize) -> Option<String> {
    let (first, last) = (blocked.first()?, blocked.last()?);
    let which = if first == last { format!("frame {first}") } else { format!("from frame {first} to {last}") };
    Some(format!(
        "{} of {frames} frames are black, since the camera is behind a wall ({which}); move it closer, or turn the object instead",
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
        test_scenes::{self, scene_of},
    };
    use lapidary_render::test_looks::look;

    #[test]
    fn frames_behind_a_wall_are_told_and_those_inside_the_room_are_not() {
        let scene = scene_of(&test_scenes::room(Vec3::ZERO, Vec3::splat(2.0)));
        let two_sided = vec![false; scene.mesh.triangles.len()];
        let baked = Baked::from(Dataset { scene, two_sided, ..test_scenes::dataset(&["a"], &[]) });
        let mut look = look();
        look.view.camera.target = Vec3::ZERO;
        let mut orbit = |distance: f32| {
            look.view.camera.eye = look.view.camera.target + distance * Vec3::Z;
            let settings = SequenceSettings { turn: Some(Turn::Camera), frames: 8, ..Default::default() };
            blocked_frames(&plan(&look, &settings).unwrap(), &baked)
        };
        assert_eq!(orbit(0.5), [0; 0], "negative control");
        let outside = orbit(4.0);
        assert_eq!(outside, (1..=8).collect::<Vec<_>>());
        let words = blocked_words(&outside, 8).unwrap();
        assert!(words.contains("8 of 8") && words.contains("from frame 1 to 8"), "{words}");
        assert_eq!(blocked_words(&[], 8), None);
    }
}
