//! All bounces as one matrix: the Neumann series of transport, `G = I + T + T² + …` (wavelet paper, 4.4).
//!
//! Each column of a power follows from the same column of the power before, so senders are independent.

use super::operator::Operator;
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

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
        Self::of_while(transport, threshold, &|| true).expect("nothing ends it")
    }

    /// [`Self::of`] as long as `goes_on`, which is asked before each sender.
    pub fn of_while(transport: &Operator, threshold: f32, goes_on: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let transport = transport.compressed(threshold);
        let column = |sender: usize| goes_on().then(|| Column::of(&transport, sender, threshold));
        let columns: Option<Vec<Column>> = (0..transport.functions()).into_par_iter().map(column).collect();
        let columns = columns?;
        let mut coefficients: Vec<usize> =
            (0..MOST_POWERS).map(|power| columns.iter().filter_map(|column| column.powers.get(power)).sum()).collect();
        coefficients.truncate(coefficients.iter().position(|&count| count == 0).unwrap_or(MOST_POWERS));
        let operator = Operator::of_columns(columns.into_iter().map(|column| column.sum).collect());
        Some(Self { operator, coefficients })
    }
}

/// All bounces of the light of a sender.
pub struct Column {
    /// Receivers and coefficients, in ascending order.
    pub sum: Vec<(u32, Vec3)>,
    /// Coefficients of each power, from the first on.
    powers: Vec<usize>,
}

impl Column {
    /// That of a sender, by one bounce that is compressed with the same threshold.
    pub fn of(transport: &Operator, sender: usize, threshold: f32) -> Self {
        let mut sums = FxHashMap::from_iter([(sender as u32, Vec3::ONE)]);
        let mut power = vec![(sender as u32, Vec3::ONE)];
        let mut powers = Vec::new();
        while powers.len() < MOST_POWERS {
            power = transport.after_column(&power, threshold);
            if power.is_empty() {
                break;
            }
            powers.push(power.len());
            power.iter().for_each(|(receiver, value)| *sums.entry(*receiver).or_insert(Vec3::ZERO) += *value);
        }
        let mut sum: Vec<_> = sums.into_iter().collect();
        sum.sort_unstable_by_key(|(receiver, _)| *receiver);
        Self { sum, powers }
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
