// The post pass: the mean of all samples as a display shows it. Twin of render/src/cpu/display.rs.

struct Display {
    // Radiance is scaled by this.
    exposure: f32,
    inv_samples: f32,
    // The count at the upper end of the false colours.
    count_top: f32,
    tone_map: u32,
    view_mode: u32,
    // 1: where nothing is covered the picture is transparent.
    transparent: u32,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> display: Display;
// Every 17th colour of magma, sRGB encoded.
@group(0) @binding(1) var<uniform> magma_stops: array<vec4<f32>, 16>;
@group(0) @binding(2) var sum: texture_2d<f32>;
@group(0) @binding(3) var work: texture_2d<f32>;

const MODE_SHADED: u32 = 0u;
const MODE_ALBEDO: u32 = 2u;
const MODE_VISIBILITY_CUT: u32 = 4u;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let total = textureLoad(sum, pixel, 0) * display.inv_samples;
    let wire = textureLoad(work, pixel, 0).z * display.inv_samples;
    // The background must not show where a picture has no coverage, so the mean is over the covered samples.
    let coverage = select(1.0, total.w, display.transparent != 0u);
    if !(coverage > 0.0) {
        return vec4(0.0);
    }
    let shown = mix(display_value(total.xyz / coverage), LINE_COLOR, LINE_OPACITY * wire / coverage);
    return vec4(shown, coverage);
}

fn display_value(value: vec3<f32>) -> vec3<f32> {
    // NaN must be visible. Compilers may assume that every value equals itself, so its bits are tested.
    if any((bitcast<vec3<u32>>(value) & vec3(0x7fffffffu)) > vec3(0x7f800000u)) {
        return vec3(1.0, 0.0, 1.0);
    }
    if display.view_mode == MODE_SHADED {
        return srgb_from_linear(tone_map(display.tone_map, value * display.exposure));
    }
    if display.view_mode == MODE_ALBEDO {
        return srgb_from_linear(value);
    }
    if display.view_mode >= MODE_VISIBILITY_CUT {
        return magma(value.x / display.count_top);
    }
    return saturate(value);
}

const LINE_OPACITY: f32 = 0.7;
const LINE_COLOR: vec3<f32> = vec3<f32>(0.10, 0.75, 0.95);

fn magma(x: f32) -> vec3<f32> {
    let position = saturate(x) * 15.0;
    let below = min(u32(position), 14u);
    return mix(magma_stops[below].xyz, magma_stops[below + 1u].xyz, position - f32(below));
}
