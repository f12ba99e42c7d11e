//! The single-bounce operator `T` as links from senders to receivers (meshless paper, 3.1), without reflectance.
//!
//! A link is the vector irradiance at the receiver's point from a sender of unit radiance, `∫ B_j(r(x_i, ω)) ω dω`,
//! minus the part that the receiver's parents already carry. A sender of radiosity `ρ E` has radiance `ρ E / π`. So one
//! bounce gives receiver `i` the vector irradiance `Σ_j T_ij (ρ E)_j / π`, and irradiance is its dot product with the
//! normal. The meshless paper includes the reflectance and the factor `1 / π` in its links (Eq. 16).
//!
//! Links are stored by band of receivers and, within a band, by sender. One thread processes a band, or some of its senders, so no
//! locks are needed. Senders without light are skipped, and the order of summation is independent of threads.

use bytemuck::{Pod, Zeroable};
use glam::{Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::ops::Range;
use thiserror::Error;

/// Receivers per band: their vector irradiance, 48 bytes each, stays in a core's second-level cache.
const BAND: usize = 4096;
/// Largest number of links of a band that run serially. The first band has the coarsest receivers, and a third of all
/// links.
const SERIAL_LINKS: u32 = 1 << 17;

/// A link in 8 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PackedLink {
    /// Index of the receiver in its band.
    pub receiver: u16,
    /// Vector irradiance in units of the operator's `scale`.
    pub vector: [i16; 3],
}

/// Why stored links do not form an operator.
#[derive(Debug, Error, PartialEq)]
#[error("the links of the light transport do not fit its {receivers} receivers and {senders} senders; bake it again")]
pub struct TransportError {
    /// Number of receivers.
    pub receivers: usize,
    /// Number of senders.
    pub senders: usize,
}

/// The operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Transport {
    receivers: usize,
    senders: usize,
    /// Vector irradiance of one step of a packed component.
    scale: f32,
    /// First link of each (band, sender), and the end of the last.
    offsets: Vec<u32>,
    links: Vec<PackedLink>,
}

impl Transport {
    /// Packs links given by receiver: `rows[i]` holds the senders of receiver `i` and its vector irradiance from each.
    pub fn from_rows(rows: &[Vec<(u32, Vec3)>], senders: usize) -> Self {
        let all = || rows.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |link| (i, link)));
        let largest = all().map(|(_, link)| link.1.abs().max_element()).fold(0.0, f32::max);
        let scale = (largest / f32::from(i16::MAX)).max(f32::MIN_POSITIVE);
        let place = |receiver: usize, sender: u32| receiver / BAND * senders + sender as usize;
        let mut offsets = vec![0_u32; rows.len().div_ceil(BAND) * senders + 1];
        all().for_each(|(i, link)| offsets[place(i, link.0) + 1] += 1);
        (1..offsets.len()).for_each(|k| offsets[k] += offsets[k - 1]);
        let mut next = offsets.clone();
        let mut links = vec![PackedLink::default(); rows.iter().map(Vec::len).sum()];
        for (i, &(sender, vector)) in all() {
            let place = &mut next[place(i, sender)];
            let vector = (vector / scale).to_array().map(|v| v.round() as i16);
            links[*place as usize] = PackedLink { receiver: (i % BAND) as u16, vector };
            *place += 1;
        }
        Self { receivers: rows.len(), senders, scale, offsets, links }
    }

    /// The operator of stored parts; see [`Self::offsets`] and [`Self::packed`].
    ///
    /// # Errors
    /// [`TransportError`] if they contradict each other.
    pub fn from_parts(
        [receivers, senders]: [usize; 2],
        scale: f32,
        offsets: Vec<u32>,
        links: Vec<PackedLink>,
    ) -> Result<Self, TransportError> {
        let last_band = receivers.div_ceil(BAND).saturating_sub(1);
        let size = |band: usize| BAND.min(receivers - band * BAND);
        let whole = scale.is_finite()
            && offsets.len() == receivers.div_ceil(BAND) * senders + 1
            && offsets.first() == Some(&0)
            && offsets.last().is_some_and(|&end| end as usize == links.len())
            && offsets.is_sorted()
            && (0..=last_band).all(|band| {
                let band_links = band_range(&offsets, senders, band).map(|range| &links[range]);
                band_links.is_none_or(|links| links.iter().all(|l| usize::from(l.receiver) < size(band)))
            });
        if whole {
            Ok(Self { receivers, senders, scale, offsets, links })
        } else {
            Err(TransportError { receivers, senders })
        }
    }

    /// Number of receivers, which are all functions of the basis.
    pub fn receivers(&self) -> usize {
        self.receivers
    }

    /// Number of senders, which are the first functions.
    pub fn senders(&self) -> usize {
        self.senders
    }

    /// Vector irradiance of one step of a packed component.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// First link of each (band, sender), and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The links by band of receivers, then by sender.
    pub fn packed(&self) -> &[PackedLink] {
        &self.links
    }

    /// Share of all possible links that were kept.
    pub fn share(&self) -> f64 {
        self.links.len() as f64 / (self.receivers as f64 * self.senders as f64).max(1.0)
    }

    /// Bytes of links and offsets.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.links[..]) + size_of_val(&self.offsets[..])) as u64
    }

    /// All links: sender, receiver, vector irradiance.
    pub fn links(&self) -> impl Iterator<Item = (usize, usize, Vec3)> {
        (0..self.offsets.len() - 1).flat_map(move |k| {
            let (band, sender) = (k / self.senders, k % self.senders);
            self.links[self.offsets[k] as usize..self.offsets[k + 1] as usize].iter().map(move |link| {
                let vector = Vec3::from_array(link.vector.map(f32::from)) * self.scale;
                (sender, band * BAND + usize::from(link.receiver), vector)
            })
        })
    }

    /// For each receiver: whether it has a link. Receivers without links never get their own light.
    pub fn linked(&self) -> Vec<bool> {
        let mut linked = vec![false; self.receivers];
        self.links().for_each(|(_, receiver, _)| linked[receiver] = true);
        linked
    }

    /// One bounce: coefficients of vector irradiance of some functions, one column per color channel, from the
    /// senders' coefficients of outgoing radiance. Senders whose largest channel is at most `threshold` are skipped.
    ///
    /// # Panics
    /// If `receivers` exceeds their number.
    pub fn apply(&self, radiance: &[Vec3], threshold: f32, receivers: Range<usize>) -> Vec<Mat3A> {
        let lit = radiance.iter().enumerate().filter(|(_, r)| r.abs().max_element() > threshold);
        let lit: Vec<(usize, Vec3)> = lit.map(|(sender, &r)| (sender, r * self.scale)).collect();
        let mut received = vec![Mat3A::ZERO; receivers.len()];
        let parts = bands_of(receivers, &mut received);
        parts.into_par_iter().for_each(|part| self.add_received(0..self.senders, &lit, part));
        received
    }

    /// Adds the light that a part receives from the lit senders within a range. A range with many links is halved by
    /// sender, each half with its own sums; the split does not depend on which senders are lit.
    fn add_received(&self, senders: Range<usize>, lit: &[(usize, Vec3)], part: BandPart) {
        let offsets = &self.offsets[part.band * self.senders..];
        let [first, end] = [offsets[senders.start], offsets[senders.end]];
        if end - first <= SERIAL_LINKS || senders.len() <= 1 {
            return self.add_received_of(offsets, within(lit, senders), part);
        }
        let half = first + (end - first) / 2;
        let middle = senders.start + offsets[senders.clone()].partition_point(|&offset| offset < half);
        let middle = middle.clamp(senders.start + 1, senders.end - 1);
        let BandPart { received, .. } = part;
        let mut second = vec![Mat3A::ZERO; received.len()];
        rayon::join(
            || self.add_received(senders.start..middle, lit, BandPart { received, ..part }),
            || self.add_received(middle..senders.end, lit, BandPart { received: &mut second, ..part }),
        );
        received.iter_mut().zip(&second).for_each(|(sum, other)| *sum += *other);
    }

    /// Adds received light by the offsets of the band.
    fn add_received_of(&self, offsets: &[u32], lit: &[(usize, Vec3)], part: BandPart) {
        for &(sender, radiance) in lit {
            for link in &self.links[offsets[sender] as usize..offsets[sender + 1] as usize] {
                // Skips links to receivers outside the part; an index below its first receiver wraps around.
                let Some(sum) = part.received.get_mut(usize::from(link.receiver).wrapping_sub(part.first)) else {
                    continue;
                };
                let vector = Vec3A::from_array(link.vector.map(f32::from));
                sum.x_axis += vector * radiance.x;
                sum.y_axis += vector * radiance.y;
                sum.z_axis += vector * radiance.z;
            }
        }
    }
}

/// Successive receivers of a band.
struct BandPart<'a> {
    band: usize,
    /// Index of the first one within the band.
    first: usize,
    received: &'a mut [Mat3A],
}

/// Successive receivers by band.
fn bands_of(receivers: Range<usize>, mut received: &mut [Mat3A]) -> Vec<BandPart<'_>> {
    let (mut parts, mut next) = (Vec::new(), receivers.start);
    while next < receivers.end {
        let (band, first) = (next / BAND, next % BAND);
        let part = received.split_off_mut(..received.len().min(BAND - first)).unwrap_or_default();
        next += part.len();
        parts.push(BandPart { band, first, received: part });
    }
    parts
}

/// The part of the ascending senders within a range.
fn within(lit: &[(usize, Vec3)], senders: Range<usize>) -> &[(usize, Vec3)] {
    let before = |sender: usize| lit.partition_point(|&(lit, _)| lit < sender);
    &lit[before(senders.start)..before(senders.end)]
}

fn band_range(offsets: &[u32], senders: usize, band: usize) -> Option<Range<usize>> {
    Some(*offsets.get(band * senders)? as usize..*offsets.get((band + 1) * senders)? as usize)
}

/// Irradiance per channel on a surface with a unit normal, from vector irradiance with one column per channel. Never
/// negative.
#[inline(always)]
pub fn irradiance(vector: &Mat3A, normal: Vec3) -> Vec3 {
    vector.transpose().mul_vec3(normal).max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_rows(receivers: usize, senders: u32) -> Vec<Vec<(u32, Vec3)>> {
        let mut random = fastrand::Rng::with_seed(3);
        let mut vector = || Vec3::from_array(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
        let mut choice = fastrand::Rng::with_seed(4);
        (0..receivers)
            .map(|_| (0..senders).filter(|_| choice.f32() < 0.1).map(|s| (s, vector())).collect::<Vec<_>>())
            .collect()
    }

    #[test]
    fn applying_is_the_matrix_product_and_small_senders_are_skipped() {
        let rows = random_rows(10_000, 400);
        let transport = Transport::from_rows(&rows, 400);
        assert!(transport.offsets()[400] > SERIAL_LINKS, "more than are done one after the other");
        let radiance: Vec<Vec3> = (0..400).map(|s| 0.1 * Vec3::new(s as f32, 10.0, -0.5 * s as f32)).collect();
        let all = transport.apply(&radiance, 0.0, 0..10_000);
        let some = transport.apply(&radiance, 5.05, 0..9_000);
        assert_eq!((all.len(), some.len()), (10_000, 9_000));
        for (i, row) in rows.iter().enumerate() {
            let from = |least: u32| {
                row.iter().filter(|l| l.0 >= least).fold(Mat3A::ZERO, |sum, &(s, v)| {
                    let r = radiance[s as usize];
                    sum + Mat3A::from_cols((v * r.x).into(), (v * r.y).into(), (v * r.z).into())
                })
            };
            assert!(all[i].abs_diff_eq(from(0), 2e-2), "{i}");
            assert!(i >= 9_000 || some[i].abs_diff_eq(from(51), 2e-2), "{i}");
        }
        assert_eq!(transport.apply(&radiance, 0.0, 5_000..9_500), all[5_000..9_500]);
        assert_eq!(transport.apply(&radiance, 0.0, 10_000..10_000), []);
        assert!(!all[0].abs_diff_eq(some[0], 2e-2), "negative control: the skipped senders show");
    }

    #[test]
    fn links_come_back_within_a_step() {
        let rows = random_rows(5000, 30);
        let transport = Transport::from_rows(&rows, 30);
        assert_eq!(transport.links().count(), rows.iter().map(Vec::len).sum::<usize>());
        for (sender, receiver, vector) in transport.links() {
            let link = rows[receiver].iter().find(|l| l.0 as usize == sender).unwrap();
            assert!((link.1 - vector).abs().max_element() <= 0.51 * transport.scale());
        }
    }

    #[test]
    fn damaged_parts_are_refused() {
        let transport = Transport::from_rows(&random_rows(5000, 30), 30);
        let parts = || (transport.offsets().to_vec(), transport.packed().to_vec());
        let (offsets, links) = parts();
        assert_eq!(Transport::from_parts([5000, 30], transport.scale(), offsets, links).unwrap(), transport);
        let (offsets, mut links) = parts();
        links.last_mut().unwrap().receiver = 5000 - 4096;
        assert!(Transport::from_parts([5000, 30], 1.0, offsets, links).is_err(), "past the last receiver");
        let (mut offsets, links) = parts();
        offsets[7] = u32::MAX;
        assert!(Transport::from_parts([5000, 30], 1.0, offsets, links).is_err(), "out of order");
        let (offsets, links) = parts();
        assert!(Transport::from_parts([5000, 29], 1.0, offsets, links).is_err(), "another number of senders");
    }
}
