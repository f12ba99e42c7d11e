// Glossy leaves of a forest, in place of materials.wgsl: each has the values of its parameters after all maps.

struct GlossyLeaf {
    // Columns of the shading frame, in the world.
    tangent: vec3<f32>,
    // Its number among the leaves.
    leaf: u32,
    bitangent: vec3<f32>,
    model: u32,
    normal: vec3<f32>,
    // The value of its first parameter.
    first: u32,
}

// What no model reads without maps.
struct SurfaceAttributes {
    nothing: u32,
}

@group(1) @binding(1) var<uniform> tables: Tables;
// The glossy leaves. Models know them by this name.
@group(1) @binding(2) var<storage, read> materials: array<GlossyLeaf>;
// Of parameters, in the order of the list of a model.
@group(1) @binding(3) var<storage, read> values: array<vec4<f32>>;

fn plain_color(leaf: u32, index: u32, range: vec2<f32>) -> vec3<f32> {
    return clamp(values[materials[leaf].first + index].xyz, vec3(range.x), vec3(range.y));
}

fn plain_number(leaf: u32, index: u32, range: vec2<f32>) -> f32 {
    return clamp(values[materials[leaf].first + index].x, range.x, range.y);
}
