// Edges of triangles drawn over the picture, by the distance in pixels from the sample to the nearest edge.
// Twin of render/src/shade/wireframe.rs.

const LINE_WIDTH: f32 = 1.0;
const LINE_FADE: f32 = 1.0;

// Line coverage of the sample, 0 to 1.
fn wireframe_coverage(pixel: vec2<u32>, corners: vec3<u32>) -> f32 {
    let position = vec2<f32>(pixel) + frame.pixel_offset;
    let a = relative(project(vertices[corners.x].position), position);
    let b = relative(project(vertices[corners.y].position), position);
    let c = relative(project(vertices[corners.z].position), position);
    let distance = min(line_distance(a, b), min(line_distance(b, c), line_distance(c, a)));
    return saturate((0.5 * LINE_WIDTH + LINE_FADE - distance) / LINE_FADE);
}

fn relative(projected: vec3<f32>, position: vec2<f32>) -> vec3<f32> {
    return vec3(projected.xy - position * projected.z, projected.z);
}

// Distance from the origin to the line through two homogeneous points.
fn line_distance(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let line = cross(a, b);
    return abs(line.z) / max(length(line.xy), 1e-20);
}
