// Deferred pass 1: which triangle each pixel sees. Corners are fetched by index, so that a triangle's number is known
// without the optional primitive index.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) triangle: u32,
    @location(1) uv: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = index / 3u;
    let corners = triangles[triangle].vertices;
    let corner = vertices[corners[index - 3u * triangle]];
    return Corner(frame.clip_from_world * vec4(corner.position, 1.0), triangle, corner.uv);
}

@fragment
fn fragment(corner: Corner) -> @location(0) u32 {
    if HAS_VEILS {
        let material = triangles[corner.triangle].material & ~TWO_SIDED;
        let pixel = vec2<u32>(corner.position.xy);
        let opacity = material_opacity(material, corner.uv);
        // A threshold may be rounded to 1.
        if opacity < 1.0 && opacity <= threshold(pixel, frame.sample, corner.triangle) {
            discard;
        }
    }
    return corner.triangle + 1u;
}
