// The surface at a pixel's first sample, as input of a sketch's filter. Twin of `Guide` in render/src/sketch.rs.

// Least albedo that radiance is divided by.
const LEAST_ALBEDO: f32 = 1.0 / 512.0;
// Least share of a filter's weight that must fit.
const LEAST_SHARE: f32 = 1.0 / 16.0;

struct Guide {
    material: u32,
    position: vec3<f32>,
    smooth_normal: vec3<f32>,
    normal: vec3<f32>,
    albedo: vec3<f32>,
    // Divisor of values: the albedo, or 1 for values that are not radiance.
    divisor: vec3<f32>,
}

fn guide(g: vec4<u32>, pixel: vec2<u32>) -> Guide {
    let point = surface_point(g, pixel, ray(pixel).direction);
    let share = max(albedo_of(point.brdf), vec3(LEAST_ALBEDO));
    let divisor = select(vec3(1.0), share, frame.view_mode == VIEW_SHADED);
    let material = triangles[g.x - 1u].material & ~TWO_SIDED;
    return Guide(material, point.position, point.smooth_normal, point.world_from_local[2], share, divisor);
}

// Twin of `Guide::fit_surface`.
fn fit_surface(here: Guide, material: u32, position: vec3<f32>, normal: vec3<f32>, reach: f32) -> f32 {
    if material != here.material {
        return 0.0;
    }
    let plane = 1.0 - abs(dot(here.smooth_normal, position - here.position)) / reach;
    let turned = 2.0 * dot(here.normal, normal) - 1.0;
    return select(0.0, plane * turned, plane > 0.0 && turned > 0.0);
}
