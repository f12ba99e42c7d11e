// The bins of a leaf: cells of equal cosine weight in its own frame. Twin of core/src/sphere.rs and core/src/implicit/layout.rs.

const MOST_CELLS: u32 = 400u;
// An empty bin.
const EMPTY: u32 = 0xffffffffu;

// Tangents and normal, rotated about the normal by the angle with cosine and sine `turn`. Twin of `BinLayout::frame_of`.
fn turned_frame(normal: vec3<f32>, turn: vec2<f32>) -> mat3x3<f32> {
    let frame = frame_around(normal);
    return mat3x3(frame[0] * turn.x + frame[1] * turn.y, frame[0] * -turn.y + frame[1] * turn.x, normal);
}

fn frame_around(normal: vec3<f32>) -> mat3x3<f32> {
    let side = select(1.0, -1.0, (bitcast<u32>(normal.z) & 0x80000000u) != 0u);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return mat3x3(
        vec3(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3(b, side + normal.y * normal.y * a, -normal.y),
        normal,
    );
}

fn world_from_frame(frame: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return frame[0] * v.x + frame[1] * v.y + frame[2] * v.z;
}

fn frame_from_world(frame: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3(ordered_dot(v, frame[0]), ordered_dot(v, frame[1]), ordered_dot(v, frame[2]));
}
