// Kernels run in slices of their workgroups to keep a desktop responsive. See render/src/device/kernel.rs.

struct Slice {
    // First workgroup of this dispatch.
    first: u32,
}

@group(0) @binding(0) var<uniform> slice: Slice;

// The number of a workgroup over all slices.
fn workgroup_number(group: vec3<u32>) -> u32 {
    return slice.first + group.x;
}
