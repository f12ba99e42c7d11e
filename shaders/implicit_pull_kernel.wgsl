// Radiance of nodes, as means by area over the leaves below; one workgroup per node. Equals its twin `DiscForest::pull` up to
// rounding: the twin works level by level, while here each node reads its leaves, so that a pull is one dispatch.

const LANES: u32 = 64u;

@group(1) @binding(0) var<uniform> uniforms: LightUniforms;
@group(1) @binding(1) var<storage, read> discs: array<Disc>;
// The first leaf below each node, and one past the last.
@group(1) @binding(2) var<storage, read> spans: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> lighting: array<LeafLighting>;
@group(1) @binding(4) var<storage, read> light: array<LeafIrradiance>;
@group(1) @binding(5) var<storage, read_write> radiance: array<vec4<f32>>;

// Light times area, and area.
var<workgroup> sums: array<vec4<f32>, LANES>;

@compute @workgroup_size(64)
fn pull(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    let span = spans[number];
    var sum = vec4(0.0);
    for (var leaf = span.x + lane; leaf < span.y; leaf += LANES) {
        sum += vec4(sent(leaf), 1.0) * discs[leaf].area;
    }
    sums[lane] = sum;
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    if lane == 0u {
        let whole = sums[0];
        radiance[number] = select(vec4(0.0), whole / whole.w, whole.w > 0.0);
    }
}

// Radiance that a leaf sends.
fn sent(leaf: u32) -> vec3<f32> {
    if uniforms.sends == SENDS_EMISSION {
        return lighting[leaf].emitted;
    }
    let reflectance = lighting[leaf].reflectance;
    if uniforms.sends == SENDS_LAST {
        return light[leaf].last * reflectance * FRAC_1_PI;
    }
    let arriving = lighting[leaf].received + light[leaf].direct + light[leaf].bounced;
    return arriving * reflectance * FRAC_1_PI + lighting[leaf].emitted;
}
