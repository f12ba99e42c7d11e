// The 4 x 4 cells of a sun, each with a ray. Twin of `cells` in render/src/shade/direct.rs and of core/src/lights/disc.rs.

const SUN_SIDE: u32 = 4u;
const RAYS_OF_SUN: u32 = 16u;
const ALL_RAYS: u32 = 0xffffu;

// Offset of a pixel's rays in their cells. Twin of `pixel_shift`.
fn shift_of_rays(pixel: vec2<u32>) -> vec2<f32> {
    return ray_shift(pixel, (frame.picture_sample % 4096u) * RAYS_OF_SUN);
}

// Where a ray goes in the unit square.
fn place_of_ray(ray: u32, shift: vec2<f32>) -> vec2<f32> {
    let corner = vec2<f32>(vec2(ray % SUN_SIDE, ray / SUN_SIDE));
    return (corner + fract(shift + fract(STEP * f32(ray)))) / f32(SUN_SIDE);
}

// The direction at a place of the unit square, uniform per solid angle of a disc of directions.
fn direction_in(axis: vec3<f32>, right: vec3<f32>, up: vec3<f32>, height: f32, u: vec2<f32>) -> vec3<f32> {
    let at = concentric(2.0 * u - 1.0);
    let down = dot(at, at) * height;
    let spread = sqrt(max(height * (2.0 - down), 0.0));
    return (right * at.x + up * at.y) * spread + axis * (1.0 - down);
}
