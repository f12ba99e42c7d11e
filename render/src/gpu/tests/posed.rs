//! Pictures of posed objects on the GPU, against those of the CPU.

use super::twin::{another, backend};
use crate::{
    Backend, Baked, Components, CpuBackend, Illumination, LitScene, LocalLighting, Look, Solution,
    device::Compute,
    gpu::GpuBackend,
    light::implicit::{
        PosedLighting,
        tests::{blocked, posed, sky},
    },
    test_scenes::{from_above, linked_floor_and_wall, point_light, rel_rmse, white},
};
use glam::Vec3;
use lapidary_core::{
    image::Image,
    scene::pose::{Pose, Poses},
};

fn shown(backend: Box<dyn Backend>, baked: &Baked, looks: &[Look]) -> Vec<Image> {
    let mut scene = LitScene::<dyn Backend>::new(backend, baked.clone()).unwrap();
    looks.iter().map(|look| scene.show_whole(look).unwrap().image).collect()
}

fn on_both(gpu: GpuBackend, baked: &Baked, looks: &[Look]) -> [Vec<Image>; 2] {
    [Box::new(CpuBackend::new()) as Box<dyn Backend>, Box::new(gpu)].map(|backend| shown(backend, baked, looks))
}

#[test]
fn posed_objects_look_the_same_on_both_renderers_and_as_baked_when_they_are_back() {
    let Some((_one, gpu)) = backend() else { return };
    let lamp = point_light(Vec3::new(1.5, 2.5, 0.5), 6.0);
    let as_baked = Look {
        lights: [lamp].into(),
        components: Components { environment: true, direct: true, indirect: false },
        ..Look::under_environment(&blocked(white(), 12).scene, from_above(48), sky())
    };
    let pose = Pose {
        translate: Vec3::new(0.6, -0.3, 0.3),
        rotate_degrees: Vec3::new(0.0, 40.0, 15.0),
        scale: 1.1,
        ..Pose::AS_BAKED
    };
    let is_posed = Look { poses: posed(pose), ..as_baked.clone() };
    let unlit = Look { components: Components { environment: false, ..as_baked.components }, ..is_posed.clone() };
    let looks = [as_baked.clone(), is_posed, unlit, as_baked];
    let [cpu, gpu] = on_both(gpu, &blocked(white(), 12).into(), &looks);
    assert!(gpu[0] == gpu[3] && cpu[0] == cpu[3], "and back");
    // Shadow maps of the lamp have edges of their own.
    let (same, other) = (rel_rmse(&gpu[1], &cpu[1]), rel_rmse(&gpu[0], &cpu[1]));
    assert!(same < 0.05 && other > 5.0 * same, "{same}, negative control {other}");
    let (same, other) = (rel_rmse(&gpu[2], &cpu[2]), rel_rmse(&gpu[1], &cpu[2]));
    assert!(same < 0.05 && other > 5.0 * same, "without the environment: {same}, negative control {other}");
}

#[test]
fn cuts_made_on_the_device_look_as_those_of_the_cores() {
    let Some((_one, gpu)) = backend() else { return };
    let baked = Baked::from(blocked(white(), 12));
    let as_baked = Look {
        components: Components { environment: true, ..Components::NONE },
        ..Look::under_environment(&baked.dataset.scene, from_above(48), sky())
    };
    let at = |translate| Look { poses: posed(Pose { translate, ..Pose::AS_BAKED }), ..as_baked.clone() };
    let turned =
        |look: Look| Look { illumination: Illumination { rotation: 1.0, ..look.illumination.clone() }, ..look };
    let (first, second) = (Vec3::new(0.6, -0.3, 0.3), Vec3::new(-0.5, -0.2, 0.1));
    let mut large = at(second);
    large.poses.set(0, Pose { scale: 1.5, ..Pose::AS_BAKED });
    let looks = [
        at(first),
        at(second),
        large.clone(),
        as_baked.clone(),
        turned(at(second)),
        turned(at(first)),
        large,
        turned(as_baked.clone()),
    ];
    let device = Compute::Device(gpu.device().clone());
    let [on_device, on_cores] = [(gpu, device), (another(), Compute::Cores)].map(|(gpu, compute)| {
        let mut scene = LitScene::<dyn Backend>::new(Box::new(gpu), baked.clone()).unwrap().with_compute(compute);
        looks.iter().map(|look| scene.show_whole(look).unwrap().image).collect::<Vec<Image>>()
    });
    for (step, (device, cores)) in on_device.iter().zip(&on_cores).enumerate() {
        assert!(rel_rmse(device, cores) < 1e-4, "step {step}: {}", rel_rmse(device, cores));
    }
    assert!(on_device[0] != on_device[1] && on_device[1] != on_device[4], "negative control: poses and lights differ");
    let [cpu, _] = on_both(another(), &baked, &looks);
    for (step, (device, cpu)) in on_device.iter().zip(&cpu).enumerate() {
        assert!(rel_rmse(device, cpu) < 0.01, "step {step}: {}", rel_rmse(device, cpu));
    }
}

#[test]
fn light_that_stays_on_the_device_looks_as_where_it_is_uploaded() {
    let Some((_one, gpu)) = backend() else { return };
    let baked = Baked::from(blocked(white(), 12));
    let all = Components { environment: true, indirect: true, ..Components::NONE };
    let look = |components| Look {
        poses: posed(Pose { translate: Vec3::new(0.6, -0.3, 0.3), ..Pose::AS_BAKED }),
        components,
        ..Look::under_environment(&baked.dataset.scene, from_above(24), sky())
    };
    let looks = [all, Components { environment: false, ..all }, Components { indirect: false, ..all }].map(look);
    let device = Compute::Device(gpu.device().clone());
    let mut scene = LitScene::<dyn Backend>::new(Box::new(gpu), baked.clone()).unwrap().with_compute(device);
    let uploaded = looks.each_ref().map(|look| {
        scene.light(look).unwrap();
        let local = scene.local().unwrap().clone();
        let light = local.posed.as_deref().expect("a pose");
        assert!(matches!(light, PosedLighting::OnDevice(_)));
        let known = PosedLighting::OnCores(light.known().clone());
        scene.backend().set_local_lighting(&LocalLighting { posed: Some(known.into()), ..local }).unwrap();
        scene.show_whole(look).unwrap().image
    });
    let copied = looks.each_ref().map(|look| scene.show_whole(look).unwrap().image);
    assert!(copied == uploaded);
    assert!(copied[0] != copied[1] && copied[0] != copied[2], "negative control: other components");
}

#[test]
fn bounced_light_of_vertices_looks_the_same_on_both_renderers() {
    let Some((_one, gpu)) = backend() else { return };
    let baked = Baked::from(linked_floor_and_wall());
    let lit = |intensity: f32, solution| Look {
        lights: [point_light(Vec3::new(-1.0, 1.2, 0.1), intensity)].into(),
        components: Components { indirect: true, ..Components::NONE },
        solution,
        ..Look::under_environment(&baked.dataset.scene, from_above(24), sky())
    };
    let mut slid = Poses::default();
    slid.set(0, Pose { translate: Vec3::X * 0.3, ..Pose::AS_BAKED });
    let looks = [
        lit(3.0, Solution::Even),
        lit(3.3, Solution::Even),
        Look { poses: slid, ..lit(3.0, Solution::Even) },
        lit(3.0, Solution::Cuts),
        lit(3.0, Solution::Even),
    ];
    let [cpu, gpu] = on_both(gpu, &baked, &looks);
    for (cpu, gpu) in cpu.iter().zip(&gpu) {
        assert!(rel_rmse(gpu, cpu) < 1e-4, "{}", rel_rmse(gpu, cpu));
    }
    assert!(gpu[0] == gpu[4] && rel_rmse(&gpu[1], &cpu[0]) > 0.05, "negative control: a brighter lamp");
    assert!(rel_rmse(&gpu[2], &cpu[0]) > 0.05 && rel_rmse(&gpu[3], &cpu[0]) > 0.05, "negative control: others");
}

#[test]
fn a_pose_adds_bounces_where_none_are_baked() {
    let Some((_one, gpu)) = backend() else { return };
    let baked = Baked::from(blocked(white(), 12));
    let look = |indirect| Look {
        poses: posed(Pose { translate: Vec3::Y * -0.4, ..Pose::AS_BAKED }),
        components: Components { indirect, ..Components::ALL },
        ..Look::under_environment(&baked.dataset.scene, from_above(24), sky())
    };
    let [cpu, gpu] = on_both(gpu, &baked, &[look(true), look(false)]);
    let (same, other) = (rel_rmse(&gpu[0], &cpu[0]), rel_rmse(&gpu[1], &cpu[0]));
    assert!(same < 1e-2 && other > 5.0 * same, "{same}, negative control {other}");
}
