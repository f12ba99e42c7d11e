//! Measured isotropic reflectance (Matusik et al. 2003, *A Data-Driven Reflectance Model*): a table over the angles of the
//! half vector and of the difference vector (Rusinkiewicz 1998), interpolated linearly.
//!
//! Blurred tables over half vectors, for a few widths, serve lights of some extent. As for
//! [`GgxLobe`](super::ggx_lobe::GgxLobe), the spread of a light adds to the width of the lobe.

mod blurred;
mod error;
mod file;
#[cfg(test)]
mod tests;

pub use error::MeasuredError;

use super::sampled::SampledLobe;
use glam::Vec3;
use half::f16;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};

/// Entries along the half vector's angle, the difference vector's angle, and the difference vector's azimuth.
pub const MEASURED_SIZE: [usize; 3] = [90, 90, 180];
/// Number of entries.
const ENTRIES: usize = MEASURED_SIZE[0] * MEASURED_SIZE[1] * MEASURED_SIZE[2];
/// Largest albedo without a remark, above the error of rounding and sampling.
const MOST_ALBEDO: f32 = 1.02;
/// Width of blur for a table without a lobe.
const WITHOUT_LOBE: f32 = 0.5;

/// A measured BRDF.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The measured table, then the blurred ones.
    levels: Vec<Level>,
    lobe: SampledLobe,
    /// Squared width of the lobe.
    width_sq: f32,
    /// Number of unmeasured entries, which are filled in.
    filled: usize,
    hash: [u8; 32],
}

/// A table for lights of one extent.
#[derive(Clone, Debug)]
pub struct Level {
    /// Number of entries along each axis.
    pub size: [usize; 3],
    /// Increase of the squared width of the lobe over the measured one.
    pub spread: f32,
    /// Per color, each a 16-bit float; the azimuth of the difference vector is innermost.
    pub entries: Vec<[f32; 3]>,
}

impl Measured {
    /// Size of a file, in bytes.
    pub const FILE_BYTES: u64 = file::FILE_BYTES as u64;

    /// Creates a table from entries that are finite and not negative.
    fn new(entries: Vec<[f32; 3]>, filled: usize) -> Self {
        let first = Level { size: MEASURED_SIZE, spread: 0.0, entries };
        let lobe = SampledLobe::of(&|wi, wo| first.plain(wi, wo));
        let width_sq = if lobe.width() > 0.0 { lobe.width() } else { WITHOUT_LOBE }.powi(2);
        let hash = blake3::hash(bytemuck::cast_slice(&first.entries)).into();
        let blurred = blurred::levels(&first);
        Self { levels: [first].into_iter().chain(blurred).collect(), lobe, width_sq, filled, hash }
    }

    /// BRDF values for light around `wi` with an inverse concentration, on a surface of these [slopes](super::SpreadX8::slopes).
    #[inline]
    pub fn value(&self, wi: Vec3, wo: Vec3, inv_kappa: f32, slopes: [f32; 3]) -> Vec3 {
        let angles = Angles::new(wi, wo, self.width_sq, inv_kappa, slopes);
        let (lower, part) = self.level_of(angles.spread);
        let value = self.levels[lower].at(&angles);
        if part > 0.0 { value.lerp(self.levels[lower + 1].at(&angles), part) } else { value }
    }

    /// The level below a spread, and the fraction toward the next. The height of a lobe is proportional to one over its
    /// squared width.
    fn level_of(&self, spread: f32) -> (usize, f32) {
        let last = self.levels.len() - 1;
        let lower = self.levels.iter().rposition(|level| level.spread <= spread).unwrap_or(0);
        if lower == last {
            return (last, 0.0);
        }
        let height = |spread: f32| 1.0 / (self.width_sq + spread);
        let [low, high] = [lower, lower + 1].map(|level| height(self.levels[level].spread));
        (lower, ((height(spread) - low) / (high - low)).clamp(0.0, 1.0))
    }

    /// The estimated lobe and its sampling.
    pub fn lobe(&self) -> &SampledLobe {
        &self.lobe
    }

    /// Squared width of the lobe that lights widen.
    pub fn width_sq(&self) -> f32 {
        self.width_sq
    }

    /// All levels, by increasing blur.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Remarks on a table of this name, in sentences.
    pub fn remarks(&self, name: &str) -> Vec<String> {
        let filled = self.filled > 0;
        let filled = filled.then(|| {
            let count = self.filled;
            format!("{count} of {ENTRIES} entries of {name} were not measured and are filled in from their neighbors")
        });
        let most = self.lobe.most_albedo();
        let gains = (most > MOST_ALBEDO).then(|| {
            format!("{name} reflects up to {most:.2} times the light that it receives; lower its tint to keep energy")
        });
        filled.into_iter().chain(gains).collect()
    }

    /// Number of unmeasured entries, which are filled in.
    pub fn filled(&self) -> usize {
        self.filled
    }

    /// Hash of the values.
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }
}

impl Level {
    /// The BRDF for lights without extent.
    fn plain(&self, wi: Vec3, wo: Vec3) -> Vec3 {
        self.at(&Angles::new(wi, wo, 1.0, 0.0, [0.0; 3]))
    }

    /// Linear interpolation. Entries are means over their bins, so they sit at bin centers.
    #[inline]
    fn at(&self, angles: &Angles) -> Vec3 {
        let [n_h, n_d, n_p] = self.size;
        let inner = |x: f32, n: usize| {
            let x = (x * n as f32 - 0.5).clamp(0.0, (n - 1) as f32);
            let low = (x as usize).min(n - 2);
            (low, x - low as f32)
        };
        let (h, part_h) = inner(angles.half, n_h);
        let (d, part_d) = inner(angles.difference, n_d);
        // Azimuths repeat: light and eye swap places after half a turn.
        let p = angles.azimuth * n_p as f32 + (n_p as f32 - 0.5);
        let (low, part_p) = (p as usize % n_p, p.fract());
        let high = (low + 1) % n_p;
        let along_azimuth = |h: usize, d: usize| {
            let row = (h * n_d + d) * n_p;
            let entry = |p: usize| Vec3::from_array(self.entries[row + p]);
            entry(low).lerp(entry(high), part_p)
        };
        let across = |h: usize| along_azimuth(h, d).lerp(along_azimuth(h, d + 1), part_d);
        across(h).lerp(across(h + 1), part_h)
    }
}

/// Position of a pair of directions in a table; each coordinate from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Angles {
    /// Square root of the half vector's angle over a right angle.
    half: f32,
    /// Angle of the difference vector over a right angle.
    difference: f32,
    /// Its azimuth over half a turn.
    azimuth: f32,
    /// Increase of the squared width of the lobe by the light.
    spread: f32,
}

impl Angles {
    /// The spread of the light turns a round lobe into an ellipse. A circle of the same area replaces it, with the half
    /// vector at the same relative distance. Twin of `measured_angles` in `shaders/brdf/merl.wgsl`.
    #[inline]
    fn new(wi: Vec3, wo: Vec3, width_sq: f32, inv_kappa: f32, slopes: [f32; 3]) -> Self {
        let sum = wi + wo;
        let length = sum.length_squared().max(1e-12).sqrt();
        let h = sum / length;
        let cos_d = (0.5 * length).min(1.0);
        let q = wi - h * cos_d;
        let scale = 0.5 * inv_kappa / (cos_d * cos_d).max(1e-4);
        let xx = width_sq + slopes[0] + scale * (1.0 - h.x * h.x - q.x * q.x);
        let xy = slopes[1] - scale * (h.x * h.y + q.x * q.y);
        let yy = width_sq + slopes[2] + scale * (1.0 - h.y * h.y - q.y * q.y);
        let area = (xx * yy - xy * xy).max(1e-14).sqrt();
        let quadratic = yy * h.x * h.x - 2.0 * xy * h.x * h.y + xx * h.y * h.y;
        let sin_h = (quadratic / area).max(0.0).sqrt().min(1.0);
        let half = angle(sin_h, (1.0 - sin_h * sin_h).max(0.0).sqrt()) / FRAC_PI_2;
        let difference = angle((1.0 - cos_d * cos_d).max(0.0).sqrt(), cos_d) / FRAC_PI_2;
        Self { half: half.sqrt(), difference, azimuth: azimuth(wi, h), spread: area - width_sq }
    }
}

/// Azimuth of the difference vector over half a turn, 0 to 1.
#[inline]
fn azimuth(wi: Vec3, h: Vec3) -> f32 {
    let sin = (h.x * h.x + h.y * h.y).sqrt();
    let (cos_p, sin_p) = if sin > 1e-6 { (h.x / sin, h.y / sin) } else { (1.0, 0.0) };
    let x = h.z * (cos_p * wi.x + sin_p * wi.y) - sin * wi.z;
    let y = cos_p * wi.y - sin_p * wi.x;
    FRAC_1_PI * if y < 0.0 { angle(-y, -x) } else { angle(y, x) }
}

/// Angle of a vector in the upper half plane to the x axis, by a polynomial within 2e-5. Shaders use the same, because
/// the functions of graphics drivers are coarser.
#[inline]
fn angle(y: f32, x: f32) -> f32 {
    let (low, high) = if y < x.abs() { (y, x.abs()) } else { (x.abs(), y) };
    let t = low / high.max(1e-20);
    let s = t * t;
    let series = 0.999_977_26
        + s * (-0.332_623_47 + s * (0.193_543_46 + s * (-0.116_432_87 + s * (0.052_653_32 - s * 0.011_721_2))));
    let first = t * series;
    let acute = if y < x.abs() { first } else { FRAC_PI_2 - first };
    if x < 0.0 { std::f32::consts::PI - acute } else { acute }
}

/// The nearest 16-bit float as in shaders: no subnormals, and the largest float for greater values, which occur in
/// measurements near the horizon.
fn halved(entry: [f32; 3]) -> [f32; 3] {
    let [least, most] = [f16::MIN_POSITIVE, f16::MAX].map(f16::to_f32);
    entry.map(|x| if x < least { 0.0 } else { f16::from_f32(x.min(most)).to_f32() })
}
