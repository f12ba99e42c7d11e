//! The post pass: scene-linear radiance to display values. Edits of exposure or tone curve redo nothing else.
//!
//! The list of all tone curves. Twin of `shaders/tonemap.wgsl`.

use glam::{Mat3, Vec2, Vec3};
use lapidary_core::color::{luminance, srgb_from_linear};
use serde::{Deserialize, Serialize};

/// A tone curve with its texts for lists.
pub struct Curve {
    /// Name on the command line.
    pub key: &'static str,
    /// Display name.
    pub label: &'static str,
    /// Summary of its use.
    pub summary: &'static str,
    /// Method, for the command line.
    pub method: &'static str,
    /// Maps exposed radiance to display-linear values.
    function: fn(Vec3) -> Vec3,
    /// Name of the function, here and in `shaders/tonemap.wgsl`.
    name: &'static str,
}

macro_rules! tone_maps {
    ($($(#[$attribute:meta])* $variant:ident = $function:ident { $($said:tt)* })*) => {
        /// How scene-linear radiance becomes display values.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum ToneMap { $($(#[$attribute])* $variant,)* }

        impl ToneMap {
            /// All curves in menu order.
            pub const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];

            /// Its entry in the list.
            pub const fn curve(self) -> &'static Curve {
                match self {
                    $(Self::$variant => &Curve { function: $function, name: stringify!($function), $($said)* },)*
                }
            }
        }
    };
}

// To add a curve, add an entry, its function below, and that function's twin in `shaders/tonemap.wgsl`.
tone_maps! {
    /// No curve: clamped and sRGB-encoded.
    #[default]
    Standard = standard {
        key: "standard",
        label: "None (sRGB)",
        summary: "No curve: values above one are clipped. For comparing numbers.",
        method: "No curve: clamped and sRGB-encoded",
    }
    /// Reinhard et al. 2002, Eq. 3, on luminance.
    Reinhard = reinhard {
        key: "reinhard",
        label: "Reinhard",
        summary: "Compresses luminance softly and keeps hue.",
        method: "Reinhard, on luminance",
    }
    /// The fit of the ACES reference curves by Hill (in Baking Lab, 2016).
    Aces = aces {
        key: "aces",
        label: "ACES (fit)",
        summary: "The look of film: strong contrast, bright colors go to white.",
        method: "A fit of the ACES curves",
    }
    /// AgX (Sobotka 2022), the polynomial fit of its default contrast by Wrensch (2023).
    #[serde(alias = "agx")]
    AgX = agx {
        key: "agx",
        label: "AgX",
        summary: "Even contrast: saturated lights fade to white without a change of hue.",
        method: "AgX with its default contrast",
    }
    /// Khronos PBR Neutral (2024): keeps colors of product renders below 0.8.
    PbrNeutral = pbr_neutral {
        key: "pbr-neutral",
        label: "Khronos PBR Neutral",
        summary: "Keeps base colors as they are and compresses highlights only. For products.",
        method: "Khronos PBR Neutral",
    }
}

impl ToneMap {
    /// Display name.
    pub fn label(self) -> &'static str {
        self.curve().label
    }

    /// WGSL that selects a curve by its number.
    pub(crate) fn wgsl() -> String {
        let case = |tone: Self| format!("        case {}u: {{ return {}(c); }}\n", tone as u32, tone.curve().name);
        let cases = Self::ALL.map(case).concat();
        format!(
            "fn tone_curve(kind: u32, c: vec3<f32>) -> vec3<f32> {{\n    switch kind {{\n{cases}        \
             default: {{ return c; }}\n    }}\n}}\n"
        )
    }
}

/// Exposure, vignette and tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Post {
    /// Exposure in stops; radiance is scaled by two to this power.
    pub exposure: f32,
    /// Curve.
    pub tone_map: ToneMap,
    /// How much darker the picture is toward its corners, 0 to 1: at 1 they have a quarter of their light, as by the cosine law of a
    /// wide lens.
    pub vignette: f32,
}

impl Post {
    /// Display color of `radiance` in the middle of a picture: encoded, each channel 0 to 1. NaN becomes magenta.
    pub fn display(&self, radiance: Vec3) -> Vec3 {
        if radiance.is_nan() {
            return Vec3::new(1.0, 0.0, 1.0);
        }
        let exposed = (radiance * self.exposure.exp2()).clamp(Vec3::ZERO, Vec3::splat(LARGEST));
        (self.tone_map.curve().function)(exposed).map(srgb_from_linear)
    }
}

/// Share of the light at a pixel of a picture with this vignette. Twin of `vignette` in `shaders/display_pass.wgsl`.
pub fn vignetted(vignette: f32, [x, y]: [u32; 2], size: [u32; 2]) -> f32 {
    if vignette == 0.0 {
        return 1.0;
    }
    let half = 0.5 * Vec2::new(size[0] as f32, size[1] as f32);
    let off = (Vec2::new(x as f32, y as f32) + 0.5 - half).length_squared() / half.length_squared();
    let cosine_sq = 1.0 / (1.0 + vignette * off);
    cosine_sq * cosine_sq
}

/// Larger values look the same, and their squares must stay finite.
const LARGEST: f32 = 1e6;

fn standard(c: Vec3) -> Vec3 {
    c
}

fn reinhard(c: Vec3) -> Vec3 {
    c / (1.0 + luminance(c))
}

/// Rec. 709 to the space of the curves, with AP1 primaries and the reference rendering transform's saturation.
const ACES_INPUT: Mat3 = Mat3::from_cols(
    Vec3::new(0.59719, 0.07600, 0.02840),
    Vec3::new(0.35458, 0.90834, 0.13383),
    Vec3::new(0.04823, 0.01566, 0.83777),
);
/// Back to Rec. 709, with the output transform's saturation.
const ACES_OUTPUT: Mat3 = Mat3::from_cols(
    Vec3::new(1.60475, -0.10208, -0.00327),
    Vec3::new(-0.53108, 1.10813, -0.07276),
    Vec3::new(-0.07367, -0.00605, 1.07602),
);

fn aces(c: Vec3) -> Vec3 {
    let v = ACES_INPUT * c;
    let a = v * (v + 0.0245786) - 0.000090537;
    let b = v * (0.983729 * v + 0.4329510) + 0.238081;
    ACES_OUTPUT * (a / b)
}

/// Rec. 709 to AgX' log space.
const AGX_INSET: Mat3 = Mat3::from_cols(
    Vec3::new(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
    Vec3::new(0.0784335999999992, 0.878468636469772, 0.0784336),
    Vec3::new(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
);
/// Its inverse.
const AGX_OUTSET: Mat3 = Mat3::from_cols(
    Vec3::new(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
    Vec3::new(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
    Vec3::new(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
);
/// Stops below and above middle gray that the curve covers.
const AGX_RANGE: [f32; 2] = [-12.47393, 4.026069];

fn agx(c: Vec3) -> Vec3 {
    let [low, high] = AGX_RANGE;
    let inset = AGX_INSET * c;
    let log = inset.map(|x| x.max(1e-10).log2().clamp(low, high));
    let x = (log - low) / (high - low);
    let (x2, x4) = (x * x, x * x * x * x);
    let curve = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    (AGX_OUTSET * curve).map(|v| v.max(0.0).powf(2.2))
}

fn pbr_neutral(c: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = c.min_element();
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let c = c - offset;
    let peak = c.max_element();
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let gray = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (c * (new_peak / peak)).lerp(Vec3::splat(new_peak), gray)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_rise_from_black_stay_in_range_and_show_nan() {
        for tone_map in ToneMap::ALL {
            let post = Post { tone_map, ..Post::default() };
            let shown: Vec<f32> = (0..60).map(|i| post.display(Vec3::splat(1e-3 * 1.3_f32.powi(i))).y).collect();
            assert!(shown.windows(2).all(|w| w[1] >= w[0] - 1e-6), "{tone_map:?} {shown:?}");
            assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)));
            assert!(post.display(Vec3::ZERO).max_element() < 0.02, "{tone_map:?}");
            assert!(*shown.last().unwrap() > 0.95, "{tone_map:?}");
            assert_eq!(post.display(Vec3::new(f32::NAN, 0.0, 0.0)), Vec3::new(1.0, 0.0, 1.0));
        }
    }

    #[test]
    fn a_stop_doubles_and_standard_is_srgb() {
        let post = Post { exposure: 1.0, ..Post::default() };
        assert!((post.display(Vec3::splat(0.107_020_5)) - 0.5).length() < 1e-4);
    }

    #[test]
    fn neutral_leaves_base_colours_alone_but_for_the_fresnel_offset() {
        let c = Vec3::new(0.5, 0.3, 0.2);
        assert!((pbr_neutral(c) - (c - 0.04)).length() < 1e-6);
    }

    #[test]
    fn corners_have_a_quarter_of_their_light_at_most_and_the_middle_all() {
        let size = [401, 301];
        assert!((vignetted(1.0, [0, 0], size) - 0.25).abs() < 2e-3);
        assert_eq!((vignetted(1.0, [200, 150], size), vignetted(0.0, [0, 0], size)), (1.0, 1.0));
        let row: Vec<f32> = (200..401).map(|x| vignetted(0.5, [x, 150], size)).collect();
        assert!(row.windows(2).all(|pair| pair[1] < pair[0]) && row[200] > 0.5, "it falls off evenly");
        assert_eq!(vignetted(0.5, [0, 20], size), vignetted(0.5, [400, 280], size), "alike on both sides");
    }
}
