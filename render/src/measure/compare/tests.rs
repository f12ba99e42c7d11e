//! Analytic values of the metrics, and errors that they must notice.

use super::*;
use lapidary_core::color::linear_from_srgb;

fn gray(value: f32) -> Image {
    Image::filled([24, 16], Vec3::splat(value))
}

fn gradient() -> Image {
    Image::from_fn([24, 16], |x, y| Vec3::new(x as f32 / 24.0, y as f32 / 16.0, 0.25))
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-5 * expected.abs().max(1.0), "{found}, not {expected}");
}

#[test]
fn equal_pictures_are_equal_by_every_metric() {
    let metrics = compare(&gradient(), &gradient()).unwrap();
    assert_eq!((metrics.rmse, metrics.rel_rmse, metrics.rel_mse, metrics.flip), (0.0, 0.0, 0.0, 0.0));
    assert_eq!((metrics.psnr, metrics.pixels, metrics.non_finite_pixels), (f64::INFINITY, 24 * 16, 0));
    assert_near(metrics.ssim, 1.0);
}

#[test]
fn linear_errors_of_constant_pictures_are_known() {
    let metrics = compare(&gray(2.5), &gray(2.0)).unwrap();
    assert_near(metrics.rmse, 0.5);
    assert_near(metrics.rel_rmse, 0.25);
    assert_near(metrics.rel_mse, 0.25 / 4.01);
}

#[test]
fn an_error_in_one_channel_counts_a_third() {
    let test = Image::filled([24, 16], Vec3::new(1.3, 1.0, 1.0));
    let metrics = compare(&test, &gray(1.0)).unwrap();
    assert_near(metrics.rmse, 0.3 / 3.0_f64.sqrt());
    assert_near(metrics.rel_mse, 0.09 / 1.01 / 3.0);
}

#[test]
fn displayed_errors_of_constant_pictures_are_known() {
    let metrics = compare(&gray(linear_from_srgb(0.6)), &gray(linear_from_srgb(0.4))).unwrap();
    assert_near(metrics.psnr, -20.0 * 0.2_f64.log10());
    // Without variance only the means count.
    let c1 = 0.01_f64.powi(2);
    assert_near(metrics.ssim, (2.0 * 0.6 * 0.4 + c1) / (0.36 + 0.16 + c1));
}

#[test]
fn what_a_display_clamps_concerns_only_the_linear_metrics() {
    let metrics = compare(&gray(3.0), &gray(2.0)).unwrap();
    assert_eq!((metrics.psnr, metrics.flip), (f64::INFINITY, 0.0));
    assert_near(metrics.rmse, 1.0);
}

#[test]
fn one_changed_pixel_is_noticed_by_every_metric() {
    let mut test = gradient();
    test.pixels[100] += 0.2;
    let metrics = compare(&test, &gradient()).unwrap();
    assert_near(metrics.rmse, (0.04_f64 / 384.0).sqrt());
    assert!(metrics.rel_rmse > 0.0 && metrics.rel_mse > 0.0 && metrics.flip > 0.0);
    assert!(metrics.psnr.is_finite() && metrics.ssim < 1.0 - 1e-4);
}

#[test]
fn relative_metrics_know_which_picture_is_the_reference() {
    let [there, back] = [compare(&gray(2.0), &gray(1.0)).unwrap(), compare(&gray(1.0), &gray(2.0)).unwrap()];
    assert_near(there.rel_rmse, 1.0);
    assert_near(back.rel_rmse, 0.5);
    assert_near(there.rel_mse / back.rel_mse, 4.01 / 1.01);
    assert_eq!(there.rmse, back.rmse);
}

#[test]
fn pixels_that_are_not_finite_are_counted_and_left_out() {
    let reference = gray(1.0);
    let mut test = gray(1.5);
    test.pixels[0].x = f32::NAN;
    test.pixels[7].z = f32::INFINITY;
    let metrics = compare(&test, &reference).unwrap();
    assert_eq!((metrics.pixels, metrics.non_finite_pixels), (24 * 16 - 2, 2));
    assert_near(metrics.rmse, 0.5);
    let swapped = compare(&reference, &test).unwrap();
    assert_eq!(swapped.non_finite_pixels, 2);
    let only_nan = compare(&gray(f32::NAN), &reference);
    assert_eq!(only_nan, Err(CompareError::NothingFinite { pixels: 24 * 16 }));
}

#[test]
fn a_pixel_that_is_not_finite_adds_no_difference_around_it() {
    let mut test = gradient();
    test.pixels[100] = Vec3::NAN;
    let metrics = compare(&test, &gradient()).unwrap();
    assert_eq!((metrics.flip, metrics.rmse, metrics.non_finite_pixels), (0.0, 0.0, 1));
    assert_near(metrics.ssim, 1.0);
}

#[test]
fn sizes_that_differ_are_an_error_that_names_both() {
    let error = compare(&gray(1.0), &Image::filled([16, 24], Vec3::ONE)).unwrap_err().to_string();
    assert!(error.contains("24 x 16") && error.contains("16 x 24") && error.contains("render both"), "{error}");
}

#[test]
fn one_pixel_is_compared_and_none_is_an_error() {
    let one = Image::filled([1, 1], Vec3::ONE);
    assert_near(compare(&Image::filled([1, 1], Vec3::ZERO), &one).unwrap().rmse, 1.0);
    for size in [[0, 0], [0, 5], [5, 0]] {
        let none = Image::filled(size, Vec3::ONE);
        assert_eq!(compare(&none, &none), Err(CompareError::Empty));
    }
}

#[test]
fn a_black_reference_gives_an_infinite_relative_error_only_if_there_is_one() {
    assert_eq!(compare(&gray(0.1), &gray(0.0)).unwrap().rel_rmse, f64::INFINITY);
    assert_eq!(compare(&gray(0.0), &gray(0.0)).unwrap().rel_rmse, 0.0);
}

#[test]
fn json_has_the_names_of_get_and_survives_infinity() {
    let metrics = compare(&gradient(), &gradient()).unwrap();
    let json = serde_json::to_value(metrics).unwrap();
    assert!(json["psnr"].is_null());
    for name in Metrics::NAMES {
        assert_eq!(json[name].as_f64().unwrap_or(f64::INFINITY), metrics.get(name).unwrap(), "{name}");
    }
    assert_eq!(json.as_object().unwrap().len(), Metrics::NAMES.len() + 1, "and the number of pixels");
    assert_eq!(metrics.get("mse"), None);
    let read: Metrics = serde_json::from_value(json).unwrap();
    assert_eq!(read, metrics);
}
