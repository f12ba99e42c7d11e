// Depth of all triangles from a light. The instance number selects the view. The share of a thin surface's texels with a depth is
// its opacity.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) triangle: u32,
    @location(1) @interpolate(flat, either) layer: u32,
    // Both sets of texture coordinates.
    @location(2) uvs: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) layer: u32) -> Corner {
    let triangle = index / 3u;
    let corners = triangles[triangle].vertices;
    let corner = vertices[corners[index - 3u * triangle]];
    let view = shadow_views[layer];
    let clip = shadow_clip(view, shadow_local(view, corner.position - view.origin));
    return Corner(clip, triangle, layer, vec4(corner.uv, corner.second_uv));
}

@fragment
fn fragment(corner: Corner) {
    if lets_through(corner.triangle, corner.uvs, vec2<u32>(corner.position.xy), corner.layer) {
        discard;
    }
}
