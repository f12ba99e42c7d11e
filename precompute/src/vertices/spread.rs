//! Points spread evenly.

/// Barycentric coordinates of the second and third corner of a triangle for point `index`: Roberts' R2 sequence, folded.
pub fn on_triangle(index: u32) -> [f32; 2] {
    const GOLDEN: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let [u, v] = GOLDEN.map(|g| (0.5 + g * f64::from(index)).fract() as f32);
    if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
}
