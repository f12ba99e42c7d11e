// Counts the functions of a level that gather, and those of them whose rays are unknown, in each block.

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = workgroup_number(group);
    let sum = sum_up_to(lane, marks_of(level.first + BLOCK * block + lane));
    if lane == BLOCK - 1u {
        sums[block] = sum;
    }
}
