// Irradiance of leaves from their visible nodes, and from the sky in the other cells; one workgroup per leaf: E = pi/n^2 sum of L
// over n x n cells. Equals its twin `LeafLight::new` in core/src/implicit/gather.rs up to rounding: sums are taken in halves.

const LANES: u32 = 64u;

@group(1) @binding(0) var<uniform> uniforms: LightUniforms;
@group(1) @binding(1) var<storage, read> discs: array<Disc>;
// Visible node in each cell of each leaf.
@group(1) @binding(2) var<storage, read> views: array<u32>;
@group(1) @binding(3) var<storage, read> directions: array<vec4<f32>>;
// Radiance of the nodes.
@group(1) @binding(4) var<storage, read> radiance: array<vec4<f32>>;
@group(1) @binding(5) var<storage, read> lighting: array<LeafLighting>;
// Radiance of the sky by cell of an octahedron.
@group(1) @binding(6) var<storage, read> sky: array<vec4<f32>>;
@group(1) @binding(7) var<storage, read_write> light: array<LeafIrradiance>;

struct Gathered {
    nodes: vec3<f32>,
    sky: vec3<f32>,
}

var<workgroup> sums: array<Gathered, LANES>;

@compute @workgroup_size(64)
fn bounce(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let leaf = workgroup_number(group);
    sums[lane] = gathered(leaf, lane);
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane].nodes += sums[lane + half].nodes;
            sums[lane].sky += sums[lane + half].sky;
        }
    }
    if lane == 0u {
        // The integral of the cosine over a cell.
        let weight = PI / f32(uniforms.side * uniforms.side);
        add(leaf, sums[0].nodes * weight, sums[0].sky * weight);
    }
}

// Sum over every 64th cell.
fn gathered(leaf: u32, lane: u32) -> Gathered {
    let frame = turned_frame(discs[leaf].normal, uniforms.turn);
    let cells = uniforms.side * uniforms.side;
    var sum = Gathered();
    for (var cell = lane; cell < cells; cell += LANES) {
        let node = views[cells * leaf + cell];
        if node != EMPTY {
            sum.nodes += radiance[node].xyz;
        } else if uniforms.sends == SENDS_EMISSION {
            sum.sky += sky[octahedron_cell(world_from_frame(frame, directions[cell].xyz))].xyz;
        }
    }
    return sum;
}

fn add(leaf: u32, of_nodes: vec3<f32>, of_sky: vec3<f32>) {
    if uniforms.sends == SENDS_EMISSION {
        let direct = of_nodes + of_sky;
        light[leaf] = LeafIrradiance(of_sky, direct, vec3(0.0), direct + lighting[leaf].received);
    } else {
        light[leaf].bounced += of_nodes;
        light[leaf].last = of_nodes;
    }
}
