//! All bounces as one matrix: the Neumann series of transport, `G = I + T + T² + …` (wavelet paper, 4.4).

use super::operator::Operator;

/// Most powers in the series.
pub const MOST_POWERS: usize = 10;

/// The global transport operator.
#[derive(Clone, Debug)]
pub struct GlobalTransport {
    /// The sum of the powers, the zeroth included.
    pub operator: Operator,
    /// Coefficients of each power, from the first on (Fig. 6).
    pub coefficients: Vec<usize>,
}

impl GlobalTransport {
    /// Adds powers of `transport`, each without the coefficients up to `threshold`, until none is left or [`MOST_POWERS`] are there.
    pub fn of(transport: &Operator, threshold: f32) -> Self {
        let compressed = transport.compressed(threshold);
        let mut all = Self { operator: Operator::identity(transport.functions()), coefficients: Vec::new() };
        let mut power = compressed.clone();
        while !power.is_empty() && all.coefficients.len() < MOST_POWERS {
            all.operator = all.operator.plus(&power);
            all.coefficients.push(power.len());
            // The sparser matrix goes first; powers of one matrix commute.
            power = compressed.after(&power, threshold);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::operator::{
        TransportCoefficient,
        tests::{differ, random},
    };
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_series_is_the_inverse_of_one_minus_the_operator() {
        let (_, transport) = random(12, 1);
        let sent: Vec<Vec3> = (0..12).map(|i| Vec3::new(1.0, i as f32, 0.5)).collect();
        let error = |threshold: f32| {
            let all = GlobalTransport::of(&transport, threshold);
            let light = all.operator.apply(&sent);
            let reflected = transport.apply(&light);
            let back: Vec<Vec3> = light.iter().zip(reflected).map(|(light, reflected)| *light - reflected).collect();
            (differ(&back, &sent), all.coefficients)
        };
        let (exact, powers) = error(0.0);
        assert!(exact < 0.01, "{exact}");
        assert_eq!(powers, [144; MOST_POWERS]);
        let (coarse, powers) = error(0.03);
        assert!(coarse > 0.1, "negative control: {coarse}");
        assert!(powers.len() < MOST_POWERS && powers.is_sorted_by(|a, b| a >= b), "{powers:?}");
    }

    #[test]
    fn half_of_the_light_in_each_bounce_makes_twice_the_light() {
        let (basis, _) = random(1, 3);
        let function = basis.functions()[0];
        let half = TransportCoefficient { receiver: function, sender: function, value: Vec3::splat(0.5) };
        let all = GlobalTransport::of(&Operator::of(vec![half]).1, 1e-6).operator.apply(&[Vec3::ONE])[0];
        assert!((all - 2.0).abs().max_element() < 1e-3, "{all}");
    }
}
