// Luminance inside, the sRGB transfer function at the border. Twin of core/src/color.rs.

// Of a scene-linear Rec. 709 color.
fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3(0.2126, 0.7152, 0.0722));
}

// Share of a light that is at most this bright. Twin of `up_to` in render/src/shade/mirror/rays.rs.
fn share_up_to(brightest: f32, luminance: f32) -> f32 {
    return select(1.0, brightest / luminance, luminance > brightest);
}

// A change of light as a color: red adds, blue subtracts.
fn signed_light(more: f32) -> vec3<f32> {
    return max(vec3(more, 0.0, -more), vec3(0.0));
}

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let x = saturate(linear);
    return select(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3(0.0031308));
}
