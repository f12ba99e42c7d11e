// Output of the deferred passes: one texel of 16 bytes per pixel for the geometry, one for the frame.
//
// geometry: x = triangle + 1, or 0 for nothing; y, z = barycentric weights of the second and third corner (f32 bits);
//           w = bit 8 back side seen, bit 9 mirrored frame, bit 10 nothing is reflected, bit 11
//           ground that catches shadows, bit 12 shading normal bent by a map; of what mirrors show, bits 16 to 31 the
//           width of the ray's cone.
// frame:    the rotation from the local frame (before mirroring) to the world as a quaternion.

const FLAG_BACK: u32 = 0x100u;
const FLAG_MIRRORED: u32 = 0x200u;
const FLAG_BLACK: u32 = 0x400u;
const FLAG_CATCHER: u32 = 0x800u;
const FLAG_BENT: u32 = 0x1000u;
// The upper half of a number in single precision, which is precise enough.
const WIDTH_BITS: u32 = 0xffff0000u;

// Where a ray hit the triangle of a texel of the geometry.
fn hit_of(g: vec4<u32>) -> Hit {
    let bc = bitcast<vec2<f32>>(g.yz);
    return Hit(vec3(1.0 - bc.x - bc.y, bc), select(1.0, -1.0, (g.w & FLAG_BACK) != 0u));
}

// Rotation matrix to quaternion, by the largest of its components (Shepperd 1978).
fn quaternion_from_rotation(m: mat3x3<f32>) -> vec4<f32> {
    let t = vec4(m[0].x, m[1].y, m[2].z, m[0].x + m[1].y + m[2].z);
    var q: vec4<f32>;
    if t.w >= max(t.x, max(t.y, t.z)) {
        q = vec4(m[1].z - m[2].y, m[2].x - m[0].z, m[0].y - m[1].x, 1.0 + t.w);
    } else if t.x >= max(t.y, t.z) {
        q = vec4(1.0 + t.x - t.y - t.z, m[0].y + m[1].x, m[2].x + m[0].z, m[1].z - m[2].y);
    } else if t.y >= t.z {
        q = vec4(m[0].y + m[1].x, 1.0 + t.y - t.x - t.z, m[1].z + m[2].y, m[2].x - m[0].z);
    } else {
        q = vec4(m[2].x + m[0].z, m[1].z + m[2].y, 1.0 + t.z - t.x - t.y, m[0].y - m[1].x);
    }
    return normalize(q);
}

fn rotation_from_quaternion(q: vec4<f32>) -> mat3x3<f32> {
    let d = 2.0 * q.xyz;
    let s = d * q.xyz;
    let xy = d.x * q.y;
    let xz = d.x * q.z;
    let yz = d.y * q.z;
    let w = d * q.w;
    return mat3x3<f32>(
        vec3(1.0 - s.y - s.z, xy + w.z, xz - w.y),
        vec3(xy - w.z, 1.0 - s.x - s.z, yz + w.x),
        vec3(xz + w.y, yz - w.x, 1.0 - s.x - s.y),
    );
}

// Tangent, bitangent and normal as columns.
fn world_from_local(q: vec4<f32>, flags: u32) -> mat3x3<f32> {
    let m = rotation_from_quaternion(q);
    let handedness = select(1.0, -1.0, (flags & FLAG_MIRRORED) != 0u);
    return mat3x3<f32>(m[0], m[1] * handedness, m[2]);
}
