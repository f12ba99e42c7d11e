//! Haar wavelets on squares, for comparison with cuts (paper, section 5 and Fig. 6a).
//!
//! The nonstandard two-dimensional basis (Stollnitz, DeRose and Salesin, *Wavelets for Computer Graphics*, 1996). It is
//! orthonormal: squared differences of functions equal those of their coefficients, so the best approximation by a number of terms
//! keeps the largest.

/// Replaces the `side * side` values of a square, row by row, by their coefficients; `side` is a power of two. The mean of the
/// whole comes first, then details of ever smaller squares in the quarters around it.
///
/// # Panics
/// If the number of values differs, or `side` is not a power of two.
pub fn forward(values: &mut [f32], side: usize) {
    check(values, side);
    let mut size = side;
    while size > 1 {
        step(values, side, size, |half, x, y| {
            let (x2, y2) = (2 * x, 2 * y);
            ([[x2, y2], [x2 + 1, y2], [x2, y2 + 1], [x2 + 1, y2 + 1]], quarters(half, x, y))
        });
        size /= 2;
    }
}

fn check(values: &[f32], side: usize) {
    assert!(side.is_power_of_two(), "the side is a power of two");
    assert_eq!(values.len(), side * side, "a square of values");
}

/// Indices of the mean and details of the square at (x, y) of a level.
fn quarters(half: usize, x: usize, y: usize) -> [[usize; 2]; 4] {
    [[x, y], [half + x, y], [x, half + y], [half + x, half + y]]
}

/// One level: `places` returns, for each square of two by two, the indices to read and write. The matrix is its own inverse.
fn step(
    values: &mut [f32],
    side: usize,
    size: usize,
    places: impl Fn(usize, usize, usize) -> ([[usize; 2]; 4], [[usize; 2]; 4]),
) {
    let half = size / 2;
    let mut result = vec![0.0; size * size];
    for (x, y) in (0..half).flat_map(|y| (0..half).map(move |x| (x, y))) {
        let (from, to) = places(half, x, y);
        let [a, b, c, d] = from.map(|[x, y]| values[y * side + x]);
        let new = [a + b + c + d, a - b + c - d, a + b - c - d, a - b - c + d].map(|sum| 0.5 * sum);
        for ([x, y], value) in to.into_iter().zip(new) {
            result[y * size + x] = value;
        }
    }
    for (y, row) in result.chunks(size).enumerate() {
        values[y * side..][..size].copy_from_slice(row);
    }
}

/// Error from keeping only the largest coefficients.
#[derive(Clone, Debug)]
pub struct Nonlinear {
    /// Squared error with the `k` largest coefficients, for each `k`; decreases to 0.
    squared_errors: Vec<f64>,
}

impl Nonlinear {
    /// Prepares the coefficients of one function, in any order.
    pub fn new(coefficients: &[f32]) -> Self {
        let mut squares: Vec<f64> = coefficients.iter().map(|&c| f64::from(c) * f64::from(c)).collect();
        squares.sort_unstable_by(f64::total_cmp);
        let mut sum = 0.0;
        let mut squared_errors = vec![0.0];
        squared_errors.extend(squares.iter().map(|square| {
            sum += square;
            sum
        }));
        squared_errors.reverse();
        Self { squared_errors }
    }

    /// Squared error, summed over all values, with the `terms` largest coefficients.
    #[cfg(test)]
    pub fn squared_error(&self, terms: usize) -> f64 {
        self.squared_errors.get(terms).copied().unwrap_or(0.0)
    }

    /// Fewest coefficients with at most this squared error.
    pub fn terms(&self, squared_error: f64) -> usize {
        self.squared_errors.partition_point(|&error| error > squared_error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inverse of [`forward`].
    fn inverse(coefficients: &mut [f32], side: usize) {
        check(coefficients, side);
        let mut size = 2;
        while size <= side {
            step(coefficients, side, size, |half, x, y| {
                let (x2, y2) = (2 * x, 2 * y);
                (quarters(half, x, y), [[x2, y2], [x2 + 1, y2], [x2, y2 + 1], [x2 + 1, y2 + 1]])
            });
            size *= 2;
        }
    }

    fn random(side: usize, seed: u64) -> Vec<f32> {
        let mut rng = fastrand::Rng::with_seed(seed);
        (0..side * side).map(|_| rng.f32() - 0.3).collect()
    }

    fn energy(values: &[f32]) -> f64 {
        values.iter().map(|&v| f64::from(v) * f64::from(v)).sum()
    }

    fn transformed(values: &[f32], side: usize) -> Vec<f32> {
        let mut coefficients = values.to_vec();
        forward(&mut coefficients, side);
        coefficients
    }

    #[test]
    fn energy_is_kept_and_values_come_back() {
        for side in [1, 2, 4, 32] {
            let values = random(side, side as u64);
            let mut coefficients = transformed(&values, side);
            assert!((energy(&coefficients) / energy(&values) - 1.0).abs() < 1e-5, "Parseval at {side}");
            inverse(&mut coefficients, side);
            let worst = values.iter().zip(&coefficients).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-5, "{side}: {worst}");
        }
        let mut scaled = transformed(&random(8, 1), 8);
        scaled[5] *= 1.01;
        assert!((energy(&scaled) / energy(&random(8, 1)) - 1.0).abs() > 1e-6, "negative control");
    }

    #[test]
    fn a_constant_is_one_coefficient_and_one_value_needs_a_chain() {
        let constant = transformed(&[0.5; 256], 16);
        assert!((constant[0] - 8.0).abs() < 1e-5, "16 * 0.5: {}", constant[0]);
        assert!(constant[1..].iter().all(|&c| c == 0.0));
        assert_eq!(Nonlinear::new(&constant).terms(0.0), 1);
        let mut delta = vec![0.0; 256];
        delta[77] = 1.0;
        assert_eq!(
            Nonlinear::new(&transformed(&delta, 16)).terms(0.0),
            1 + 3 * 4,
            "the mean, and three details a level"
        );
    }

    #[test]
    fn half_a_square_is_two_coefficients_and_a_slanted_edge_is_more() {
        let half = |slant: usize| {
            let value = |i: usize| if i % 16 >= 8 + slant * (i / 16) / 8 { 1.0 } else { 0.0 };
            (0..256).map(value).collect::<Vec<f32>>()
        };
        assert_eq!(Nonlinear::new(&transformed(&half(0), 16)).terms(0.0), 2);
        assert!(Nonlinear::new(&transformed(&half(3), 16)).terms(0.0) > 8, "negative control");
    }

    #[test]
    fn the_largest_coefficients_lose_as_much_as_the_function_they_make() {
        let values = random(16, 3);
        let coefficients = transformed(&values, 16);
        let nonlinear = Nonlinear::new(&coefficients);
        let mut order: Vec<usize> = (0..256).collect();
        order.sort_by(|&a, &b| coefficients[b].abs().total_cmp(&coefficients[a].abs()));
        for terms in [0, 1, 40, 255, 256] {
            let mut kept = vec![0.0; 256];
            order[..terms].iter().for_each(|&i| kept[i] = coefficients[i]);
            inverse(&mut kept, 16);
            let error: f64 = values.iter().zip(&kept).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            let expected = nonlinear.squared_error(terms);
            assert!((error - expected).abs() < 1e-4, "{terms}: {error} for {expected}");
            assert!(nonlinear.terms(expected) <= terms && nonlinear.terms(expected - 1e-3) >= terms.min(1));
        }
        assert!(nonlinear.squared_error(40) < nonlinear.squared_error(39), "negative control");
    }
}
