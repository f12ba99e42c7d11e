// Light of a level: functions that do not gather take that of their parents; those that gathered split if theirs differs. Twin of
// `Radiosity::end_level` in core/src/meshless/radiosity/transport.rs.

@group(2) @binding(0) var<storage, read_write> received: array<Coefficient>;

@compute @workgroup_size(64)
fn pull(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let function = level.first + 64u * workgroup_number(group) + lane;
    if function >= level.end {
        return;
    }
    // Before the sum: after its loop, OpenGL on llvmpipe (Mesa 22.3) finds functions inactive that are not.
    let gathers = is_active(function);
    let pulled = light_of_parents(function);
    if !gathers {
        received[function].vector = pulled;
    } else if length_of(received[function].vector - pulled) > level.enough {
        states[function] = SPLIT;
    }
}

fn light_of_parents(function: u32) -> mat3x3<f32> {
    var sum = mat3x3<f32>();
    for (var i = parent_starts[function]; i < parent_starts[function + 1u]; i++) {
        sum += received[parents[i].x].vector * bitcast<f32>(parents[i].y);
    }
    return sum;
}

fn length_of(vector: mat3x3<f32>) -> f32 {
    return sqrt(dot(vector[0], vector[0]) + dot(vector[1], vector[1]) + dot(vector[2], vector[2]));
}
