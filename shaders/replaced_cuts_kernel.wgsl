// Gives vertices the cuts that were made on the device.

@group(1) @binding(0) var<storage, read> cut_vertices: array<CutVertex>;
// First texel of each cut.
@group(1) @binding(1) var<storage, read> starts: array<u32>;
// The number of nodes of each cut, from the second word on.
@group(1) @binding(2) var<storage, read> counts: array<u32>;
// `Vertex` of scene.wgsl, as five vectors each: the first ends with the first texel of its cut, the second with its number of nodes.
@group(1) @binding(3) var<storage, read_write> vertices: array<vec4<u32>>;

@compute @workgroup_size(64)
fn replace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = 64u * workgroup_number(group) + lane;
    if number < arrayLength(&cut_vertices) {
        let vertex = 5u * (cut_vertices[number].number & ~MOVED);
        vertices[vertex].w = starts[number];
        vertices[vertex + 1u].w = counts[number + 1u];
    }
}
