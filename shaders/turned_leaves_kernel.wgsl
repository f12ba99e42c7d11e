// Radiance of light samples under a turned map. Twin of `EnvironmentSampler::leaf_radiance` in core/src/light_tree/radiance.rs. Several
// invocations share the cells of a leaf: at the poles of the grid it has a hundred times as many as elsewhere.

@group(1) @binding(0) var<uniform> turned: TurnedUniforms;
// The first cell of each leaf, and one past the last of all.
@group(1) @binding(1) var<storage, read> starts: array<u32>;
// Each cell of a leaf, and as a float the fraction of its energy that the leaf takes.
@group(1) @binding(2) var<storage, read> cells: array<vec2<u32>>;
// Energy of the grid's cells, three numbers each.
@group(1) @binding(3) var<storage, read> energy: array<f32>;
// Mean direction and radius of each node without light.
@group(1) @binding(4) var<storage, read> plain: array<vec4<f32>>;
@group(1) @binding(5) var<storage, read_write> means: array<Means>;

// Invocations of a leaf, and leaves of a workgroup.
const SHARED_BY: u32 = 8u;
const LEAVES: u32 = 8u;

var<workgroup> parts: array<vec3<f32>, 64>;

@compute @workgroup_size(64)
fn light_leaves(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let leaf = LEAVES * workgroup_number(group) + lane / SHARED_BY;
    var part = vec3(0.0);
    if leaf < turned.leaves {
        for (var i = starts[leaf] + lane % SHARED_BY; i < starts[leaf + 1u]; i += SHARED_BY) {
            part += turned_energy(cells[i].x) * bitcast<f32>(cells[i].y);
        }
    }
    parts[lane] = part;
    workgroupBarrier();
    if lane % SHARED_BY != 0u || leaf >= turned.leaves {
        return;
    }
    var sum = vec3(0.0);
    for (var i = 0u; i < SHARED_BY; i += 1u) {
        sum += parts[lane + i];
    }
    let radiance = sum * turned.samples_per_steradian * turned.intensity;
    let bright = luminance(radiance);
    let node = turned.leaves + leaf;
    means[node] = Means(radiance, bright * bright, plain[node].xyz * bright, bright);
}

// Energy of a cell of the turned map.
fn turned_energy(cell: u32) -> vec3<f32> {
    let within = turned.columns - 1u;
    let row = cell & ~within;
    let column = cell + turned.shift;
    return energy_of(row | (column & within)) * (1.0 - turned.fraction)
        + energy_of(row | ((column + 1u) & within)) * turned.fraction;
}

fn energy_of(cell: u32) -> vec3<f32> {
    return vec3(energy[3u * cell], energy[3u * cell + 1u], energy[3u * cell + 2u]);
}
