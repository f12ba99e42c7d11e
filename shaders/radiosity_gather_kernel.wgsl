// Vector irradiance of receivers from the senders that their rays meet; one workgroup each. Equals its twin `Gather::of` in
// core/src/meshless/radiosity/transport.rs up to rounding: sums are taken in halves.

struct RowUniforms {
    // Rays of a receiver.
    rays: u32,
    // Of a ray, in steradians.
    solid_angle: f32,
    // First slot of the bound rays, and their number.
    first_slot: u32,
    slots: u32,
}

const LANES: u32 = 64u;

@group(1) @binding(0) var<uniform> bound: RowUniforms;
// The functions that gather.
@group(1) @binding(1) var<storage, read> receivers: array<u32>;
// For each function the place of its rays plus 1.
@group(1) @binding(2) var<storage, read> slots: array<u32>;
// The senders that the rays of each slot meet; beyond the last sender where they meet none.
@group(1) @binding(3) var<storage, read> rows: array<u32>;
// From the fan to the world: three columns a slot.
@group(1) @binding(4) var<storage, read> frames: array<vec4<f32>>;
@group(1) @binding(5) var<storage, read> directions: array<vec4<f32>>;
// Of the senders.
@group(1) @binding(6) var<storage, read> radiance: array<vec4<f32>>;
@group(1) @binding(7) var<storage, read_write> received: array<Coefficient>;

var<workgroup> partial: array<mat3x3<f32>, LANES>;

@compute @workgroup_size(64)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let function = receivers[workgroup_number(group)];
    let row = slots[function] - 1u - bound.first_slot;
    if row >= bound.slots {
        return;
    }
    partial[lane] = gathered(row, lane);
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            partial[lane] += partial[lane + half];
        }
    }
    if lane == 0u {
        let frame = mat3x3(frames[3u * row].xyz, frames[3u * row + 1u].xyz, frames[3u * row + 2u].xyz);
        received[function].vector = (frame * partial[0]) * bound.solid_angle;
    }
}

// Sum over every 64th ray, in the frame of the fan.
fn gathered(row: u32, lane: u32) -> mat3x3<f32> {
    var sum = mat3x3<f32>();
    for (var ray = lane; ray < bound.rays; ray += LANES) {
        let sender = rows[bound.rays * row + ray];
        if sender < arrayLength(&radiance) {
            let sent = radiance[sender];
            let toward = directions[ray].xyz;
            sum += mat3x3(toward * sent.x, toward * sent.y, toward * sent.z);
        }
    }
    return sum;
}
