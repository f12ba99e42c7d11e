// Rays to lights that meet nothing: one workgroup for 64 rays, which writes two words of bits.

struct ShadowRayUniforms {
    rays: u32,
}

struct ShadowRay {
    origin: vec3<f32>,
    // Distance in meters before which something stops it.
    reach: f32,
    direction: vec3<f32>,
    padding: u32,
}

@group(1) @binding(0) var<uniform> uniforms: ShadowRayUniforms;
@group(1) @binding(1) var<storage, read> rays: array<ShadowRay>;
@group(1) @binding(2) var<storage, read_write> open_words: array<u32>;

var<workgroup> bits: array<atomic<u32>, 2>;

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = 64u * group.x + lane;
    if index < uniforms.rays {
        let ray = rays[index];
        let is_open = hit_before(ray.reach, true, ray.origin, ray.direction).triangle == 0u;
        atomicOr(&bits[lane / 32u], select(0u, 1u << (lane % 32u), is_open));
    }
    workgroupBarrier();
    if lane < 2u {
        open_words[2u * group.x + lane] = atomicLoad(&bits[lane]);
    }
}
