// Sums over all blocks of a level before each one, and over all of them. A single workgroup takes as many blocks at a time as it has
// lanes.

@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let blocks = (level.end - level.first + BLOCK - 1u) / BLOCK;
    var before = vec2(0u);
    for (var first = 0u; first <= blocks; first += BLOCK) {
        let block = first + lane;
        var own = vec2(0u);
        if block < blocks {
            own = sums[block];
        }
        let sum = sum_up_to(lane, own);
        if block <= blocks {
            sums[block] = before + sum - own;
        }
        workgroupBarrier();
        before += sums_so_far[BLOCK - 1u];
        workgroupBarrier();
    }
}
