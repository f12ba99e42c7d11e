//! Tables against their source BRDF, and invalid files.

use super::{file::FILE_BYTES, *};
use crate::{
    brdf::{Brdf, Ggx, GgxParameters},
    simd::Vec3x8,
    sphere::{cosine_direction, frame_around},
};
use wide::f32x8;

fn ggx(roughness: f32) -> Ggx {
    let base_color = Vec3::new(0.5, 0.3, 0.1);
    Ggx::new(&GgxParameters { base_color, roughness, metalness: 0.3, ..Default::default() })
}

fn tabulated(roughness: f32) -> Measured {
    let ggx = ggx(roughness);
    Measured::tabulated(|wi, wo| ggx.brdf_cos(wi, wo) / wi.z)
}

/// Relative RMSE over pairs of directions, half of which are near the mirror's.
fn difference(table: &Measured, ggx: &Ggx) -> f32 {
    let mut random = fastrand::Rng::with_seed(3);
    let (mut error, mut sum) = (0.0, 0.0);
    for i in 0..4000 {
        let wo = cosine_direction(random.f32(), random.f32());
        let near = Vec3::new(random.f32() - 0.5, random.f32() - 0.5, random.f32() - 0.5) * 0.3;
        let wi = match i % 2 {
            0 => cosine_direction(random.f32(), random.f32()),
            _ => (Vec3::new(-wo.x, -wo.y, wo.z) + near).normalize(),
        };
        if wi.z > 0.05 && wo.z > 0.05 {
            let expected = ggx.brdf_cos(wi, wo);
            error += (table.value(wi, wo, 0.0, [0.0; 3]) * wi.z - expected).length_squared();
            sum += expected.length_squared();
        }
    }
    (error / sum).sqrt()
}

#[test]
fn a_table_has_the_values_of_what_it_is_of() {
    for roughness in [0.2, 0.4, 0.8] {
        let table = tabulated(roughness);
        let (same, other) = (difference(&table, &ggx(roughness)), difference(&table, &ggx(1.1 * roughness)));
        assert!(same < 0.01, "{roughness}: {same}");
        assert!(other > 0.03, "negative control: {roughness}: {other}");
    }
}

#[test]
fn its_lobe_is_as_wide_as_that_of_what_it_is_of() {
    for roughness in [0.1_f32, 0.3, 0.6] {
        let width = tabulated(roughness).lobe().width();
        let alpha = roughness * roughness;
        assert!((width / alpha - 1.0).abs() < 0.2, "{roughness}: {width}, not {alpha}");
    }
    let diffuse = Measured::tabulated(|_, _| Vec3::splat(0.2));
    assert_eq!(diffuse.lobe().width(), 0.0);
    assert!((diffuse.lobe().albedo_at(1.0) - 0.2 * std::f32::consts::PI).length() < 0.01);
    assert!(diffuse.remarks("a").iter().all(|remark| !remark.contains("reflects up to")));
    let bright = Measured::tabulated(|_, _| Vec3::splat(0.5));
    assert!(bright.remarks("a.binary").iter().any(|remark| remark.starts_with("a.binary reflects up to 1.57 times")));
    assert!(bright.lobe().albedo_at(1.0).x > 1.5, "it is told, not clamped");
}

/// The blurred table is near the mean over the directions of a light, also far from the peak and toward the horizon.
#[test]
fn it_is_blurred_by_the_extent_of_lights() {
    for (roughness, kappa) in [(0.2, 400.0_f32), (0.3, 100.0), (0.3, 1000.0)] {
        let (table, ggx) = (tabulated(roughness), ggx(roughness));
        for cosine in [0.9_f32, 0.4] {
            let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
            let (mut blurred, mut plain, mut total) = (0.0, 0.0, 0.0);
            for (along, across) in [(0.0, 0.0), (0.0, 0.1), (0.0, 0.2), (0.1, 0.0), (0.2, 0.1), (-0.1, 0.1)] {
                let axis = (mirror + across * Vec3::Y + along * Vec3::Z).normalize();
                let mean = mean(&ggx, axis, wo, kappa);
                blurred += (table.value(axis, wo, 1.0 / kappa, [0.0; 3]).x * axis.z - mean).abs();
                plain += (table.value(axis, wo, 0.0, [0.0; 3]).x * axis.z - mean).abs();
                total += mean;
            }
            assert!(blurred < 0.15 * total, "{roughness} {kappa} {cosine}: {blurred} of {total}");
            assert!(plain > 2.0 * blurred, "negative control: {roughness} {kappa} {cosine}: {plain} of {total}");
        }
    }
}

/// Mean over a von Mises-Fisher lobe of light.
fn mean(ggx: &Ggx, axis: Vec3, wo: Vec3, kappa: f32) -> f32 {
    let (n, frame) = (64, frame_around(axis));
    let value = |i: usize| {
        let (u, v) = (((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32);
        let cos = 1.0 + (u + (1.0 - u) * (-2.0 * kappa).exp()).ln() / kappa;
        let (s, c) = (std::f32::consts::TAU * v).sin_cos();
        let r = (1.0 - cos * cos).max(0.0).sqrt();
        let wi = frame * Vec3::new(r * c, r * s, cos);
        ggx.brdf_cos_x8(Vec3x8::splat(wi), wo, f32x8::ZERO).lane(0).x
    };
    (0..n * n).map(value).sum::<f32>() / (n * n) as f32
}

#[test]
fn files_and_packed_tables_are_read_as_they_were_written() {
    let table = tabulated(0.4);
    let file = table.to_merl();
    assert_eq!(file.len(), FILE_BYTES);
    let read = Measured::from_merl(&file).unwrap();
    assert_eq!((read.hash(), read.filled()), (table.hash(), 0));
    assert_eq!(Measured::from_packed(&table.packed()).unwrap().hash(), table.hash());
    assert_ne!(tabulated(0.41).hash(), table.hash(), "negative control");
}

/// A file with one entry replaced.
fn with(file: &[u8], channel: usize, index: usize, number: f64) -> Vec<u8> {
    let mut changed = file.to_vec();
    changed[12 + 8 * (channel * ENTRIES + index)..][..8].copy_from_slice(&number.to_le_bytes());
    changed
}

#[test]
fn what_was_not_measured_is_filled_in_and_counted() {
    let file = tabulated(0.4).to_merl();
    let whole = Measured::from_merl(&file).unwrap();
    let index = (20 * 90 + 30) * 180 + 77;
    let holed = Measured::from_merl(&with(&with(&file, 1, index, -1.0), 0, index + 5, -0.5)).unwrap();
    assert_eq!(holed.filled(), 2);
    let [before, after] = [&whole, &holed].map(|t| t.levels()[0].entries[index]);
    assert!(after[1] > 0.0 && (before[1] - after[1]).abs() < 0.2 * before[1], "{before:?} {after:?}");
    assert!(holed.remarks("x")[0].starts_with("2 of 1458000 entries of x were not measured"));
    assert!(tabulated(0.4).filled() > ENTRIES / 20, "what is below the horizon");
}

#[test]
fn a_broken_file_is_an_error_that_says_what_is_wrong() {
    let file = tabulated(0.4).to_merl();
    let error = |bytes: &[u8]| Measured::from_merl(bytes).unwrap_err();
    assert_eq!(error(&file[..5]), MeasuredError::Short(5));
    assert!(matches!(error(&file[..FILE_BYTES - 1]), MeasuredError::Length { .. }));
    assert!(matches!(error(&[&file[..], &[0]].concat()), MeasuredError::Length { .. }));
    let mut other = file.clone();
    other[8..12].copy_from_slice(&360_i32.to_le_bytes());
    assert_eq!(
        error(&other).to_string(),
        "its table is 90 x 90 x 360, not 90 x 90 x 180 as MERL BRDFs have; choose another file"
    );
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e12] {
        assert!(matches!(error(&with(&file, 2, 7, number)), MeasuredError::Value { index: 7, .. }), "{number}");
    }
    let mut empty = file[..12].to_vec();
    empty.extend((0..3 * ENTRIES).flat_map(|_| (-1.0_f64).to_le_bytes()));
    assert_eq!(error(&empty), MeasuredError::Empty);
    assert!(Measured::from_packed(&[0; 6]).is_err());
}

/// Index of an entry by the method of the database's own reader, in double precision.
fn index_of(wi: Vec3, wo: Vec3) -> usize {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (wi, wo) = (wi.as_dvec3().normalize(), wo.as_dvec3().normalize());
    let half = (wi + wo).normalize();
    let (theta_h, phi_h) = (half.z.acos(), half.y.atan2(half.x));
    let difference = glam::DQuat::from_rotation_y(-theta_h) * (glam::DQuat::from_rotation_z(-phi_h) * wi);
    let (theta_d, phi_d) = (difference.z.acos(), difference.y.atan2(difference.x));
    let phi_d = if phi_d < 0.0 { phi_d + PI } else { phi_d };
    let h = (theta_h / FRAC_PI_2 * 90.0 * 90.0).sqrt() as usize;
    let d = (theta_d / FRAC_PI_2 * 90.0) as usize;
    let p = (phi_d / PI * 180.0) as usize;
    p.min(179) + d.min(89) * 180 + h.min(89) * 180 * 90
}

#[test]
fn entries_are_where_the_database_has_them() {
    let table = tabulated(0.5);
    let mut checked = 0;
    for index in (0..ENTRIES).step_by(9973) {
        let [wi, wo] = super::file::directions(index);
        let turned = |d: Vec3| glam::Quat::from_rotation_z(0.7) * d;
        if wi.z > 0.05 && wo.z > 0.05 {
            assert_eq!(index_of(turned(wi), turned(wo)), index);
            let entry = Vec3::from_array(table.levels()[0].entries[index]);
            let found = table.value(turned(wi), turned(wo), 0.0, [0.0; 3]);
            assert!((found - entry).length() <= 0.01 * entry.length(), "{index}: {found}, not {entry}");
            checked += 1;
        }
    }
    assert!(checked > 50);
    let [wi, wo] = super::file::directions(50 * 90 * 180 + 20 * 180 + 30);
    assert_ne!(index_of(wo.with_x(-wo.x), wi), 50 * 90 * 180 + 20 * 180 + 30, "negative control");
}
