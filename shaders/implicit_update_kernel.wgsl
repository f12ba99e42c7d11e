// The discs of leaves on posed triangles, one invocation each. Equals its twin `Rider::disc` in core/src/implicit/forest.rs bit for
// bit.

struct Rider {
    corners: vec3<u32>,
    // Its area as a share of its triangle's.
    share: f32,
    // Weights of the second and the third corner.
    barycentric: vec2<f32>,
    // Whether it lies on the side where the corners are clockwise.
    is_back: u32,
    padding: u32,
}

// Three numbers per vertex.
@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> riders: array<Rider>;
@group(1) @binding(2) var<storage, read_write> discs: array<Disc>;

@compute @workgroup_size(64)
fn update(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let leaf = 64u * workgroup_number(group) + lane;
    if leaf < arrayLength(&riders) {
        discs[leaf] = disc_of(riders[leaf]);
    }
}

fn disc_of(rider: Rider) -> Disc {
    let a = vertex(rider.corners.x);
    let ab = vertex(rider.corners.y) - a;
    let ac = vertex(rider.corners.z) - a;
    let area_vector = ordered_cross(ab, ac);
    let front = ordered_normalize_or(area_vector, vec3(0.0, 1.0, 0.0));
    let position = a + ab * rider.barycentric.x + ac * rider.barycentric.y;
    let area = 0.5 * ordered_length(area_vector) * rider.share;
    return Disc(position, area, select(front, -front, rider.is_back != 0u), 0u);
}

fn vertex(number: u32) -> vec3<f32> {
    return vec3(positions[3u * number], positions[3u * number + 1u], positions[3u * number + 2u]);
}
