// The sums of one part of the light, cleared in pixels that show an edited surface.

struct StaleMarks {
    // Sets like the pixels' sets, the low word first.
    materials: vec2<u32>,
    patches: vec2<u32>,
}

@group(0) @binding(0) var<uniform> stale: StaleMarks;
@group(0) @binding(1) var marks: texture_2d<u32>;
@group(0) @binding(2) var value: texture_2d<f32>;
@group(0) @binding(3) var work: texture_2d<u32>;
// Another part to add to this one, or a texel of zeros.
@group(0) @binding(4) var added: texture_2d<f32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Sums {
    let pixel = vec2<u32>(position.xy);
    if any((textureLoad(marks, pixel, 0) & vec4(stale.materials, stale.patches)) != vec4(0u)) {
        return Sums(vec4(0.0), vec4(0u));
    }
    let counts = textureLoad(work, pixel, 0);
    // Nothing has been shaded since the picture was resumed.
    let kept = vec4(counts.xyz, counts.w & 0xffffu);
    return Sums(textureLoad(value, pixel, 0) + textureLoad(added, pixel, 0), kept);
}
