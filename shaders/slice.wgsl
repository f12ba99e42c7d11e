// Kernels run in slices of their workgroups, so that a desktop stays alive. See render/src/device/kernel.rs.

struct Slice {
    // Number of the first workgroup of this dispatch.
    first: u32,
}

@group(0) @binding(0) var<uniform> slice: Slice;

// The number of a workgroup among those of all slices.
fn workgroup_number(group: vec3<u32>) -> u32 {
    return slice.first + group.x;
}
