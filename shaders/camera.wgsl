// The pinhole camera of a frame: from pixels to rays, and from points to pixels. Twin of `Projection` in core/src/camera.rs.

struct Ray {
    origin: vec3<f32>,
    // Of unit length.
    direction: vec3<f32>,
}

// The middle of a lens, as a sample of it: all that a pinhole has.
const PINHOLE: vec2<f32> = vec2<f32>(0.0);

// The ray through the sample of a pixel from a sample of the lens. A lens with an aperture would have its place here.
fn ray(pixel: vec2<u32>, lens: vec2<f32>) -> Ray {
    let size = vec2<f32>(frame.size);
    let ndc = (2.0 * (vec2<f32>(pixel) + frame.pixel_offset) - size) / size.y;
    let view = vec3(ndc.x * frame.tan_half_fov, -ndc.y * frame.tan_half_fov, -1.0);
    return Ray(frame.eye, normalize(frame.world_from_view * view));
}

// Pixel coordinates times depth, and depth: homogeneous, so that points behind the eye do no harm.
fn project(world: vec3<f32>) -> vec3<f32> {
    let p = (world - frame.eye) * frame.world_from_view;
    let center = 0.5 * vec2<f32>(frame.size);
    let focal = center.y / frame.tan_half_fov;
    return vec3(center.x * -p.z + focal * p.x, center.y * -p.z - focal * p.y, -p.z);
}

// Meters that a pixel spans at a depth.
fn pixel_span(depth: f32) -> f32 {
    return depth * 2.0 * frame.tan_half_fov / f32(frame.size.y);
}

// Where a point in the space of a camera, before its eye, is in a picture with this center and distance from the eye, in pixels.
fn pixel_of_view(view: vec3<f32>, center: vec2<f32>, focal: f32) -> vec2<f32> {
    return center + focal / -view.z * vec2(view.x, -view.y);
}
