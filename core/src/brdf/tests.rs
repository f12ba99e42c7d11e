//! Known answers for all models: reciprocity, energy, agreement of sampling and density, and of filtering and means.

use super::*;
use crate::{
    material::Material,
    sphere::{cosine_direction, fibonacci_directions, frame_around, uniform_direction},
};

/// Each model with settings from its list: parameters set at random between their bounds, some at a bound.
fn models() -> Vec<(String, SurfaceBrdf)> {
    let mut all = Vec::new();
    for &model in BrdfModel::ALL {
        let mut random = fastrand::Rng::with_seed(7);
        for case in 0..6 {
            let mut parameters = Parameters::default();
            for p in material(model, Parameters::default()).own_parameters() {
                let [low, high] = p.slider;
                let mut number = || match random.u8(..5) {
                    0 => low,
                    1 => high,
                    _ => low + (high - low) * random.f32(),
                };
                let numbers = Vec3::new(number(), number(), number());
                // Widths that the grids of these tests resolve.
                let numbers = match p.name {
                    name if name.ends_with("roughness") => 0.35 + 0.65 * numbers,
                    name if name.ends_with("anisotropy") => 0.7 * numbers,
                    _ => numbers,
                };
                let value = if p.is_color() { Value::Color(numbers) } else { Value::Number(numbers.x) };
                parameters.set(p.name, value);
            }
            all.push((format!("{} {case} {parameters:?}", model.key()), brdf_of(model, &parameters)));
        }
    }
    all
}

fn material(model: BrdfModel, parameters: Parameters) -> Material {
    Material { model, file: example_file(model), parameters, ..Default::default() }
}

fn brdf_of(model: BrdfModel, parameters: &Parameters) -> SurfaceBrdf {
    material(model, parameters.clone()).plain_brdf()
}

/// The share of uniform light reflected to `wo`, by reciprocity the albedo for light from `wo`.
fn furnace(brdf: &SurfaceBrdf, wo: Vec3) -> Vec3 {
    let n = 256;
    let value = |(u, v)| {
        let wi = cosine_direction(u, v);
        brdf.as_brdf().brdf_cos(wi, wo) / (wi.z / std::f32::consts::PI)
    };
    grid(n).map(value).sum::<Vec3>() / (n * n) as f32
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
                assert!((forth - back).length() <= 3e-3 * forth.length() + 1e-5, "{name}: {forth} and {back}");
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
fn no_model_reflects_more_than_it_receives() {
    for (name, brdf) in models() {
        for wo in outgoing() {
            let albedo = furnace(&brdf, wo);
            // The loss of a lobe of two widths is a mean of the losses of both.
            assert!(albedo.max_element() <= 1.015, "{name}, wo {wo}: {albedo}");
            assert!((1.5 * albedo).max_element() > 0.01, "{name}");
        }
    }
}

/// White surfaces of energy-preserving models are invisible in uniform light.
#[test]
fn white_surfaces_reflect_all_light() {
    let white = |p: Parameters| p.with("base_color", Vec3::ONE);
    let ggx = |roughness: f32, metalness: f32| {
        white(Parameters::default()).with("roughness", roughness).with("metalness", metalness)
    };
    let pbr = |roughness: f32, metalness: f32, coat: f32, fuzz: f32| {
        let p = white(Parameters::default()).with("specular_roughness", roughness).with("base_metalness", metalness);
        p.with("coat_weight", coat).with("coat_roughness", 0.4).with("coat_darkening", 0.0).with("fuzz_weight", fuzz)
    };
    let mut cases = vec![(BrdfModel::Lambert, white(Parameters::default()), 0.002)];
    for roughness in [0.0, 0.5, 1.0] {
        let parameters = white(Parameters::default()).with("diffuse_roughness", roughness);
        cases.push((BrdfModel::OrenNayar, parameters, 0.01));
    }
    for roughness in [0.4, 0.7, 1.0] {
        cases.extend([0.0, 1.0].map(|metalness| (BrdfModel::Ggx, ggx(roughness, metalness), 0.01)));
        cases.extend([0.0, 1.0].map(|metalness| (BrdfModel::OpenPbr, pbr(roughness, metalness, 0.0, 0.0), 0.01)));
        // The lobe below passes coat and fuzz twice.
        cases.push((BrdfModel::OpenPbr, pbr(roughness, 0.0, 1.0, 1.0), 0.05));
    }
    for (model, parameters, bound) in cases {
        let brdf = brdf_of(model, &parameters);
        for wo in outgoing() {
            let albedo = furnace(&brdf, wo);
            assert!((albedo - 1.0).abs().max_element() < bound, "{model:?} {parameters:?} {wo}: {albedo}");
        }
    }
    let lossy = furnace(&brdf_of(BrdfModel::Beckmann, &ggx(1.0, 1.0)), Vec3::Z);
    assert!(lossy.max_element() < 0.9, "negative control: {lossy}");
}

#[test]
fn albedo_is_the_integral_at_normal_incidence() {
    for (name, brdf) in models() {
        let (albedo, integral) = (brdf.as_brdf().albedo(), furnace(&brdf, Vec3::Z));
        assert!((albedo - integral).abs().max_element() < 0.07, "{name}: {albedo}, but {integral}");
        if integral.max_element() > 0.4 {
            assert!((1.2 * albedo - integral).abs().max_element() > 0.07, "{name}: negative control");
        }
    }
}

/// Sampled directions follow their density, by the chi-square test over cells of the sphere.
#[test]
fn sampling_follows_its_density() {
    for (name, brdf) in models() {
        for wo in outgoing() {
            let b = brdf.as_brdf();
            let statistic = |sample: &dyn Fn(Vec3) -> Vec3| chi_square(b, wo, sample);
            let (found, degrees) = statistic(&|u| b.sample(wo, u));
            // Mean and deviation of the distribution: chance exceeds five deviations once in a million. The expected
            // counts are integrated on a grid, which adds a little.
            let bound = 1.15 * (degrees + 6.0 * (2.0 * degrees).sqrt());
            assert!(found < bound, "{name}, wo {wo}: {found} with {degrees} degrees of freedom");
            let (wrong, _) = statistic(&|u| uniform_direction(u.x, u.y));
            assert!(wrong > bound, "negative control: {name}, wo {wo}: {wrong}");
        }
    }
}

/// Statistic and degrees of freedom of the counts of sampled directions against the integrals of the density.
fn chi_square(brdf: &dyn Brdf, wo: Vec3, sample: &dyn Fn(Vec3) -> Vec3) -> (f32, f32) {
    const HEIGHTS: usize = 12;
    const AZIMUTHS: usize = 12;
    const SAMPLES: usize = 20_000;
    let cell = |d: Vec3| {
        let height = ((d.z * 0.5 + 0.5) * HEIGHTS as f32) as usize;
        let azimuth = ((d.y.atan2(d.x) / std::f32::consts::TAU + 0.5) * AZIMUTHS as f32) as usize;
        height.min(HEIGHTS - 1) * AZIMUTHS + azimuth.min(AZIMUTHS - 1)
    };
    let mut random = fastrand::Rng::with_seed(11);
    let (mut drawn, mut expected) = ([0.0; HEIGHTS * AZIMUTHS], [0.0; HEIGHTS * AZIMUTHS]);
    for _ in 0..SAMPLES {
        drawn[cell(sample(Vec3::new(random.f32(), random.f32(), random.f32())))] += 1.0;
    }
    let n = 600;
    for (u, v) in grid(n) {
        let wi = uniform_direction(u, v);
        expected[cell(wi)] += brdf.pdf(wi, wo) * 4.0 * std::f32::consts::PI * SAMPLES as f32 / (n * n) as f32;
    }
    // Merge cells with low counts.
    let (mut statistic, mut cells, mut rest) = (0.0, 0.0, [0.0; 2]);
    for (drawn, expected) in drawn.into_iter().zip(expected) {
        if expected < 10.0 {
            rest = [rest[0] + drawn, rest[1] + expected];
        } else {
            statistic += (drawn - expected) * (drawn - expected) / expected;
            cells += 1.0;
        }
    }
    let [drawn, expected]: [f32; 2] = rest;
    (statistic + (drawn - expected).powi(2) / expected.max(10.0), cells)
}

/// The filtered lobe is close to the mean of the lobe over the light's spread, where the plain lobe is far off.
#[test]
fn filtered_lobe_is_close_to_the_mean_over_the_spread() {
    for &model in BrdfModel::ALL.iter().filter(|model| model.parameter_for("roughness").is_some()) {
        let roughness = model.parameter_for("roughness").unwrap().name;
        let p = Parameters::default().with("base_color", Vec3::ZERO).with(roughness, 0.3);
        let brdf = brdf_of(model, &p);
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
