// Where the rays of a pixel go in the unit square: interleaved gradient noise (Jimenez 2014), and steps of the R2 sequence (Roberts 2018).
// Twin of `ray_shift` in render/src/shade/direct.rs.

const STEP: vec2<f32> = vec2<f32>(0.75487767, 0.5698403);

// Offset of a pixel's rays, if each sample of the pixel has one.
fn ray_shift(pixel: vec2<u32>, ray: u32) -> vec2<f32> {
    let p = vec2<f32>(pixel);
    let start = vec2(gradient_noise(p), gradient_noise(vec2(p.y + 37.0, p.x + 91.0)));
    return fract(start + STEP * f32(ray));
}

fn gradient_noise(p: vec2<f32>) -> f32 {
    return fract(52.982918 * fract(0.06711056 * p.x + 0.00583715 * p.y));
}
