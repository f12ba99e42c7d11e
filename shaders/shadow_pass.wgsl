// Depth of all triangles from a light. Which view it is comes as the number of the instance.

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) layer: u32) -> @builtin(position) vec4<f32> {
    let triangle = index / 3u;
    let corners = triangles[triangle].vertices;
    let world = vertices[corners[index - 3u * triangle]].position;
    let view = shadow_views[layer];
    return shadow_clip(view, shadow_local(view, world - view.origin));
}

@fragment
fn fragment() {}
