// Maps exposed radiance to display-linear values. Twin of render/src/post.rs, which generates `tone_curve`: it selects a curve by
// number.

const LARGEST: f32 = 1e6;

fn tone_map(kind: u32, radiance: vec3<f32>) -> vec3<f32> {
    return tone_curve(kind, clamp(radiance, vec3(0.0), vec3(LARGEST)));
}

fn standard(c: vec3<f32>) -> vec3<f32> {
    return c;
}

fn reinhard(c: vec3<f32>) -> vec3<f32> {
    return c / (1.0 + luminance(c));
}

fn aces(c: vec3<f32>) -> vec3<f32> {
    let v = mat3x3<f32>(
        vec3(0.59719, 0.07600, 0.02840),
        vec3(0.35458, 0.90834, 0.13383),
        vec3(0.04823, 0.01566, 0.83777),
    ) * c;
    let a = v * (v + 0.0245786) - 0.000090537;
    let b = v * (0.983729 * v + 0.4329510) + 0.238081;
    return mat3x3<f32>(
        vec3(1.60475, -0.10208, -0.00327),
        vec3(-0.53108, 1.10813, -0.07276),
        vec3(-0.07367, -0.00605, 1.07602),
    ) * (a / b);
}

const AGX_LOW: f32 = -12.47393;
const AGX_HIGH: f32 = 4.026069;

fn agx(c: vec3<f32>) -> vec3<f32> {
    let inset = mat3x3<f32>(
        vec3(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        vec3(0.0784335999999992, 0.878468636469772, 0.0784336),
        vec3(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    ) * c;
    let log = clamp(log2(max(inset, vec3(1e-10))), vec3(AGX_LOW), vec3(AGX_HIGH));
    let x = (log - AGX_LOW) / (AGX_HIGH - AGX_LOW);
    let x2 = x * x;
    let x4 = x2 * x2;
    let curve = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    let outset = mat3x3<f32>(
        vec3(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
        vec3(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
        vec3(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
    ) * curve;
    return pow(max(outset, vec3(0.0)), vec3(2.2));
}

fn pbr_neutral(color: vec3<f32>) -> vec3<f32> {
    let start = 0.8 - 0.04;
    let least = min(color.x, min(color.y, color.z));
    let c = color - select(0.04, least - 6.25 * least * least, least < 0.08);
    let peak = max(c.x, max(c.y, c.z));
    if peak < start {
        return c;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let gray = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(c * (new_peak / peak), vec3(new_peak), gray);
}
