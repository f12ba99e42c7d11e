//! Errors of solid angles in cuts.

/// Sum of squares of solid angles, in steradians squared.
pub fn squared_norm(solid_angles: &[f32]) -> f64 {
    solid_angles.iter().map(|&x| f64::from(x) * f64::from(x)).sum()
}

/// Root mean square of relative errors of points, given as squared error and squared norm of the visible solid angles. Each error
/// is relative to its own norm, or to the mean norm if that is larger: errors in a dark corner matter little beside brighter
/// points.
pub fn relative_rms(points: &[(f64, f64)]) -> f64 {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len().max(1) as f64;
    let mean_norm = mean(&|&(_, norm)| norm).max(f64::MIN_POSITIVE);
    mean(&|&(error, norm)| error / norm.max(mean_norm)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_dark_points_are_shares_of_the_mean_and_others_of_their_own_norm() {
        assert_eq!(relative_rms(&[(1.0, 100.0), (4.0, 100.0)]), (0.05_f64 / 2.0).sqrt());
        let with_dark = relative_rms(&[(1.0, 100.0), (1e-6, 1e-6)]);
        assert!((with_dark - (0.01_f64 / 2.0).sqrt()).abs() < 1e-6, "{with_dark}");
        let with_bright = relative_rms(&[(1.0, 100.0), (1e4, 1e6)]);
        assert!((with_bright - (0.5 * (1.0 / 500_050.0 + 0.01_f64)).sqrt()).abs() < 1e-6, "{with_bright}");
        assert_eq!([relative_rms(&[]), relative_rms(&[(0.0, 0.0)])], [0.0; 2]);
        assert_eq!(squared_norm(&[3.0, 4.0]), 25.0);
    }
}
