//! Pictures of posed objects, against bakes of the posed scenes.

use super::*;
use crate::{
    Backend, Components, CpuBackend, LitScene, LocalLighting, Look, Refined, Renderer,
    light::solver::solutions::Solution,
    test_scenes::{
        Edited, dataset, from_above, from_the_side, glossy, illumination, mesh, point_light, rel_rmse, white,
    },
};
use lapidary_core::{
    brdf::{GgxParameters, Parameters},
    dataset::Dataset,
    image::Image,
    material::BrdfModel,
    scene::{
        Object, Scene,
        pose::{MOST_OBJECTS, Objects, Pose},
    },
};

const BLOCKER: u32 = 1;

/// A floor with a blocker above it as a separate object.
pub(crate) fn blocked(parameters: impl Into<Parameters>, cells: u32) -> Dataset {
    let mut mesh = mesh(cells, true);
    let blocker = mesh.triangles.len() - 4..;
    mesh.triangle_object[blocker].fill(BLOCKER);
    let mut dataset = dataset(mesh, parameters);
    dataset.scene.objects.push(Object { name: "blocker".into() });
    dataset
}

pub(crate) fn posed(pose: Pose) -> Poses {
    let mut poses = Poses::default();
    poses.set(BLOCKER, pose);
    poses
}

/// A rig at the detail of a drag, in the baked pose.
fn under_the_sky(baked: &Baked) -> Edited<PoseRig> {
    let mut rig = Edited::new(baked, PoseRig::new(baked, &Compute::Cores, ImplicitDetail::OF_A_DRAG));
    rig.set_environment(Some(Renderer::new(baked.clone()).lighting(&sky(), 64)));
    rig
}

/// The dataset of a bake of the posed scene.
fn baked_so(as_baked: &Dataset, poses: &Poses, parameters: impl Into<Parameters>) -> Dataset {
    let mesh = poses.pose(&as_baked.scene.mesh, &Objects::of(&as_baked.scene)).unwrap();
    Dataset { scene: Scene { mesh: mesh.clone(), ..as_baked.scene.clone() }, ..dataset(mesh, parameters) }
}

/// A sky with one brighter side.
pub(crate) fn sky() -> crate::Illumination {
    illumination([16, 8], |x, y| Vec3::splat(if y < 5 && (4..8).contains(&x) { 6.0 } else { 1.0 }))
}

fn picture(dataset: &Dataset, look: impl FnOnce(&mut Look)) -> Image {
    let mut seen = Look::under_environment(&dataset.scene, from_above(48), sky());
    look(&mut seen);
    let mut scene = LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), dataset.clone().into()).unwrap();
    scene.set_detail(ImplicitDetail::OF_A_DRAG);
    scene.show_whole(&seen).unwrap().image
}

#[test]
fn a_preview_is_close_to_a_bake_of_the_posed_scene_and_the_bake_as_it_was_is_not() {
    let as_baked = blocked(white(), 24);
    let turned =
        Pose { translate: Vec3::new(0.7, -0.2, 0.4), rotate_degrees: Vec3::Y * 30.0, scale: 1.2, ..Pose::AS_BAKED };
    let away = Pose { translate: Vec3::Y * 1000.0, ..Pose::AS_BAKED };
    for pose in [turned, away] {
        let poses = posed(pose);
        let truth = picture(&baked_so(&as_baked, &poses, white()), |_| ());
        let preview = picture(&as_baked, |look| look.poses = poses.clone());
        let (near, before) = (rel_rmse(&preview, &truth), rel_rmse(&picture(&as_baked, |_| ()), &truth));
        assert!(near < 0.08 && before > 2.5 * near, "{near}, negative control {before}");
    }
}

#[test]
fn a_pose_that_is_lit_more_finely_has_the_bits_of_that_detail() {
    let as_baked = blocked(white(), 8);
    let [coarse, fine, ..] = ImplicitDetail::LADDER;
    let mut look = Look::under_environment(&as_baked.scene, from_above(24), sky());
    look.poses = posed(Pose { translate: Vec3::new(0.7, -0.2, 0.4), ..Pose::AS_BAKED });
    let begin = || LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), as_baked.clone().into()).unwrap();
    let at = |scene: &mut LitScene, detail| {
        scene.set_detail(detail);
        let picture = scene.show_whole(&look).unwrap().image;
        assert_eq!(scene.detail(), Some(detail));
        picture
    };
    let mut scene = begin();
    let pictures = [coarse, fine, coarse].map(|detail| at(&mut scene, detail));
    assert!(pictures[1] == at(&mut begin(), fine) && pictures[0] == pictures[2]);
    assert!(pictures[0] != pictures[1], "negative control");
}

#[test]
fn what_an_object_lay_on_is_lit_when_it_is_lifted_and_stays_dark_while_it_lies() {
    let mut lying = blocked(white(), 24);
    let floor = lying.scene.mesh.positions.len() - 8;
    lying.scene.mesh.positions[floor..].iter_mut().for_each(|position| position.y -= 0.997);
    let mut as_baked = Dataset { scene: lying.scene.clone(), ..dataset(lying.scene.mesh.clone(), white()) };
    let is_under = |p: &Vec3| p.x.abs() <= 0.51 && p.z.abs() <= 0.51;
    for (valid, position) in as_baked.vertex_valid.iter_mut().zip(&lying.scene.mesh.positions[..floor]) {
        *valid = !is_under(position);
    }
    let lifted = posed(Pose { translate: Vec3::new(0.0, 1.5, 0.3), ..Pose::AS_BAKED });
    let posed_bake = baked_so(&as_baked, &lifted, white());
    let of_the_bake = Dataset { scene: posed_bake.scene.clone(), ..as_baked.clone() };
    let [truth, dark] = [&posed_bake, &of_the_bake].map(|dataset| picture(dataset, |_| ()));
    let preview = picture(&as_baked, |look| look.poses = lifted);
    let (near, dark) = (rel_rmse(&preview, &truth), rel_rmse(&dark, &truth));
    assert!(near < 0.06 && dark > 2.5 * near, "{near}, negative control {dark}: the cuts of the bake");
    let baked = Baked::from(as_baked.clone());
    let mut rig = under_the_sky(&baked);
    let middle = 25 * 12 + 12;
    assert!(!rig.has_new_cut()[middle], "it lies where it lay");
    let mut is_lit = |x: f32| {
        rig.set_poses(&baked, &posed(Pose { translate: Vec3::X * x, ..Pose::AS_BAKED }));
        rig.has_new_cut()[middle]
    };
    assert!(!is_lit(0.05), "it still lies there");
    assert!(is_lit(1.5), "negative control");

    let slid = posed(Pose { translate: Vec3::X * 1.3, ..Pose::AS_BAKED });
    let posed_bake = baked_so(&as_baked, &slid, white());
    let of_the_bake = Dataset { scene: posed_bake.scene.clone(), ..as_baked.clone() };
    let [truth, dark] = [&posed_bake, &of_the_bake].map(|dataset| picture(dataset, |_| ()));
    let preview = picture(&as_baked, |look| look.poses = slid);
    let view = from_above(48);
    let footprint = |pixel: &usize| {
        let at = glam::Vec2::new((pixel % 48) as f32 + 0.5, (pixel / 48) as f32 + 0.5);
        let direction = view.camera.direction_through(at, view.size);
        is_under(&(view.camera.eye - direction * view.camera.eye.y / direction.y))
    };
    let footprint: Vec<usize> = (0..48 * 48).filter(footprint).collect();
    let mean = footprint.iter().map(|&i| truth.pixels[i].y).sum::<f32>() / footprint.len() as f32;
    let largest = |image: &Image| {
        let errors = footprint.iter().map(|&i| (image.pixels[i] - truth.pixels[i]).abs().max_element());
        errors.fold(0.0, f32::max) / mean
    };
    assert!(footprint.len() > 50 && largest(&preview) < 0.15, "{} {}", footprint.len(), largest(&preview));
    assert!(largest(&dark) > 0.5, "negative control, the cuts of the bake: {}", largest(&dark));
}

#[test]
fn far_places_of_a_ground_keep_their_cuts() {
    let mut lying = blocked(white(), 8);
    let blocker = lying.scene.mesh.positions.len() - 8;
    lying.scene.mesh.positions[blocker..].iter_mut().for_each(|position| position.y -= 0.997);
    lapidary_core::ground::add_ground(&mut lying.scene);
    let baked = Baked::from(Dataset { scene: lying.scene.clone(), ..dataset(lying.scene.mesh.clone(), white()) });
    let mut rig = under_the_sky(&baked);
    rig.set_poses(&baked, &posed(Pose { translate: Vec3::X * 1.3, ..Pose::AS_BAKED }));
    let places = lying.scene.mesh.positions.iter().map(|position| position.length());
    let renewed = places.clone().zip(rig.has_new_cut()).filter(|(_, is_new)| **is_new).map(|(place, _)| place);
    let [farthest, all] = [renewed.fold(0.0, f32::max), places.fold(0.0, f32::max)];
    assert!(farthest > 0.0 && farthest < 2.0 && all > 100.0, "{farthest} of {all}");
}

#[test]
fn what_moved_is_lit_by_its_own_bins_glossy_too() {
    for parameters in [Parameters::from(white()), glossy(0.4).into()] {
        let mut as_baked = blocked(parameters.clone(), 8);
        as_baked.scene.materials[0].model = BrdfModel::Ggx;
        let poses = posed(Pose {
            translate: Vec3::new(0.2, 0.3, 0.0),
            rotate_degrees: Vec3::Z * 70.0,
            scale: 1.5,
            ..Pose::AS_BAKED
        });
        let view = |look: &mut Look| look.view = from_the_side(48);
        let truth = picture(&baked_so(&as_baked, &poses, parameters), view);
        let preview = picture(&as_baked, |look| {
            view(look);
            look.poses = poses.clone();
        });
        let (near, dark) = (rel_rmse(&preview, &truth), rel_rmse(&Image::filled([48, 48], Vec3::ZERO), &truth));
        assert!(near < 0.12 && dark > 0.9, "{near}, {dark}");
    }
}

/// A rig of diffuse surfaces in place of the scene's.
fn with_diffuse_ratio(as_baked: &Dataset, look: &Look) -> Image {
    let baked = Baked::from(as_baked.clone());
    let mut rig = under_the_sky(&Baked::from(blocked(white(), 24)));
    rig.set_poses(&baked, &look.poses);
    let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked).unwrap();
    scene.set_detail(ImplicitDetail::OF_A_DRAG);
    scene.light(look).unwrap();
    let local = LocalLighting { posed: Some(rig.light(0, false).into()), ..scene.local().unwrap().clone() };
    scene.backend().set_local_lighting(&local).unwrap();
    scene.show_whole(look).unwrap().image
}

#[test]
fn the_reflection_in_a_glossy_floor_follows_what_moved() {
    // Its alpha is the square of the roughness.
    let floor = glossy(0.2_f32.sqrt());
    let mut as_baked = blocked(floor, 24);
    as_baked.scene.materials[0].model = BrdfModel::Ggx;
    let mut look = Look::under_environment(&as_baked.scene, from_the_side(48), sky());
    look.poses = posed(Pose { translate: Vec3::new(0.6, -0.5, -0.4), scale: 1.3, ..Pose::AS_BAKED });
    let truth = picture(&baked_so(&as_baked, &look.poses, floor), |seen| seen.view = look.view.clone());
    let preview = picture(&as_baked, |seen| *seen = look.clone());
    let (near, diffuse) = (rel_rmse(&preview, &truth), rel_rmse(&with_diffuse_ratio(&as_baked, &look), &truth));
    println!("glossy: {near}, by the ratio of diffuse light {diffuse}");
    assert!(near < 0.10 && diffuse > 1.5 * near, "{near}, negative control {diffuse}: the ratio of diffuse light");
}

#[test]
fn what_a_posed_surface_reflects_follows_the_eye_at_rest() {
    let mut as_baked = blocked(glossy(0.5), 8);
    as_baked.scene.materials[0].model = BrdfModel::Ggx;
    let mut look = Look::under_environment(&as_baked.scene, from_the_side(24), sky());
    look.poses = posed(Pose { translate: Vec3::X * 0.6, ..Pose::AS_BAKED });
    let mut elsewhere = look.clone();
    elsewhere.view.camera.eye = Vec3::new(-2.0, 1.5, -2.5);
    let begin = || LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), as_baked.clone().into()).unwrap();
    let posed_light = |scene: &LitScene| scene.local().unwrap().posed.as_ref().unwrap().known().clone();
    let [here, there] = [&look, &elsewhere].map(|look| {
        let mut scene = begin();
        let picture = scene.show_whole(look).unwrap().image;
        (posed_light(&scene), picture)
    });
    assert!(here.0 != there.0, "negative control: another eye");
    let mut scene = begin();
    assert!(scene.show_whole(&look).unwrap().image == here.1 && !scene.is_coarse());
    scene.light_soon(&elsewhere).unwrap();
    assert!(posed_light(&scene) == here.0, "a drag of the camera need not wait");
    assert_eq!(scene.detail(), Some(ImplicitDetail::FINEST));
    assert!(scene.is_coarse() && scene.refine(&elsewhere).unwrap() == Refined::Light && !scene.is_coarse());
    assert!(posed_light(&scene) == there.0 && scene.show_whole(&elsewhere).unwrap().image == there.1);
    let mut diffuse = LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), blocked(white(), 8).into()).unwrap();
    look.appearance = crate::Appearance::of(&diffuse.baked().dataset.scene);
    diffuse.show_whole(&look).unwrap();
    diffuse.light_soon(&Look { view: elsewhere.view.clone(), ..look }).unwrap();
    assert!(!diffuse.is_coarse(), "nothing is glossy");
}

#[test]
fn dark_gloss_beside_white_paint_does_not_brighten_it() {
    let [white, black] = [0.9, 0.0].map(|base| GgxParameters { base_color: Vec3::splat(base), ..glossy(0.5) });
    let tiled = |dataset: &mut Dataset| {
        let scene = &mut dataset.scene;
        scene.materials[0].model = BrdfModel::Ggx;
        scene
            .materials
            .push(lapidary_core::material::Material { parameters: black.into(), ..scene.materials[0].clone() });
        let blocker = scene.mesh.triangles.len() - 4;
        (0..blocker).for_each(|triangle| scene.mesh.triangle_material[triangle] = (triangle as u32 / 8) % 2);
    };
    let mut as_baked = blocked(white, 24);
    tiled(&mut as_baked);
    let mut look = Look::under_environment(&as_baked.scene, from_the_side(48), sky());
    look.view.camera.eye = Vec3::new(0.0, 0.7, 4.0);
    look.poses = posed(Pose { translate: Vec3::new(0.6, -0.5, -0.4), scale: 1.3, ..Pose::AS_BAKED });
    let mut posed_bake = baked_so(&as_baked, &look.poses, white);
    posed_bake.scene.materials = as_baked.scene.materials.clone();
    let truth = picture(&posed_bake, |seen| *seen = Look { poses: Poses::default(), ..look.clone() });
    let preview = picture(&as_baked, |seen| *seen = look.clone());
    let (near, before) = (
        rel_rmse(&preview, &truth),
        rel_rmse(&picture(&as_baked, |seen| *seen = Look { poses: Poses::default(), ..look.clone() }), &truth),
    );
    println!("tiles: {near}, as baked {before}");
    assert!(near < 0.10 && before > 2.5 * near, "{near}, negative control {before}");
}

#[test]
fn where_nothing_changed_the_ratio_is_one_and_no_bounce_is_added_to_the_bit() {
    let baked = Baked::from(blocked(white(), 8));
    let mut rig = under_the_sky(&baked);
    rig.set_lights(&[point_light(Vec3::new(1.0, 2.0, 0.0), 5.0)]);
    let as_it_is = rig.light(2, false).known().clone();
    let all = |sides: &Sides, value| sides.front.iter().chain(&sides.back).all(|found| *found == value);
    assert!(all(&as_it_is.growth, Vec3::ZERO) && all(&as_it_is.bounce, Vec3::ZERO));
    let poses = posed(Pose { translate: Vec3::X, ..Pose::AS_BAKED });
    rig.set_poses(&baked, &poses);
    let changed = rig.light(2, false).known().clone();
    assert!(!all(&changed.growth, Vec3::ZERO) && !all(&changed.bounce, Vec3::ZERO), "negative control");
    assert!(changed.growth.front.iter().all(|growth| growth.abs().max_element() <= MOST_GROWTH - 1.0));
}

#[test]
fn a_drag_gives_the_bits_of_its_last_pose() {
    let baked = Baked::from(blocked(white(), 8));
    let shown = |rig: &mut Edited<PoseRig>, poses: &Poses| {
        rig.set_poses(&baked, poses);
        let scene = rig.situation.scene.clone();
        let cuts = rig.with_cuts(&scene).0.dataset.cuts.clone();
        let height = baked.dataset.tree.height();
        let cuts: Vec<_> = (0..cuts.len() as u32).map(|vertex| cuts.cut(height, vertex).to_vec()).collect();
        (cuts, rig.light(2, false).known().clone())
    };
    let at = |x: f32| posed(Pose { translate: Vec3::X * x, ..Pose::AS_BAKED });
    let mut both = at(0.4);
    both.set(0, Pose { translate: Vec3::Y * -0.1, ..Pose::AS_BAKED });
    let mut dragged = under_the_sky(&baked);
    let mut last = None;
    for poses in [at(0.1), at(0.9), both.clone(), at(0.4), at(0.3)] {
        let now = shown(&mut dragged, &poses);
        assert!(now == shown(&mut under_the_sky(&baked), &poses));
        assert!(last.as_ref() != Some(&now), "negative control: another pose");
        last = Some(now);
    }
}

#[test]
fn an_object_without_triangles_is_posed_as_nothing() {
    let mut as_baked = blocked(white(), 8);
    as_baked.scene.objects.push(Object { name: "empty".into() });
    let mut poses = Poses::default();
    poses.set(BLOCKER + 1, Pose { translate: Vec3::X, ..Pose::AS_BAKED });
    let preview = picture(&as_baked, |look| look.poses = poses);
    assert!(preview == picture(&as_baked, |_| ()));
}

#[test]
fn a_floor_bounces_its_light_to_what_moved() {
    let as_baked = blocked(white(), 8);
    let poses = posed(Pose { translate: Vec3::Y * -0.4, ..Pose::AS_BAKED });
    let below = |indirect: bool| {
        picture(&as_baked, |look| {
            look.view.camera.eye = Vec3::new(0.0, 0.05, 1.4);
            look.view.camera.target = Vec3::new(0.0, 0.6, 0.0);
            look.poses = poses.clone();
            (look.components, look.solution) = (Components { indirect, ..Components::ALL }, Solution::Cuts);
        })
    };
    let (with, without) = (crate::test_scenes::mean(&below(true)), crate::test_scenes::mean(&below(false)));
    assert!(with > 1.05 * without, "{with} {without}");
}

#[test]
fn a_vertex_of_two_objects_goes_with_the_first_and_only_then_has_moved() {
    let mut as_baked = blocked(white(), 4);
    let shared = as_baked.scene.mesh.triangles[0][0];
    let last = as_baked.scene.mesh.triangles.len() - 1;
    as_baked.scene.mesh.triangles[last][0] = shared;
    let baked = Baked::from(as_baked);
    let poses = posed(Pose { translate: Vec3::X, ..Pose::AS_BAKED });
    let mut rig = under_the_sky(&baked);
    rig.set_poses(&baked, &poses);
    let now = rig.situation.scene.dataset.clone();
    let place = |of: &Dataset, vertex: u32| of.scene.mesh.positions[vertex as usize];
    let own = now.scene.mesh.triangles[last][1];
    assert_eq!(place(&now, shared), place(&baked.dataset, shared));
    assert!(!rig.has_new_cut()[shared as usize] && rig.has_new_cut()[own as usize], "negative control");
    assert_eq!(now.scene.mesh.owners()[shared as usize], 0);
}

#[test]
fn too_many_objects_are_refused_and_shown_as_they_were_baked() {
    let mut as_baked = blocked(white(), 4);
    as_baked.scene.objects.resize(MOST_OBJECTS + 1, Object { name: "one of many".into() });
    let mut look = Look::under_environment(&as_baked.scene, from_above(16), sky());
    let mut scene = LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), as_baked.into()).unwrap();
    let before = scene.show_whole(&look).unwrap().image;
    let still = std::mem::replace(&mut look.poses, posed(Pose { translate: Vec3::X, ..Pose::AS_BAKED }));
    scene.prepare_to_drag();
    assert!(!scene.is_prepared_to_drag());
    let refusal = scene.show_whole(&look).unwrap_err().to_string();
    assert!(refusal.contains("65537 objects, and at most 65536") && refusal.contains("join"), "{refusal}");
    look.poses = still;
    assert!(scene.show_whole(&look).unwrap().image == before);
}
