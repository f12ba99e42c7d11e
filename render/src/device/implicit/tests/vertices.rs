//! Light of vertices on the device against that of the cores.

use super::*;

/// Scenes with diffuse and glossy surfaces, sheets that are seen from both sides, and a block that lay near the floor.
fn scenes_of_vertices() -> [Baked; 3] {
    let mut shiny = blocked(glossy(0.5), 8);
    shiny.scene.materials[0].model = BrdfModel::Ggx;
    let mut sheets = blocked(white(), 8);
    sheets.two_sided.fill(true);
    let mut low = blocked(white(), 8);
    let blocker = low.scene.mesh.positions.len() - 8;
    low.scene.mesh.positions[blocker..].iter_mut().for_each(|position| position.y -= 0.9);
    // Some of the floor below it is covered, and stays dark.
    low.vertex_valid[38..43].fill(false);
    [shiny, sheets, low].map(Baked::from)
}

/// A rig under a sky and a lamp.
fn lit_rig(compute: &Compute, baked: &Baked) -> Edited<PoseRig> {
    let mut rig = Edited::new(baked, PoseRig::new(baked, compute, ImplicitDetail::OF_A_DRAG));
    rig.set_environment(Some(Renderer::new(baked.clone()).lighting(&sky(), 64)));
    rig.set_lights(&[point_light(Vec3::new(1.0, 2.0, 0.0), 5.0)]);
    rig.situation.eye = Vec3::new(0.0, 1.5, 3.5);
    rig
}

#[test]
fn vertices_are_lit_on_the_device_as_on_the_cores() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let computes = [Compute::Device(device.clone()), Compute::Cores];
    // The other one is below the floor, whose back it darkens.
    let poses = [Vec3::X * 1.4, Vec3::new(0.3, -1.6, 0.0)].map(|translate| posed(Pose { translate, ..Pose::AS_BAKED }));
    let mut is_there = [false; 5];
    for baked in scenes_of_vertices() {
        compile_gloss(&device, &baked);
        let [found, expected] = computes.each_ref().map(|compute| {
            let mut rig = lit_rig(compute, &baked);
            poses.each_ref().map(|poses| {
                rig.set_poses(&baked, poses);
                rig.light(2, true)
            })
        });
        for (found, expected) in found.iter().zip(&expected) {
            assert!(matches!((found, expected), (PosedLighting::OnDevice(_), PosedLighting::OnCores(_))));
            let (found, expected) = (found.known(), expected.known());
            assert!(found.is_moved == expected.is_moved);
            let pairs = values_of(found).into_iter().zip(values_of(expected));
            let differ = pairs.map(|(found, expected)| farthest(&found, &expected)).fold(0.0, f32::max);
            println!("light of vertices differs by {differ}");
            // The light of leaves differs by at most 1e-5 of its mean, which is below 10.
            assert!(differ < 1e-4, "{differ}");
            let has_light = |of: &[Vec3]| of.iter().any(|light| *light != Vec3::ZERO);
            let PosedLight { growth, uncovered, bounce, .. } = expected;
            for (is_there, side) in
                is_there.iter_mut().zip([&growth.front, &growth.back, &bounce.front, &bounce.back, &uncovered.front])
            {
                *is_there |= has_light(side);
            }
        }
        let [one, other] = found.each_ref().map(|light| values_of(light.known()));
        assert!(farthest(&one[0], &other[0]) > 0.1 && farthest(&one[2], &other[2]) > 0.01, "negative control: poses");
    }
    assert!(is_there == [true; 5], "scenes have all of it: {is_there:?}");
}

#[test]
fn light_that_stays_has_its_bits_on_the_device() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    for baked in scenes_of_vertices() {
        compile_gloss(&device, &baked);
        let mut rig = lit_rig(&Compute::Device(device.clone()), &baked);
        let mut changes = |poses: &Poses| {
            rig.set_poses(&baked, poses);
            let light = rig.light(2, true);
            assert!(matches!(light, PosedLighting::OnDevice(_)));
            values_of(light.known()).map(|values| values.iter().filter(|value| **value != Vec3::ZERO).count())
        };
        let moved = changes(&posed(Pose { translate: Vec3::X * 0.4, ..Pose::AS_BAKED }));
        assert!(moved[0] > 0 && moved[2] > 0, "negative control: {moved:?}");
        assert_eq!(changes(&Poses::default()), [0; 3], "back again");
    }
}
