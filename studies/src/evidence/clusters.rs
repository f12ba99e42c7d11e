//! Fig. 5: clusters of the light tree on the sphere, by metric.

use super::{
    Measurement,
    cases::{Bakes, Case, TREES},
    notebook::Notebook,
};
use crate::report::figure;
use anyhow::Result;
use glam::{Mat2, Vec2, Vec3};
use lapidary_core::{
    image::Image,
    light_tree::{LightTree, TreeKind},
    sphere::{GOLDEN_TURN, fibonacci_directions, frame_around},
};
use lapidary_interchange::image;
use maud::{Markup, html};
use rayon::prelude::*;
use serde::Serialize;

/// Depth of the shown nodes; the paper's "9th level".
const DEPTH: u32 = 9;
/// Side of a hemisphere's picture in pixels.
const DISC: u32 = 320;

/// Figures of one metric.
#[derive(Serialize)]
struct Clusters {
    metric: TreeKind,
    beta: f32,
    depth: u32,
    clusters: usize,
    /// Half-angle of the cone that contains most of a cluster's samples, averaged.
    mean_radius_degrees: f64,
    /// Median ratio of a cluster's length to its width.
    median_elongation: f64,
    mean_visibility_cut: f64,
    png: String,
}

/// Draws and measures the clusters of all trees of a scene.
///
/// # Errors
/// An unwritable folder.
pub fn record(measurement: &Measurement, case: &Case, bakes: &Bakes, notebook: &mut Notebook) -> Result<()> {
    let nearest = nearest_samples(measurement.scale.lights);
    let mut all = Vec::new();
    for ((tree, beta), dataset) in TREES.into_iter().zip(&bakes.datasets) {
        let depth = DEPTH.min(dataset.tree.height());
        let png = format!("fig5-{}.png", label(tree).replace(' ', "-"));
        image::write(&picture(&nearest, &dataset.tree, depth), &measurement.out.join(&png))?;
        let shape = Shape::of(&dataset.tree, depth);
        all.push(Clusters {
            metric: tree,
            beta,
            depth,
            clusters: 1 << depth,
            mean_radius_degrees: shape.mean_radius_degrees,
            median_elongation: shape.median_elongation,
            mean_visibility_cut: dataset.report.mean_cut,
            png,
        });
    }
    notebook.record("fig5_clusters", "Fig. 5: clusters of the light tree", markup(&case.name, &all), &all)
}

fn markup(scene: &str, all: &[Clusters]) -> Markup {
    html! {
        p {
            "Samples of the environment of the scene “" (scene) "”, colored by the node of depth " (DEPTH) " that they lie in: \
             the upper hemisphere seen from above, and the lower one from below, both with equal areas. Samples that no vertex \
             sees are clustered at random by visibility alone."
        }
        div.grid.three {
            @for clusters in all {
                (figure("", &clusters.png, [2 * DISC, DISC], label(clusters.metric), caption(clusters)))
            }
        }
    }
}

fn caption(clusters: &Clusters) -> Markup {
    html! {
        b { (label(clusters.metric)) ", beta " (clusters.beta) }
        "mean radius " (format!("{:.1}", clusters.mean_radius_degrees)) "°, median length to width "
        (format!("{:.2}", clusters.median_elongation)) br;
        "mean visibility cut " (format!("{:.0}", clusters.mean_visibility_cut)) " nodes"
    }
}

/// Display name of a metric.
pub fn label(tree: TreeKind) -> &'static str {
    match tree {
        TreeKind::Geometric => "geometric",
        TreeKind::DataDriven => "data-driven",
        TreeKind::Mixed => "mixed",
    }
}

/// Sizes and elongations of clusters.
struct Shape {
    mean_radius_degrees: f64,
    median_elongation: f64,
}

impl Shape {
    fn of(tree: &LightTree, depth: u32) -> Self {
        let nodes = 1_usize << depth..2 << depth;
        let radii: f64 = nodes.clone().map(|i| f64::from(tree.radii()[i])).sum();
        let leaves = tree.leaf_directions().chunks(tree.len() >> depth);
        let mut elongations: Vec<f64> = leaves.map(elongation).collect();
        elongations.sort_unstable_by(f64::total_cmp);
        let median_elongation = elongations[elongations.len() / 2];
        Self { mean_radius_degrees: (radii / nodes.len() as f64).to_degrees(), median_elongation }
    }
}

/// Length of a cluster over its width: square roots of the variances of its directions along the principal axes. One if there are
/// too few directions for a width.
fn elongation(directions: &[Vec3]) -> f64 {
    let mean = directions.iter().sum::<Vec3>().normalize_or(Vec3::Y);
    let frame = frame_around(mean);
    let flat = |d: &Vec3| Vec2::new(frame.x_axis.dot(*d), frame.y_axis.dot(*d));
    let center = directions.iter().map(flat).sum::<Vec2>() / directions.len() as f32;
    let covariance = directions.iter().map(flat).fold(Mat2::ZERO, |sum, p| {
        let d = p - center;
        sum + Mat2::from_cols(d * d.x, d * d.y)
    });
    let (trace, determinant) =
        (f64::from(covariance.x_axis.x + covariance.y_axis.y), f64::from(covariance.determinant()));
    let root = (0.25 * trace * trace - determinant).max(0.0).sqrt();
    let (long, short) = (0.5 * trace + root, 0.5 * trace - root);
    if short > 1e-12 { (long / short).sqrt() } else { 1.0 }
}

/// The sample nearest to each pixel of both hemispheres, side by side; `None` outside.
fn nearest_samples(lights: usize) -> Vec<Option<u32>> {
    let samples = fibonacci_directions(lights);
    let pixel = |i: u32| {
        let (x, y) = (i % (2 * DISC), i / (2 * DISC));
        let direction = hemisphere(x % DISC, y, x < DISC)?;
        let nearer = |best: (f32, u32), (s, sample): (usize, &Vec3)| {
            let cosine = direction.dot(*sample);
            if cosine > best.0 { (cosine, s as u32) } else { best }
        };
        Some(samples.iter().enumerate().fold((-1.0, 0), nearer).1)
    };
    (0..2 * DISC * DISC).into_par_iter().map(pixel).collect()
}

/// Direction of a pixel by Lambert's equal-area projection of one hemisphere.
fn hemisphere(x: u32, y: u32, upper: bool) -> Option<Vec3> {
    let at = |i: u32| (2.0 * i as f32 + 1.0) / DISC as f32 - 1.0;
    let (u, v) = (at(x), at(y));
    let r_sq = u * u + v * v;
    let height = if upper { 1.0 - r_sq } else { r_sq - 1.0 };
    let stretch = (2.0 - r_sq).max(0.0).sqrt();
    (r_sq < 1.0).then(|| Vec3::new(u * stretch, height, v * stretch))
}

/// Each pixel in its cluster's color, with dark lines between clusters.
fn picture(nearest: &[Option<u32>], tree: &LightTree, depth: u32) -> Image {
    let mut cluster_of_sample = vec![0_u32; tree.len()];
    let shift = tree.height() - depth;
    tree.order().iter().enumerate().for_each(|(leaf, &s)| cluster_of_sample[s as usize] = leaf as u32 >> shift);
    let cluster = |x: u32, y: u32| nearest[(y * 2 * DISC + x) as usize].map(|s| cluster_of_sample[s as usize]);
    Image::from_fn([2 * DISC, DISC], |x, y| {
        let Some(own) = cluster(x, y) else { return Vec3::splat(0.01) };
        let differs = |x: u32, y: u32| x < 2 * DISC && y < DISC && cluster(x, y).is_some_and(|other| other != own);
        if differs(x + 1, y) || differs(x, y + 1) { Vec3::splat(0.02) } else { color(own) }
    })
}

/// Very different colors for neighbors in the tree's order.
fn color(cluster: u32) -> Vec3 {
    let hue = (cluster as f32 * GOLDEN_TURN).fract();
    let wave = |shift: f32| 0.5 + 0.5 * (std::f32::consts::TAU * (hue + shift)).cos();
    let value = 0.35 + 0.3 * (cluster as f32 * 0.754_877_7).fract();
    Vec3::new(wave(0.0), wave(0.667), wave(0.333)) * value + 0.05
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_clusters_are_told_from_round_ones() {
        let geometric = LightTree::geometric(4096).unwrap();
        let round = Shape::of(&geometric, 6);
        // Bands of equal height: 64 samples each around the whole sphere.
        let bands = Shape::of(&LightTree::from_order((0..4096).collect()).unwrap(), 6);
        assert!(round.median_elongation < 2.0, "{}", round.median_elongation);
        assert!(bands.mean_radius_degrees > 3.0 * round.mean_radius_degrees, "negative control");
        let strip: Vec<Vec3> =
            (0..64).map(|i| Vec3::new((i % 16) as f32 * 0.01, 1.0, (i / 16) as f32 * 0.01).normalize()).collect();
        assert!((elongation(&strip) - 4.0).abs() < 0.5, "16 by 4: {}", elongation(&strip));
    }

    #[test]
    fn hemispheres_have_equal_areas_and_all_samples() {
        let nearest = nearest_samples(256);
        let mut seen = vec![0; 256];
        nearest.iter().flatten().for_each(|&s| seen[s as usize] += 1);
        let disc = std::f64::consts::PI / 4.0 * f64::from(DISC * DISC);
        let expected = 2.0 * disc / 256.0;
        let worst = seen.iter().map(|&n| (f64::from(n) / expected - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 0.35, "{worst}");
        let outside = nearest.iter().filter(|n| n.is_none()).count() as f64;
        assert!((outside / (f64::from(2 * DISC * DISC) - 2.0 * disc) - 1.0).abs() < 0.02);
    }
}
