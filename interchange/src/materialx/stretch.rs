//! Conversion of a highlight's stretch between several surfaces, by the microfacet widths along and across it.
//!
//! | surface | along | across |
//! |---|---|---|
//! | OpenPBR | `r² sqrt(2 / (1 + (1 - a)²))` | `(1 - a)` of that |
//! | Standard Surface | `r² / sqrt(1 - a)` | `r² sqrt(1 - a)` |
//! | models of Burley's stretch, as GGX here | `r² / sqrt(1 - 0.9 a)` | `r² sqrt(1 - 0.9 a)` |
//! | glTF | `r² + (1 - r²) a²` | `r²` |

/// Widths along and across a highlight.
pub type Widths = [f32; 2];

/// Smallest width in a quotient.
const NARROWEST: f32 = 1e-6;

/// Widths for OpenPBR's roughness and anisotropy, not limited.
pub fn of_openpbr(roughness: f32, anisotropy: f32) -> Widths {
    let short = 1.0 - anisotropy;
    let along = roughness * roughness * (2.0 / (1.0 + short * short)).sqrt();
    [along, along * short]
}

/// OpenPBR's roughness and anisotropy for a lobe.
pub fn to_openpbr([along, across]: Widths) -> [f32; 2] {
    let short = across / along.max(NARROWEST);
    [(along * ((1.0 + short * short) / 2.0).sqrt()).sqrt().min(1.0), (1.0 - short).clamp(0.0, 1.0)]
}

/// Widths of a lobe with the ratio `1 - squeeze`: `squeeze` is Standard Surface's anisotropy, and 0.9 times Burley's.
pub fn of_burley(roughness: f32, squeeze: f32) -> Widths {
    let aspect = (1.0 - squeeze).max(0.0).sqrt();
    [roughness * roughness / aspect.max(NARROWEST), roughness * roughness * aspect]
}

/// Roughness and squeeze of a lobe; see [`of_burley`].
pub fn to_burley([along, across]: Widths) -> [f32; 2] {
    [(along * across).sqrt().sqrt().min(1.0), (1.0 - across / along.max(NARROWEST)).clamp(0.0, 1.0)]
}

/// Widths for glTF's roughness and strength of anisotropy.
pub fn of_gltf(roughness: f32, strength: f32) -> Widths {
    let across = roughness * roughness;
    [across + (1.0 - across) * strength.clamp(0.0, 1.0).powi(2), across]
}

/// glTF's roughness and strength for a lobe.
pub fn to_gltf([along, across]: Widths) -> [f32; 2] {
    let room = (1.0 - across).max(NARROWEST);
    [across.sqrt().min(1.0), ((along - across).max(0.0) / room).sqrt().min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::brdf::widths;

    fn close(a: [f32; 2], b: [f32; 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn numbers_and_widths_are_the_same_lobe() {
        for roughness in [0.2, 0.5, 0.7] {
            for amount in [0.0, 0.3, 0.8] {
                let given = [roughness, amount];
                assert!(close(to_openpbr(of_openpbr(roughness, amount)), given), "{given:?}");
                assert!(close(to_burley(of_burley(roughness, amount)), given), "{given:?}");
                assert!(close(to_gltf(of_gltf(roughness, amount)), given), "{given:?}");
                let ours = of_burley(roughness, 0.9 * amount);
                assert!(ours[0] >= 1.0 || close(ours, widths(roughness, amount)), "{given:?}");
                let other = to_openpbr(of_burley(roughness, amount));
                assert!(amount == 0.0 || !close(other, given), "negative control: {given:?} as it is");
            }
        }
    }

    #[test]
    fn a_mirror_has_no_stretch_that_is_no_number() {
        for lobe in [to_openpbr([0.0; 2]), to_burley([0.0; 2]), to_gltf([0.0; 2]), to_gltf([1.0; 2])] {
            assert!(lobe.iter().all(|x| (0.0..=1.0).contains(x)), "{lobe:?}");
        }
    }
}
