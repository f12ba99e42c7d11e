//! Every direction of a light's illumination lies on one of its views, inside the border.

use super::*;
use lapidary_core::sphere::fibonacci_directions;

const SETTINGS: ShadowViewSettings = ShadowViewSettings { near: 1e-4, size: 64, grid: 2 };

fn light(emission: Emission) -> Light {
    let (position, target) = (Vec3::new(0.3, 2.0, -0.4), Vec3::new(1.0, 0.5, 0.2));
    Light { emission, position, target, ..Default::default() }
}

/// Position on the map in texels, and depth; as `shadow_clip` has it.
fn projected(view: &ShadowView, world: Vec3) -> (Vec2, f32) {
    let v = world - Vec3::from(view.origin);
    let [x, y, z] = [view.right, view.up, view.forward].map(|axis| Vec3::from(axis).dot(v));
    let ndc = Vec2::new(x / view.half_width, y / view.half_height) / z;
    ((0.5 + 0.5 * ndc) * SETTINGS.size as f32, view.depth_scale / z)
}

/// The view that the shader chooses for a receiver.
fn chosen(views: &[ShadowView], world: Vec3) -> &ShadowView {
    let along = |v: &&ShadowView| Vec3::from(v.forward).dot(world - Vec3::from(v.origin));
    views.iter().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap()
}

fn is_shown(views: &[ShadowView], world: Vec3) -> bool {
    let (at, depth) = projected(chosen(views, world), world);
    let inside = BORDER as f32 - 0.01..SETTINGS.size as f32 - BORDER as f32 + 0.01;
    depth > 0.0 && depth < 1.0 && inside.contains(&at.x) && inside.contains(&at.y)
}

#[test]
fn all_that_a_light_reaches_is_shown_inside_the_border() {
    let spot = |cone_degrees| Emission::Spot { cone_degrees, penumbra_degrees: 0.0 };
    let rectangle = Emission::Rectangle { width: 1.0, height: 0.5 };
    for (emission, cone, count) in [
        (Emission::Point, 180.0_f32, 6),
        (spot(20.0), 20.0, 1),
        (spot(75.0), 75.0, 1),
        (spot(90.0), 90.0, 5),
        (rectangle, 90.0, 20),
    ] {
        let light = light(emission);
        let views = views(&light, &SETTINGS);
        assert_eq!((views.len(), view_count(&light, SETTINGS.grid)), (count, count as u32));
        for point in views.chunks(views_per_point(&light) as usize) {
            let origin = Vec3::from(point[0].origin);
            let inside = |d: &Vec3| d.dot(light.forward().unwrap()) > cone.to_radians().cos();
            for d in fibonacci_directions(500).into_iter().filter(inside) {
                assert!(is_shown(point, origin + 3.0 * d), "{emission:?} {d}");
            }
            let beyond = |d: &Vec3| !inside(d) && cone < 80.0;
            let shown = |d: Vec3| is_shown(point, origin + 3.0 * d);
            assert!(fibonacci_directions(500).into_iter().filter(beyond).filter(|d| shown(*d)).count() < 60);
        }
    }
}

#[test]
fn axes_are_right_handed_and_unit() {
    for view in views(&light(Emission::Point), &SETTINGS) {
        let [right, up, forward] = [view.right, view.up, view.forward].map(Vec3::from);
        assert!((forward.cross(up) - right).length() < 1e-5 && (right.cross(forward) - up).length() < 1e-5);
    }
}
