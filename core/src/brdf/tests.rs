//! Known answers for all models: reciprocity, energy, agreement of sampling and density, and of filtering and means.

use super::*;
use crate::sphere::{cosine_direction, fibonacci_directions, frame_around, uniform_direction};

fn models() -> Vec<(String, SurfaceBrdf)> {
    let mut all = Vec::new();
    for model in [BrdfModel::Lambert, BrdfModel::Ggx, BrdfModel::Ward] {
        for (roughness, metalness, anisotropy) in [(0.3, 0.0, 0.0), (0.6, 1.0, 0.0), (0.5, 0.5, 0.8), (1.0, 0.0, -0.5)]
        {
            let p = GgxParameters {
                base_color: Vec3::new(0.9, 0.6, 0.3),
                roughness,
                metalness,
                anisotropy,
                ..Default::default()
            };
            all.push((
                format!("{model:?} {roughness} {metalness} {anisotropy}"),
                SurfaceBrdf::new(model, &model.values(&p.into())),
            ));
        }
    }
    all
}

fn outgoing() -> [Vec3; 3] {
    [Vec3::Z, Vec3::new(0.5, 0.2, 0.8).normalize(), Vec3::new(-0.8, 0.4, 0.3).normalize()]
}

/// Stratified points of the unit square.
fn grid(n: usize) -> impl Iterator<Item = (f32, f32)> {
    (0..n * n).map(move |i| (((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32))
}

#[test]
fn values_are_reciprocal_and_not_negative() {
    for (name, brdf) in models() {
        for wo in outgoing() {
            for (u, v) in grid(12) {
                let wi = cosine_direction(u, v);
                let forth = brdf.as_brdf().brdf_cos(wi, wo) / wi.z;
                let back = brdf.as_brdf().brdf_cos(wo, wi) / wo.z;
                assert!(forth.min_element() >= 0.0, "{name}");
                assert!((forth - back).length() <= 2e-3 * forth.length() + 1e-5, "{name}: {forth} and {back}");
            }
        }
    }
}

#[test]
fn nothing_is_reflected_from_or_to_below_the_horizon() {
    for (name, brdf) in models() {
        let below = Vec3::new(0.3, 0.1, -0.9).normalize();
        assert_eq!(brdf.as_brdf().brdf_cos(below, Vec3::Z), Vec3::ZERO, "{name}");
        assert_eq!(brdf.as_brdf().brdf_cos(Vec3::Z, below), Vec3::ZERO, "{name}");
    }
}

#[test]
fn albedo_is_at_most_one_and_that_of_lambert_exact() {
    for (name, brdf) in models() {
        for wo in outgoing() {
            let n = 256;
            let sum: Vec3 = grid(n)
                .map(|(u, v)| {
                    let wi = cosine_direction(u, v);
                    brdf.as_brdf().brdf_cos(wi, wo) / (wi.z / std::f32::consts::PI)
                })
                .sum();
            let albedo = sum / (n * n) as f32;
            // The glTF layering (1 - F) exceeds one by a trace at grazing angles.
            assert!(albedo.max_element() <= 1.02, "{name}: {albedo}");
            if let SurfaceBrdf::Lambert(_) = brdf {
                assert!((albedo - Vec3::new(0.9, 0.6, 0.3)).length() < 1e-3, "{name}: {albedo}");
            }
        }
    }
}

/// The share of light from the normal that is reflected, by reciprocity that of the whole sky that is seen from there.
#[test]
fn albedo_is_the_integral_at_normal_incidence() {
    for (name, brdf) in models() {
        let n = 256;
        let value = |(u, v)| {
            let wi = cosine_direction(u, v);
            brdf.as_brdf().brdf_cos(wi, Vec3::Z) / (wi.z / std::f32::consts::PI)
        };
        let integral = grid(n).map(value).sum::<Vec3>() / (n * n) as f32;
        let albedo = brdf.as_brdf().albedo();
        assert!((albedo - integral).abs().max_element() < 0.06, "{name}: {albedo}, but {integral}");
        assert!((1.2 * albedo - integral).abs().max_element() > 0.06, "{name}: negative control");
    }
}

/// The density integrates to the fraction of samples, cell by cell of the sphere (a chi-square test in spirit).
#[test]
fn sampling_follows_its_density() {
    let cells = |d: Vec3| {
        ((d.z * 0.5 + 0.5) * 7.99) as usize * 8 + ((d.y.atan2(d.x) / std::f32::consts::TAU + 0.5) * 7.99) as usize
    };
    for (name, brdf) in models() {
        for wo in outgoing() {
            let b = brdf.as_brdf();
            let mut rng = fastrand::Rng::with_seed(11);
            let samples = 60_000;
            let (mut drawn, mut expected) = (vec![0.0_f32; 64], vec![0.0_f32; 64]);
            for _ in 0..samples {
                let wi = b.sample(wo, Vec3::new(rng.f32(), rng.f32(), rng.f32()));
                drawn[cells(wi)] += 1.0 / samples as f32;
            }
            let n = 450;
            for (u, v) in grid(n) {
                let wi = uniform_direction(u, v);
                expected[cells(wi)] += b.pdf(wi, wo) * 4.0 * std::f32::consts::PI / (n * n) as f32;
            }
            let worst = drawn.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.02, "{name}, wo {wo}: worst cell off by {worst}");
        }
    }
}

/// The filtered lobe is close to the mean of the lobe over the light's spread, where the plain lobe is far off.
#[test]
fn filtered_lobe_is_close_to_the_mean_over_the_spread() {
    for model in [BrdfModel::Ggx, BrdfModel::Ward] {
        let p = GgxParameters { base_color: Vec3::ZERO, roughness: 0.3, ..Default::default() };
        let brdf = SurfaceBrdf::new(model, &model.values(&p.into()));
        let wo = Vec3::new(0.4, 0.0, 0.9).normalize();
        let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
        let kappa = 100.0_f32;
        // von Mises-Fisher around the axis, by inversion.
        let cap: Vec<Vec3> = grid(64)
            .map(|(u, v)| {
                let cos = 1.0 + (u + (1.0 - u) * (-2.0 * kappa).exp()).ln() / kappa;
                let (s, c) = (std::f32::consts::TAU * v).sin_cos();
                let r = (1.0 - cos * cos).max(0.0).sqrt();
                Vec3::new(r * c, r * s, cos)
            })
            .collect();
        let (mut filtered_error, mut plain_error, mut total) = (0.0, 0.0, 0.0);
        for tilt in [0.0, 0.08, 0.16, 0.24, 0.32] {
            let axis = (mirror + tilt * Vec3::Y).normalize();
            let frame = frame_around(axis);
            let mean: f32 =
                cap.iter().map(|&d| brdf.as_brdf().brdf_cos(frame * d, wo).x).sum::<f32>() / cap.len() as f32;
            let filtered = brdf.as_brdf().brdf_cos_x8(Vec3x8::splat(axis), wo, f32x8::splat(1.0 / kappa)).lane(0).x;
            let plain = brdf.as_brdf().brdf_cos(axis, wo).x;
            filtered_error += (filtered - mean).abs();
            plain_error += (plain - mean).abs();
            total += mean;
        }
        assert!(filtered_error < 0.2 * total, "{model:?}: {filtered_error} of {total}");
        assert!(plain_error > 0.4 * total, "{model:?}: the plain lobe is not the mean: {plain_error} of {total}");
    }
}

#[test]
fn all_eight_lanes_agree_with_one() {
    let directions = fibonacci_directions(64);
    for (name, brdf) in models() {
        for chunk in directions.chunks(8) {
            let wi: [Vec3; 8] = std::array::from_fn(|i| chunk[i]);
            let eight = brdf.as_brdf().brdf_cos_x8(Vec3x8::from_array(wi), Vec3::new(0.6, 0.0, 0.8), f32x8::ZERO);
            for (i, &wi) in wi.iter().enumerate() {
                assert_eq!(eight.lane(i), brdf.as_brdf().brdf_cos(wi, Vec3::new(0.6, 0.0, 0.8)), "{name}");
            }
        }
    }
}
