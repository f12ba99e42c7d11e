// Deferred pass 1: the visible triangle of each pixel. Corners are fetched by index, so that a triangle's number is known without
// the optional primitive index.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) triangle: u32,
    // Both sets of texture coordinates.
    @location(1) uvs: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = index / 3u;
    let corners = triangles[triangle].vertices;
    let corner = vertices[corners[index - 3u * triangle]];
    return Corner(frame.clip_from_world * vec4(corner.position, 1.0), triangle, vec4(corner.uv, corner.second_uv));
}

@fragment
fn fragment(corner: Corner) -> @location(0) u32 {
    if lets_through(corner.triangle, corner.uvs, vec2<u32>(corner.position.xy), frame.sample) {
        discard;
    }
    return corner.triangle + 1u;
}
