// Light of the vertices from that of the leaves beside them, one invocation each: as baked as it is, and in a pose as what it changes.
// Twin of `Open::at_vertices` in render/src/light/implicit/covered.rs and of `PoseRig::light_by_cores` in
// render/src/light/implicit.rs, up to rounding.

// Least open share of the leaves beside a vertex that can give it light.
const LEAST_OPEN: f32 = 0.05;
// Upper limit of the growth of a vertex's light.
const MOST_GROWTH: f32 = 2.0;

// States of a vertex.
const VERTEX_IS_OPEN: u32 = 1u;
const VERTEX_IS_MOVED: u32 = 2u;
const VERTEX_HAS_NEW_CUT: u32 = 4u;

// Planes, as in posed.wgsl.
const POSED_GROWTH: u32 = 0u;
const POSED_BOUNCE: u32 = 1u;
const POSED_UNCOVERED: u32 = 2u;

struct VertexUniforms {
    // Texels of a plane.
    plane: u32,
    // Whether the scene is as baked.
    is_as_baked: u32,
}

// Irradiance.
struct Received {
    sky: vec3<f32>,
    others: vec3<f32>,
}

@group(1) @binding(0) var<uniform> uniforms: VertexUniforms;
@group(1) @binding(1) var<storage, read> values: array<LeafValue>;
@group(1) @binding(2) var<storage, read> beside: array<LeafBeside>;
// Where the leaves of each side begin, front and back of one vertex after another, and the last end.
@group(1) @binding(3) var<storage, read> starts: array<u32>;
@group(1) @binding(4) var<storage, read> states: array<u32>;
// Light from the sky and from others as baked, in planes of a texel for each side of each vertex.
@group(1) @binding(5) var<storage, read> baked: array<vec4<f32>>;
// The same of this scene, or the planes of posed.wgsl.
@group(1) @binding(6) var<storage, read_write> texels: array<vec4<f32>>;

@compute @workgroup_size(64)
fn light_vertices(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let vertex = 64u * workgroup_number(group) + lane;
    if vertex >= arrayLength(&states) {
        return;
    }
    for (var texel = 2u * vertex; texel < 2u * vertex + 2u; texel += 1u) {
        let now = received_at(texel, (states[vertex] & VERTEX_IS_OPEN) != 0u);
        if uniforms.is_as_baked != 0u {
            texels[texel] = vec4(now.sky, 0.0);
            texels[uniforms.plane + texel] = vec4(now.others, 0.0);
        } else {
            write_change(texel, states[vertex], now);
        }
    }
}

// The mean of the open leaves beside a side of a vertex. Covered vertices are dark.
fn received_at(side: u32, is_open: bool) -> Received {
    var sum = LeafValue();
    for (var i = starts[side]; i < starts[side + 1u]; i += 1u) {
        let leaf = beside[i].leaf;
        let weight = beside[i].weight;
        sum.sky += values[leaf].sky * weight;
        sum.others += values[leaf].others * weight;
        sum.weight += values[leaf].weight * weight;
        sum.open += values[leaf].open * weight;
    }
    if !(is_open && sum.open >= LEAST_OPEN) {
        return Received();
    }
    let has_weight = sum.weight > vec3(0.0);
    return Received(
        select(vec3(0.0), sum.sky / sum.weight, has_weight),
        select(vec3(0.0), sum.others / sum.weight, has_weight)
    );
}

// Growth, bounce and uncovered light, each exactly 0 where light is unchanged. Equal light is asked for: drivers may fuse the product in a
// difference with it, which leaves what the product was rounded by.
fn write_change(texel: u32, state: u32, now: Received) {
    let before = Received(baked[texel].xyz, baked[uniforms.plane + texel].xyz);
    let is_moved = (state & VERTEX_IS_MOVED) != 0u;
    let ratio = ratio_of(now.sky, before.sky);
    let has_ratio = (state & VERTEX_HAS_NEW_CUT) == 0u;
    let rest = select(max(now.sky - before.sky * ratio, vec3(0.0)), vec3(0.0), now.sky == before.sky);
    let others = select(before.others, vec3(0.0), is_moved);
    let more = select(now.others - others, vec3(0.0), now.others == others);
    texels[POSED_GROWTH * uniforms.plane + texel] = vec4(select(vec3(0.0), ratio - 1.0, has_ratio), 0.0);
    texels[POSED_BOUNCE * uniforms.plane + texel] = vec4(more, select(0.0, 1.0, is_moved));
    texels[POSED_UNCOVERED * uniforms.plane + texel] = vec4(select(vec3(0.0), rest, has_ratio), 0.0);
}

// Twin of `ratio`. Equal light is asked for: a quotient of equals may be off by rounding.
fn ratio_of(now: vec3<f32>, before: vec3<f32>) -> vec3<f32> {
    let quotient = select(clamp(now / before, vec3(0.0), vec3(MOST_GROWTH)), vec3(1.0), now == before);
    return select(vec3(1.0), quotient, before > vec3(0.0));
}
