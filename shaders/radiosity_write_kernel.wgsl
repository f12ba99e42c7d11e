// Lists the counted functions of a level in ascending order.

// The functions that gather.
@group(2) @binding(1) var<storage, read_write> receivers: array<u32>;
// Those whose rays are unknown.
@group(2) @binding(2) var<storage, read_write> unknown: array<u32>;

@compute @workgroup_size(256)
fn write(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = workgroup_number(group);
    let function = level.first + BLOCK * block + lane;
    let marks = marks_of(function);
    let place = sums[block] + sum_up_to(lane, marks) - marks;
    if marks.x != 0u {
        receivers[place.x] = function;
    }
    if marks.y != 0u {
        unknown[place.y] = function;
    }
}
