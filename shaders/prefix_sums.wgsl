// Sums over all elements before each one, by blocks of a workgroup each: sums of the blocks, their scan, and within the blocks again.
// Two sums are taken at a time.

// Elements of a block, one invocation each.
const BLOCK: u32 = 256u;

// The sum of each block; after the scan, that of all blocks before each one, and of all blocks.
@group(2) @binding(0) var<storage, read_write> sums: array<vec2<u32>>;

var<workgroup> sums_so_far: array<vec2<u32>, BLOCK>;

// The sum over the lanes up to this one. All lanes call it together.
fn sum_up_to(lane: u32, value: vec2<u32>) -> vec2<u32> {
    sums_so_far[lane] = value;
    for (var reach = 1u; reach < BLOCK; reach *= 2u) {
        workgroupBarrier();
        var before = vec2(0u);
        if lane >= reach {
            before = sums_so_far[lane - reach];
        }
        workgroupBarrier();
        sums_so_far[lane] += before;
    }
    return sums_so_far[lane];
}
