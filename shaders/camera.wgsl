// The camera of a frame: from pixels to rays, and from points to pixels. Each sample of a lens sees through a pinhole. Twin of
// `Projection` in core/src/camera.rs.

struct Ray {
    origin: vec3<f32>,
    // Of unit length.
    direction: vec3<f32>,
}

// The ray through the sample of a pixel.
fn ray(pixel: vec2<u32>) -> Ray {
    let ndc = (2.0 * (vec2<f32>(pixel) + frame.pixel_offset) - 2.0 * frame.center) / f32(frame.size.y);
    let view = vec3(ndc.x * frame.tan_half_fov, -ndc.y * frame.tan_half_fov, -1.0);
    return Ray(frame.eye, normalize(frame.world_from_view * view));
}

// Pixel coordinates times depth, and depth: homogeneous, so that points behind the eye do no harm.
fn project(world: vec3<f32>) -> vec3<f32> {
    let p = (world - frame.eye) * frame.world_from_view;
    let focal = 0.5 * f32(frame.size.y) / frame.tan_half_fov;
    return vec3(frame.center.x * -p.z + focal * p.x, frame.center.y * -p.z - focal * p.y, -p.z);
}

// Meters that a pixel spans at a depth.
fn pixel_span(depth: f32) -> f32 {
    return depth * 2.0 * frame.tan_half_fov / f32(frame.size.y);
}

// Where a point in the space of a camera, before its eye, is in a picture with this center and distance from the eye, in pixels.
fn pixel_of_view(view: vec3<f32>, center: vec2<f32>, focal: f32) -> vec2<f32> {
    return center + focal / -view.z * vec2(view.x, -view.y);
}
