// Edges of triangles drawn over the picture, by the distance in pixels from the sample to the nearest edge.

// Half the width of a line in pixels.
const WIRE_HALF_WIDTH: f32 = 0.6;

// How much of the sample a line covers, 0 to 1.
fn wireframe_coverage(pixel: vec2<u32>, corners: vec3<u32>) -> f32 {
    let a = project(vertices[corners.x].position);
    let b = project(vertices[corners.y].position);
    let c = project(vertices[corners.z].position);
    let p = vec2<f32>(pixel) + frame.pixel_offset;
    let d = min(edge_distance(p, a, b), min(edge_distance(p, b, c), edge_distance(p, c, a)));
    return saturate(WIRE_HALF_WIDTH + 0.5 - d);
}

// Position in pixels, and 1 if it lies before the camera.
fn project(world: vec3<f32>) -> vec3<f32> {
    let view = (world - frame.eye) * frame.world_from_view;
    let size = vec2<f32>(frame.size);
    let scale = 0.5 * size.y / (frame.tan_half_fov * -view.z);
    return vec3(0.5 * size + vec2(view.x, -view.y) * scale, select(0.0, 1.0, view.z < 0.0));
}

// Distance to the line through both ends; far where one of them lies behind the camera.
fn edge_distance(p: vec2<f32>, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let along = b.xy - a.xy;
    let across = abs(along.x * (p.y - a.y) - along.y * (p.x - a.x)) / max(length(along), 1e-6);
    return select(1e6, across, a.z * b.z > 0.0);
}
