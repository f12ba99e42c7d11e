use super::*;
use lapidary_core::camera::Camera;

fn floor(position: Vec3) -> Guide {
    let material = 1;
    Guide { material, position, smooth_normal: Vec3::Y, normal: Vec3::Y, albedo: Vec3::ONE, ..Guide::unlit(material) }
}

/// A floor seen from above in four by four pixels, and the points at its pixels' centers.
fn seen_from_above() -> (Projection, Vec<Past>) {
    let camera = Camera { up: Vec3::NEG_Z, ..Camera::look_at(2.0 * Vec3::Y, Vec3::ZERO, 90.0) };
    let point = |i: u32| Vec3::new((i % 4) as f32 - 1.5, 0.0, (i / 4) as f32 - 1.5);
    let past = |i| Past { material: 1, position: point(i), normal: Vec3::Y };
    (camera.projection([4, 4]), (0..16).map(past).collect())
}

#[test]
fn a_point_is_found_between_the_pixels_that_show_its_surface() {
    let (projection, mut points) = seen_from_above();
    let values: Vec<Vec3> = points.iter().map(|past| past.position).collect();
    let tell = |points: &[Past], guide: &Guide| Found::of(guide, &projection, points, [4, 4])?.mean(&values);
    let place = Vec3::new(0.2, 0.0, -0.6);
    let told = tell(&points, &floor(place)).unwrap();
    assert!((told - place).length() < 1e-5, "linear values are interpolated: {told}");
    assert!(tell(&points, &floor(Vec3::new(9.0, 0.0, 0.0))).is_none(), "beyond the picture");
    assert!(tell(&points, &floor(3.0 * Vec3::Y)).is_none(), "behind the eye");
    assert!(tell(&points, &Guide { material: 2, ..floor(place) }).is_none());
    for height in [2.0, 2.0 - 1e-7, 2.0 - 1e-30] {
        let beside_the_eye = Vec3::new(1.0, height, 0.0);
        assert!(tell(&points, &floor(beside_the_eye)).is_none(), "beyond all integers");
    }
    points.iter_mut().for_each(|past| past.position.y += 1.1);
    assert!(tell(&points, &floor(place)).is_none(), "hidden by another floor");
}

#[test]
fn detail_is_trusted_as_far_as_the_pictures_agree() {
    let trusted = |now: [f32; 2]| {
        let mut detail = Detail::of(Vec3::splat(3.0));
        for (before, now) in [1.0, 2.0].into_iter().zip(now) {
            detail.add(Vec3::splat(before), Vec3::splat(now), 0.5);
        }
        detail.trusted().x
    };
    assert_eq!(trusted([1.0, 2.0]), 1.5, "all of what lies over the mean");
    assert_eq!(trusted([2.0, 4.0]), 0.75, "twice as bright: half of it");
    assert_eq!((trusted([0.0, 0.0]), Detail::of(Vec3::ONE).trusted().x), (0.0, 0.0));
}
