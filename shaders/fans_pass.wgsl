// First hits of the rays of fans: one workgroup for each 64 directions of a fan.

struct FanUniforms {
    directions: u32,
}

struct Fan {
    // From the fan to the world.
    frame: mat3x3<f32>,
    origin: vec3<f32>,
}

struct FanHit {
    // The triangle plus 1, with its highest bit for a back; 0 without a hit.
    triangle: u32,
    distance: f32,
    barycentric: vec2<f32>,
}

const BACK: u32 = 0x80000000u;

@group(1) @binding(0) var<uniform> uniforms: FanUniforms;
@group(1) @binding(1) var<storage, read> directions: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read> fans: array<Fan>;
@group(1) @binding(3) var<storage, read_write> hits: array<FanHit>;

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = 64u * group.x + lane;
    if index < uniforms.directions {
        let fan = fans[group.y];
        let hit = first_hit(fan.origin, fan.frame * directions[index].xyz);
        let triangle = hit.triangle | select(0u, BACK, hit.is_back);
        hits[group.y * uniforms.directions + index] = FanHit(triangle, hit.distance, hit.barycentric);
    }
}
