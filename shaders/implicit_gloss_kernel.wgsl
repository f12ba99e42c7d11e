// What glossy leaves reflect toward the eye: their BRDFs over their bins (implicit visibility, Eq. 2 to 5), one workgroup each. Twin of
// `GlossyLeaf::reflected` in render/src/light/implicit/gloss.rs, up to rounding: sums are taken in halves.

const LANES: u32 = 64u;
const SPHERE: f32 = 12.5663706;

struct GlossUniforms {
    eye: vec3<f32>,
    // Cells along one edge of a leaf's square.
    side: u32,
    // Cosine and sine of the frames' rotation.
    turn: vec2<f32>,
    // Whether glossy leaves reflect what nodes send.
    has_sent: u32,
    padding: u32,
}

@group(1) @binding(0) var<uniform> uniforms: GlossUniforms;
@group(1) @binding(4) var<storage, read> discs: array<Disc>;
// Visible node in each cell of each leaf.
@group(1) @binding(5) var<storage, read> views: array<u32>;
@group(1) @binding(6) var<storage, read> directions: array<vec4<f32>>;
// Radiance of the nodes.
@group(1) @binding(7) var<storage, read> sent: array<vec4<f32>>;
// Radiance of the sky by cell of an octahedron.
@group(1) @binding(8) var<storage, read> sky: array<vec4<f32>>;
// Of all leaves; those that are not glossy stay as they are.
@group(1) @binding(9) var<storage, read_write> reflected: array<Reflected>;

var<workgroup> sums: array<Reflected, LANES>;

@compute @workgroup_size(64)
fn reflect_leaves(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    sums[lane] = reflected_by(number, lane);
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            sums[lane].sky += sums[lane + half].sky;
            sums[lane].leaves += sums[lane + half].leaves;
            sums[lane].irradiance += sums[lane + half].irradiance;
        }
    }
    if lane == 0u {
        reflected[materials[number].leaf] = sums[0];
    }
}

// Sum over every 64th cell.
fn reflected_by(number: u32, lane: u32) -> Reflected {
    var sum = Reflected();
    let glossy = materials[number];
    let shading = mat3x3(glossy.tangent, glossy.bitangent, glossy.normal);
    let disc = discs[glossy.leaf];
    let wo = frame_from_world(shading, unit_or_zero(uniforms.eye - disc.position));
    if !(wo.z > 0.0) {
        return sum;
    }
    sum.faces_eye = 1u;
    let brdf = brdf_of(number, SurfaceAttributes(0u));
    let frame = turned_frame(disc.normal, uniforms.turn);
    let cells = uniforms.side * uniforms.side;
    // The integral of the cosine over a cell.
    let weight = PI / f32(cells);
    for (var cell = lane; cell < cells; cell += LANES) {
        let node = views[cells * glossy.leaf + cell];
        if node != EMPTY && uniforms.has_sent == 0u {
            continue;
        }
        let in_frame = directions[cell].xyz;
        let direction = world_from_frame(frame, in_frame);
        let solid_angle = weight / in_frame.z;
        // Spread of the cell, so that no lobe falls between cells.
        let inv_kappa = solid_angle / SPHERE;
        let value = solid_angle * brdf_cos(brdf, frame_from_world(shading, direction), wo, inv_kappa, vec3(0.0));
        if node == EMPTY {
            sum.sky += value * sky[octahedron_cell(direction)].xyz;
        } else {
            sum.leaves += value * sent[node].xyz;
            sum.irradiance += weight * sent[node].xyz;
        }
    }
    return sum;
}

fn unit_or_zero(v: vec3<f32>) -> vec3<f32> {
    let length = length(v);
    return select(vec3(0.0), v / length, length > 0.0);
}
