//! One bounce of light from senders to receivers, and the Neumann series over bounces, `Σ (T R)ᵏ`, for any kind of transport.
//!
//! The operator `T` ([`LightTransport`]) contains no reflectance. Between two bounces, `R` ([`Surfaces`]) reflects the arriving
//! light. So an edited material changes no operator. [`Series`] adds one bounce after another, and each partial sum can be shown.

mod energy;

use glam::{Mat3A, Vec3, Vec3A};
use std::ops::{Add, Mul, Range, Sub};

pub use energy::BounceEnergy;

/// Type of a coefficient: a number, a color, vector irradiance per channel, or the coefficients of a directional
/// basis.
pub trait Coefficient: Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> {
    /// The zero of the type.
    const ZERO: Self;
}

impl Coefficient for f32 {
    const ZERO: Self = 0.0;
}

impl Coefficient for Vec3 {
    const ZERO: Self = Self::ZERO;
}

impl Coefficient for Vec3A {
    const ZERO: Self = Self::ZERO;
}

impl Coefficient for Mat3A {
    const ZERO: Self = Self::ZERO;
}

/// One bounce of light, free of reflectance. Its first receivers are its senders, in the same order.
pub trait LightTransport {
    /// Outgoing radiance of a sender.
    type Sent: Coefficient;
    /// Light at a receiver.
    type Received: Coefficient;

    /// Number of senders.
    fn senders(&self) -> usize;

    /// Light at some receivers, one value each, for the light `sent` by the senders, one value each.
    ///
    /// # Panics
    /// If `receivers` exceeds their number.
    fn bounce(&self, sent: &[Self::Sent], receivers: Range<usize>) -> Vec<Self::Received>;
}

/// The surfaces of the senders: their reflection of arriving light, under the current materials.
pub trait Surfaces<T: LightTransport> {
    /// The light that arrives at all senders, for instance irradiance at their points.
    type Arriving;

    /// The arriving light, from the light received by the senders.
    fn arriving(&self, received: Vec<T::Received>) -> Self::Arriving;

    /// The reflected light of the senders.
    fn reflected(&self, arriving: &Self::Arriving) -> Vec<T::Sent>;

    /// Mean irradiance over the surface in W/m² per channel, proportional to the arriving energy.
    fn mean_irradiance(&self, arriving: &Self::Arriving) -> Vec3;
}

/// The Neumann series of a transport, up to the bounces added so far.
pub struct Series<'a, T: LightTransport, S: Surfaces<T>> {
    transport: &'a T,
    surfaces: &'a S,
    arriving: S::Arriving,
    /// Light emitted by the senders; it leaves with the first bounce.
    emitted: Option<Vec<T::Sent>>,
    /// Light received by the senders in all bounces, one value each.
    pub received: Vec<T::Received>,
    /// Light sent in all bounces, one value each. Applying the operator to it once gives all bounces at other receivers.
    pub sent: Vec<T::Sent>,
    /// [`Surfaces::mean_irradiance`] of direct light, then of each bounce.
    pub mean_irradiance: Vec<Vec3>,
}

impl<'a, T: LightTransport, S: Surfaces<T>> Series<'a, T, S> {
    /// The series without bounces, for direct light and the light that senders emit, one value each.
    pub fn new(transport: &'a T, surfaces: &'a S, direct: S::Arriving, emitted: Option<Vec<T::Sent>>) -> Self {
        let senders = transport.senders();
        Self {
            mean_irradiance: vec![surfaces.mean_irradiance(&direct)],
            received: vec![T::Received::ZERO; senders],
            sent: vec![T::Sent::ZERO; senders],
            arriving: direct,
            transport,
            surfaces,
            emitted,
        }
    }

    /// Adds `bounces` bounces.
    pub fn with_bounces(mut self, bounces: u32) -> Self {
        (0..bounces).for_each(|_| self.add_bounce());
        self
    }

    /// Adds the next bounce.
    pub fn add_bounce(&mut self) {
        let mut sent = self.surfaces.reflected(&self.arriving);
        if let Some(emitted) = self.emitted.take() {
            add(&mut sent, &emitted);
        }
        let received = self.transport.bounce(&sent, 0..self.transport.senders());
        add(&mut self.sent, &sent);
        add(&mut self.received, &received);
        self.arriving = self.surfaces.arriving(received);
        self.mean_irradiance.push(self.surfaces.mean_irradiance(&self.arriving));
    }

    /// Energy of the bounces so far.
    pub fn energy(&self) -> BounceEnergy {
        BounceEnergy::of(&self.mean_irradiance)
    }
}

fn add<C: Coefficient>(sums: &mut [C], values: &[C]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum = *sum + *value);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two senders that light each other, and a third receiver, lit by the first.
    struct Pair;

    impl LightTransport for Pair {
        type Sent = f32;
        type Received = f32;

        fn senders(&self) -> usize {
            2
        }

        fn bounce(&self, sent: &[f32], receivers: Range<usize>) -> Vec<f32> {
            let all = [0.5 * sent[1], 0.25 * sent[0], sent[0]];
            all[receivers].to_vec()
        }
    }

    struct Gray(f32);

    impl Surfaces<Pair> for Gray {
        type Arriving = Vec<f32>;

        fn arriving(&self, received: Vec<f32>) -> Vec<f32> {
            received
        }

        fn reflected(&self, arriving: &Vec<f32>) -> Vec<f32> {
            arriving.iter().map(|e| self.0 * e).collect()
        }

        fn mean_irradiance(&self, arriving: &Vec<f32>) -> Vec3 {
            Vec3::splat(0.5 * (arriving[0] + arriving[1]))
        }
    }

    fn near(found: &[f32], expected: [f32; 2]) -> bool {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5)
    }

    #[test]
    fn the_series_is_the_inverse_of_one_minus_the_operator() {
        let surfaces = Gray(0.8);
        // Of x = T R (d + x), by hand: x0 = 0.4 (d1 + x1), x1 = 0.2 (d0 + x0).
        let direct = [3.0, 1.0];
        let x0 = (0.4 * direct[1] + 0.08 * direct[0]) / (1.0 - 0.08);
        let x1 = 0.2 * (direct[0] + x0);
        let after = |bounces| Series::new(&Pair, &surfaces, direct.to_vec(), None).with_bounces(bounces);
        let all = after(16);
        assert!(near(&all.received, [x0, x1]), "{:?}", all.received);
        assert!(!near(&after(2).received, [x0, x1]), "negative control: two bounces");
        assert!(near(&all.sent, [0.8 * (direct[0] + x0), 0.8 * (direct[1] + x1)]));
        assert!((Pair.bounce(&all.sent, 2..3)[0] - all.sent[0]).abs() < 1e-6, "other receivers get it at once");
        assert_eq!((all.mean_irradiance.len(), all.mean_irradiance[0].x), (17, 2.0));
        assert_eq!(after(16).energy().bounces, 16);
    }

    #[test]
    fn what_is_emitted_is_sent_once_and_not_reflected_first() {
        let black = Gray(0.0);
        let emitted = |bounces| Series::new(&Pair, &black, vec![0.0; 2], Some(vec![2.0, 0.0])).with_bounces(bounces);
        assert_eq!(emitted(1).received, [0.0, 0.5]);
        assert_eq!(emitted(3).received, [0.0, 0.5], "black surfaces end it");
        let gray = Series::new(&Pair, &Gray(1.0), vec![0.0; 2], Some(vec![2.0, 0.0])).with_bounces(2);
        assert_eq!(gray.received, [0.25, 0.5], "negative control: gray ones send it back");
    }
}
