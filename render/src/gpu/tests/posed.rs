//! Pictures of posed objects on the GPU, against those of the CPU.

use super::twin::backend;
use crate::{
    Backend, Components, CpuBackend, LitScene, Look,
    light::implicit::tests::{blocked, posed, sky},
    test_scenes::{from_above, point_light, rel_rmse, white},
};
use glam::Vec3;
use lapidary_core::{image::Image, scene::pose::Pose};

fn shown(backend: Box<dyn Backend>, looks: &[Look]) -> Vec<Image> {
    let baked = blocked(white(), 12).into();
    let mut scene = LitScene::<dyn Backend>::new(backend, baked).unwrap();
    looks.iter().map(|look| scene.show_whole(look).unwrap().image).collect()
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
    let pose = Pose { translate: Vec3::new(0.6, -0.3, 0.3), rotate_degrees: Vec3::new(0.0, 40.0, 15.0), scale: 1.1 };
    let is_posed = Look { poses: posed(pose), ..as_baked.clone() };
    let unlit = Look { components: Components { environment: false, ..as_baked.components }, ..is_posed.clone() };
    let looks = [as_baked.clone(), is_posed, unlit, as_baked];
    let [cpu, gpu] =
        [Box::new(CpuBackend::new()) as Box<dyn Backend>, Box::new(gpu)].map(|backend| shown(backend, &looks));
    assert!(gpu[0] == gpu[3] && cpu[0] == cpu[3], "and back");
    // Shadow maps of the lamp have edges of their own.
    let (same, other) = (rel_rmse(&gpu[1], &cpu[1]), rel_rmse(&gpu[0], &cpu[1]));
    assert!(same < 0.05 && other > 5.0 * same, "{same}, negative control {other}");
    let (same, other) = (rel_rmse(&gpu[2], &cpu[2]), rel_rmse(&gpu[1], &cpu[2]));
    assert!(same < 0.05 && other > 5.0 * same, "without the environment: {same}, negative control {other}");
}
