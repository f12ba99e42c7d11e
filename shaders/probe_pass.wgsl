// Some work for each texel, as much as a node of the merge or two take: fragments and kernels are measured by it.

const ROUNDS: u32 = 64u;

fn written_at(texel: vec2<u32>) -> vec4<f32> {
    var value = vec4(vec2<f32>(texel) * 1e-3, 0.5, 0.25);
    for (var i = 0u; i < ROUNDS; i++) {
        value = fract(value.yzwx * 1.7 + sqrt(value) * 0.3);
    }
    return value;
}
