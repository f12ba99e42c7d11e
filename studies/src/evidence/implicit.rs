//! The figures of Dong, Kautz, Theobalt and Seidel, *Interactive Global Illumination Using Implicit Visibility* (Pacific Graphics
//! 2007), measured anew: Table 1, Fig. 4 and Fig. 11, and the error of the preview of a dragged object.

mod drag;
mod glossy;
mod links;

use super::{Measurement, cases::Case, notebook::Notebook};
use anyhow::{Context, Result};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    scene::{
        Scene,
        pose::{Objects, Pose, Poses},
    },
};
use lapidary_render::{Baked, Look, PathPicture, PathSettings};

/// The dragged object in the color box.
const SHORT_BLOCK: &str = "Short block";
const COLOR_BOX: &str = "color-box";

/// Measures all figures. Pictures show the color box, or else the first scene with several objects.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, cases: &[Case], notebook: &mut Notebook) -> Result<()> {
    measurement.steps.begin("implicit visibility: links");
    links::record(measurement, notebook)?;
    if let Some((case, dragged)) = dragged(cases) {
        measurement.steps.begin(&format!("implicit visibility: {} of {}", dragged.name, case.name));
        glossy::record(measurement, case, &dragged, notebook)?;
        drag::record(measurement, case, &dragged, notebook)?;
    }
    Ok(())
}

fn dragged(cases: &[Case]) -> Option<(&Case, Dragged)> {
    let color_box = cases.iter().filter(|case| case.name == COLOR_BOX);
    color_box.chain(cases).find_map(|case| Some((case, Dragged::of(&case.scene)?)))
}

/// An object dragged by half its width.
pub struct Dragged {
    object: u32,
    /// Its name.
    pub name: String,
    /// Width along X in meters.
    width: f32,
}

impl Dragged {
    /// The short block, or else the last object with a width. `None` for a scene with one object.
    pub fn of(scene: &Scene) -> Option<Self> {
        let objects = Objects::of(scene);
        let width = |object: u32| {
            let places = objects.vertices(object).iter().map(|&vertex| scene.mesh.positions[vertex as usize]);
            let bounds = Bounds::around(places);
            (bounds.max - bounds.min).x
        };
        let dragged =
            |object: u32| Self { object, name: scene.objects[object as usize].name.clone(), width: width(object) };
        let wide: Vec<Self> = (0..objects.len() as u32).map(dragged).filter(|dragged| dragged.width > 0.0).collect();
        if wide.len() < 2 {
            return None;
        }
        let last = wide.len() - 1;
        let at = wide.iter().position(|dragged| dragged.name == SHORT_BLOCK).unwrap_or(last);
        wide.into_iter().nth(at)
    }

    /// Pose after a share of the drag.
    pub fn poses(&self, share: f32) -> Poses {
        let mut poses = Poses::default();
        poses.set(self.object, Pose { translate: Vec3::NEG_X * 0.5 * self.width * share, ..Pose::AS_BAKED });
        poses
    }
}

impl Measurement<'_> {
    /// `spp` light paths per pixel through the posed scene of a look.
    pub fn posed_paths(&self, baked: &Baked, look: &Look, bounces: u32, spp: u32) -> Result<PathPicture> {
        self.steps.check()?;
        let progress = self.steps.progress("light paths", "passes");
        let posed = baked.posed(&look.poses).context("the object cannot be posed this way")?;
        let settings = PathSettings { bounces, components: look.components, ..PathSettings::direct(spp) };
        let renderer = Look { poses: Poses::default(), ..look.clone() }.renderer(&posed);
        let picture = renderer.path_picture(&look.view, &look.illumination, &look.lights, settings, &progress);
        progress.finish();
        self.steps.check()?;
        Ok(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{
        scene::Object,
        test_scenes::{quad, scene_of},
    };

    fn scene(names: &[&str]) -> Scene {
        let at = |x: f32| [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X].map(|p| p * (1.0 + x) + Vec3::Y * x);
        let quads = (0..names.len()).flat_map(|i| {
            let [a, b, c, d] = at(i as f32);
            quad(a, b, c, d)
        });
        let mut scene = scene_of(&quads.collect::<Vec<_>>());
        scene.mesh.triangle_object = (0..2 * names.len() as u32).map(|triangle| triangle / 2).collect();
        scene.objects = names.iter().map(|&name| Object { name: name.into() }).collect();
        scene
    }

    #[test]
    fn the_short_block_is_dragged_by_half_its_width() {
        let dragged = Dragged::of(&scene(&["floor", SHORT_BLOCK, "wall"])).unwrap();
        assert_eq!((dragged.object, dragged.width), (1, 2.0));
        let pose = dragged.poses(1.0).of(1);
        assert_eq!((pose.translate, dragged.poses(0.5).of(1).translate), (Vec3::NEG_X, 0.5 * Vec3::NEG_X));
        assert!(dragged.poses(0.0).is_empty());
        let last = Dragged::of(&scene(&["floor", "box"])).unwrap();
        assert_eq!((last.object, last.name.as_str()), (1, "box"));
        assert!(Dragged::of(&scene(&["floor"])).is_none(), "negative control: nothing would stay");
    }
}
