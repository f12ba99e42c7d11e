//! Sequences of looks: which light and pictures are recomputed.

use super::*;
use crate::{
    Appearance, Components, CpuBackend, DeviceCuts, EnvironmentLight, Illumination, PictureStats, STRIDES, Solution,
    Tiles,
    test_looks::look,
    test_scenes::{from_above, illumination, linked_floor_and_wall, rel_rmse},
};
use glam::Vec3;
use lapidary_core::{scene::pose::Pose, test_scenes::dataset};

fn scene() -> LitScene {
    LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), dataset(&["a"], &[]).into()).unwrap()
}

fn shown(scene: &mut LitScene, look: &Look) -> (FinishedPicture, Vec<[u8; 4]>) {
    let picture = scene.show(look, &mut || true).unwrap().unwrap();
    (picture, scene.display(&look.post).unwrap())
}

fn base() -> Look {
    Look { appearance: Appearance::of(&dataset(&["a"], &[]).scene), ..look() }
}

#[test]
fn pictures_do_not_depend_on_those_before_them() {
    let mut looks = vec![base(); 8];
    // Darker, because the brightest pixels are clipped.
    looks[1].post.exposure = -3.0;
    looks[2].illumination.intensity = 3.0;
    looks[3].lights = [].into();
    looks[4].components.environment = false;
    looks[5].appearance.materials[0].parameters.set("roughness", 0.1);
    looks[6].view.camera.eye.x += 0.3;
    looks[7].poses.set(0, Pose { translate: Vec3::new(0.2, 0.0, 0.0), scale: 1.3, ..Pose::AS_BAKED });
    let mut one = scene();
    let pictures: Vec<_> = looks.iter().map(|look| shown(&mut one, look)).collect();
    for (look, (picture, display)) in looks.iter().zip(&pictures) {
        let (alone, alone_display) = shown(&mut scene(), look);
        assert!(alone.image == picture.image && alone_display == *display);
        assert_eq!(alone.stats.pixels_shaded, picture.stats.pixels_shaded);
    }
    let image = |i: usize| &pictures[i].0.image;
    assert!(image(0) == image(1) && pictures[0].1 != pictures[1].1, "only exposed");
    assert!(shown(&mut one, &looks[0]).0.image == *image(0), "and back");
    assert!((2..8).all(|i| image(i) != image(0)), "negative control");
}

#[test]
fn a_cancelled_picture_is_not_taken_for_a_finished_one() {
    let mut scene = scene();
    assert!(scene.show(&base(), &mut || false).unwrap().is_none());
    let (picture, _) = shown(&mut scene, &base());
    assert!(picture.image.pixels.iter().any(|pixel| pixel.max_element() > 0.0));
}

#[test]
fn the_environment_is_lit_again_only_when_it_is_another_or_forgotten() {
    let mut scene = scene();
    let revision = |scene: &mut LitScene, look: &Look| {
        scene.light(look).unwrap();
        scene.light_revision()
    };
    let moved = Look { lights: Arc::default(), ..base() };
    let environment = base().illumination;
    let at = |look: Look| Look { illumination: environment.clone(), ..look };
    assert_eq!(revision(&mut scene, &at(base())), 1);
    assert_eq!(revision(&mut scene, &at(moved.clone())), 1);
    let mut turned = at(moved);
    turned.illumination.rotation += 0.1;
    assert_eq!(revision(&mut scene, &turned), 2);
    scene.forget_light();
    assert_eq!(revision(&mut scene, &turned), 3);
    assert_eq!(revision(&mut scene, &turned), 3, "once");
}

#[test]
fn bounced_light_of_the_environment_has_the_illumination_cut_of_now() {
    let baked = Baked::from(linked_floor_and_wall());
    let light = illumination([64, 32], |x, y| Vec3::splat((x * y) as f32 * 0.01));
    let shown = |scene: &mut LitScene, illum_cut| {
        let components = Components { indirect: true, ..Components::NONE };
        let appearance = Appearance::of(&baked.dataset.scene);
        let view = View { aa: 1, ..from_above(8) };
        let look =
            Look { appearance, illumination: light.clone(), components, view, illum_cut, lights: [].into(), ..look() };
        [Solution::Meshless, Solution::CutsMeshless].map(|solution| {
            let look = Look { solution, ..look.clone() };
            scene.show_whole(&look).unwrap().image
        })
    };
    let begin = || LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
    let mut one = begin();
    let coarse = shown(&mut one, 2);
    let fine = shown(&mut one, 256);
    assert!(fine == shown(&mut begin(), 256), "as if no other cut had been before");
    assert!(fine != coarse && fine[0].pixels[27].x > 0.0, "negative control");
}

/// The coarsest sketch of a look, after finished ones of others.
fn sketched_after(before: &[&Look], look: &Look) -> Image {
    let mut scene = scene();
    let tiles: Vec<u32> = (0..Tiles::of(look.view.size).count()).collect();
    for look in before {
        scene.light(look).unwrap();
        scene.resume(&look.view, look.sampling).unwrap();
        STRIDES.iter().for_each(|&stride| scene.sketch(stride, &tiles).unwrap());
    }
    scene.light(look).unwrap();
    scene.resume(&look.view, look.sampling).unwrap();
    scene.sketch(STRIDES[0], &tiles).unwrap();
    scene.fill(0).unwrap();
    scene.backend().read(0).unwrap().0
}

#[test]
fn a_look_from_another_camera_has_the_detail_of_the_last_picture() {
    let mut look = base();
    look.view.size = [150, 110];
    let mut moved = look.clone();
    moved.view.camera.eye.x += 0.05;
    let full = shown(&mut scene(), &moved).0.image;
    let error = |image: &Image| rel_rmse(image, &full);
    let (after, alone) = (sketched_after(&[&look], &moved), sketched_after(&[], &moved));
    assert!(error(&after) < 0.7 * error(&alone), "{} {}", error(&after), error(&alone));
    let turned = Look { illumination: Illumination { rotation: 0.5, ..look.illumination.clone() }, ..look.clone() };
    let mut rough = look.clone();
    rough.appearance.materials[0].parameters.set("roughness", 0.3);
    for other in [turned, rough] {
        assert!(sketched_after(&[&other], &moved) == alone, "negative control: another light or material");
        assert!(sketched_after(&[&look, &other], &moved) == alone);
    }
}

/// Counts calls to a renderer, and renders nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counting {
    appearances: u32,
    lights: u32,
    locals: u32,
    bands: u32,
}

impl Backend for Counting {
    fn name(&self) -> String {
        "counting".into()
    }

    fn set_scene(&mut self, _: &Baked) -> Result<(), BackendError> {
        Ok(())
    }

    fn pose(&mut self, _: &Baked, _: Option<&DeviceCuts>) -> Result<(), BackendError> {
        Ok(())
    }

    fn set_appearance(&mut self, _: &Appearance) -> Result<Vec<String>, BackendError> {
        self.appearances += 1;
        Ok(Vec::new())
    }

    fn set_light(&mut self, _: &Illumination, _: &Arc<EnvironmentLight>) -> Result<Vec<String>, BackendError> {
        self.lights += 1;
        Ok(Vec::new())
    }

    fn set_local_lighting(&mut self, _: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.locals += 1;
        Ok(Vec::new())
    }

    fn begin(&mut self, _: &View, _: BrdfSampling) -> Result<(), BackendError> {
        Ok(())
    }

    fn render_rows(&mut self, _: u32, _: Range<u32>) -> Result<(), BackendError> {
        self.bands += 1;
        Ok(())
    }

    fn sketch(&mut self, _: u32, _: &[u32]) -> Result<(), BackendError> {
        Ok(())
    }

    fn fill(&mut self, _: u32) -> Result<u32, BackendError> {
        Ok(0)
    }

    fn display(&mut self, _: &Post, _: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        Ok(Vec::new())
    }

    fn read(&mut self, _: u32) -> Result<(Image, Vec<f32>), BackendError> {
        Ok((Image { size: [0, 0], pixels: Vec::new() }, Vec::new()))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        Ok(PictureStats::default())
    }
}

#[test]
fn what_is_measured_is_done_again_and_nothing_else() {
    let mut scene = LitScene::new(Box::new(Counting::default()), dataset(&["a"], &[]).into()).unwrap();
    let look = Look { components: Components { direct: true, ..Components::NONE }, ..base() };
    let shown = |scene: &mut LitScene<Counting>| {
        scene.show_whole(&look).unwrap();
        *scene.backend()
    };
    let once = Counting { appearances: 1, lights: 1, locals: 1, bands: 1 };
    assert_eq!(shown(&mut scene), once);
    assert_eq!(shown(&mut scene), once, "an unchanged look renders nothing");
    scene.forget_picture();
    assert_eq!(shown(&mut scene), Counting { bands: 2, ..once });
    scene.forget_light();
    assert_eq!(shown(&mut scene), Counting { appearances: 1, lights: 2, locals: 2, bands: 3 }, "materials stay");
}

#[test]
fn a_remark_is_told_once_while_it_holds() {
    let mut scene = scene();
    let mut bare = base();
    bare.appearance.materials.clear();
    let mut remarks = |look: &Look| {
        scene.light(look).unwrap();
        scene.remarks().len()
    };
    assert_eq!(remarks(&bare), 1);
    let dimmed = Look { components: Components::NONE, ..bare.clone() };
    assert_eq!(remarks(&dimmed), 0);
    assert_eq!(remarks(&base()), 0);
    assert_eq!(remarks(&bare), 1, "again after it did not hold");
}
