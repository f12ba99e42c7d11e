//! Fig. 6a: terms that wavelets and cuts need for the same visibility at the same total error.
//!
//! Both approximate one function: visibility of the texels of a cube map, as in the paper: 6 x 128 x 128. Haar wavelets keep the
//! largest coefficients of all faces. A cut needs a complete binary tree, which six faces do not form: it is a cut of six trees,
//! one per face, by the same metrics as the light tree. For each point and sigma the wavelets get the fewest terms whose squared
//! error, summed over all texels, is at most the cut's.

use super::{
    Measurement,
    cases::{Bakes, Case, TREES},
    clusters::label,
    cube_map::{self, FACES},
    haar::{self, Nonlinear},
    notebook::Notebook,
};
use crate::report::{
    chart::{AxisScale, Chart, Line},
    table,
    text::short,
};
use anyhow::Result;
use glam::Vec3;
use lapidary_core::{
    cut::{CutCriterion, CutSelector},
    light_tree::{Features, PilotVisibility, TreeKind, cluster_order},
    ray::OPEN,
};
use maud::{Markup, html};
use serde::Serialize;

/// Divisor of a bake's pilot clusters: a cube map has three times as many directions.
const PILOT_PART: usize = 4;

/// Figures of the comparison.
#[derive(Serialize)]
struct Comparison {
    scene: String,
    cube_side: usize,
    points: usize,
    curves: Vec<Curve>,
}

/// One metric of the trees.
#[derive(Serialize)]
struct Curve {
    metric: TreeKind,
    beta: f32,
    points: Vec<Matched>,
}

/// Means over all points at one sigma.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Matched {
    sigma: f32,
    /// Root of the mean squared error over texels and points.
    rms: f64,
    cut_terms: f64,
    wavelet_terms: f64,
    /// Terms of cuts over terms of wavelets, minus one.
    excess: f64,
}

/// One point at one sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Terms {
    squared_error: f64,
    cut: usize,
    wavelets: usize,
}

/// Measures the points of a scene.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, case: &Case, bakes: &Bakes, notebook: &mut Notebook) -> Result<()> {
    let (scale, reporter) = (measurement.scale, &measurement.steps.reporter);
    let side = scale.cube_side;
    let directions = cube_map::directions(side);
    let clusters = (scale.pilot_clusters / PILOT_PART).max(1);
    let pilot = bakes.baker.geometry.pilot(&directions, clusters, reporter)?;
    let forests = TREES.map(|(tree, beta)| forest(&directions, &pilot, tree, beta));
    let some = bakes.baker.some_points(scale.cube_points);
    let seen = bakes.baker.visibility(&directions, &some, reporter, |visible| {
        let wavelets = wavelets(visible, side);
        forests.each_ref().map(|forest| scale.sigmas.iter().map(|&s| terms(visible, forest, &wavelets, s)).collect())
    })?;
    reporter.finish();
    let curve = |(i, (metric, beta)): (usize, (TreeKind, f32))| {
        let of_points = |s: usize| seen.iter().map(move |point: &[Vec<Terms>; 3]| point[i][s]);
        let matched = |(s, &sigma): (usize, &f32)| Matched::of(sigma, of_points(s), directions.len());
        Curve { metric, beta, points: scale.sigmas.iter().enumerate().map(matched).collect() }
    };
    let curves = TREES.into_iter().enumerate().map(curve).collect();
    let comparison = Comparison { scene: case.name.clone(), cube_side: side, points: some.len(), curves };
    notebook.record("fig6a_wavelets", "Fig. 6a: wavelets against cuts", markup(&comparison), &comparison)
}

/// Texels of each face in the order of its tree's leaves.
fn forest(directions: &[Vec3], pilot: &PilotVisibility, tree: TreeKind, beta: f32) -> Vec<Vec<u32>> {
    let texels = directions.len() / FACES;
    let of_face = |face: usize| {
        let range = face * texels..(face + 1) * texels;
        let rows = pilot.fractions.chunks(pilot.lights).flat_map(|row| row[range.clone()].iter().copied());
        let seen = PilotVisibility { lights: texels, fractions: rows.collect() };
        cluster_order(&Features::of_kind(tree, beta, &directions[range.clone()], &seen))
    };
    (0..FACES).map(of_face).collect()
}

/// Error from keeping only the largest coefficients of all faces.
fn wavelets(visible: &[u8], side: usize) -> Nonlinear {
    let mut coefficients: Vec<f32> = visible.iter().map(|&v| f32::from(v) / f32::from(OPEN)).collect();
    coefficients.chunks_mut(side * side).for_each(|face| haar::forward(face, side));
    Nonlinear::new(&coefficients)
}

/// The cut of a forest and equally accurate wavelets.
fn terms(visible: &[u8], forest: &[Vec<u32>], wavelets: &Nonlinear, sigma: f32) -> Terms {
    let texels = visible.len() / FACES;
    let mut selector = CutSelector::new(texels.ilog2(), CutCriterion { sigma, ..Default::default() });
    let (mut squared_error, mut nodes) = (0.0, 0);
    for (face, order) in visible.chunks(texels).zip(forest) {
        let leaves: Vec<u8> = order.iter().map(|&texel| face[texel as usize]).collect();
        let mut cut = Vec::new();
        squared_error += selector.select(&leaves, &mut cut);
        nodes += cut.len();
    }
    // Rounding of the stored means can leave a tiny error in an exact cut; no coefficient may be saved for it.
    Terms { squared_error, cut: nodes, wavelets: wavelets.terms(squared_error.max(0.0)) }
}

impl Matched {
    fn of(sigma: f32, points: impl Iterator<Item = Terms>, texels: usize) -> Self {
        let (mut count, mut squared_error, mut cut, mut wavelets) = (0_usize, 0.0, 0, 0);
        for terms in points {
            count += 1;
            squared_error += terms.squared_error;
            cut += terms.cut;
            wavelets += terms.wavelets;
        }
        let mean = |sum: usize| sum as f64 / count.max(1) as f64;
        Self {
            sigma,
            rms: (squared_error / (count.max(1) * texels) as f64).max(0.0).sqrt(),
            cut_terms: mean(cut),
            wavelet_terms: mean(wavelets),
            excess: cut as f64 / wavelets.max(1) as f64 - 1.0,
        }
    }
}

fn markup(comparison: &Comparison) -> Markup {
    let Comparison { scene, cube_side, points, curves } = comparison;
    let line = |name: String, curve: &Curve, terms: fn(&Matched) -> f64| Line {
        name,
        points: curve.points.iter().map(|m| (m.rms, terms(m))).collect(),
    };
    let mixed = curves.iter().find(|curve| curve.metric == TreeKind::Mixed);
    let wavelets = mixed.map(|curve| line("wavelets".into(), curve, |m| m.wavelet_terms));
    let cuts = curves.iter().map(|curve| line(label(curve.metric).into(), curve, |m| m.cut_terms));
    let lines: Vec<Line> = wavelets.into_iter().chain(cuts).collect();
    let chart = Chart {
        title: "Terms at the same total error",
        x_label: "RMS error over texels and points",
        x: AxisScale::Log,
        y: AxisScale::Log,
        lines: &lines,
    };
    let row = |m: &Matched| {
        vec![
            short(m.sigma.into()),
            short(m.rms),
            format!("{:.0}", m.cut_terms),
            format!("{:.0}", m.wavelet_terms),
            format!("{:+.0} %", 100.0 * m.excess),
        ]
    };
    let rows: Vec<Vec<String>> = mixed.map(|curve| curve.points.iter().map(row).collect()).unwrap_or_default();
    html! {
        p {
            "Visibility of a 6 x " (cube_side) " x " (cube_side) " cube map from " (points) " points of “" (scene) "”. Wavelets \
             are the largest Haar coefficients; a cut here is one of six trees, one a face. Each point’s wavelets have the total \
             squared error of its cut. The paper reports 10 to 15 % more terms for cuts. The table is for mixed trees."
        }
        div.grid.two {
            (chart.svg())
            (table(&["Sigma", "RMS", "Nodes of cuts", "Wavelets", "Cuts need"], &rows))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 16;

    fn geometric() -> Vec<Vec<u32>> {
        let directions = cube_map::directions(SIDE);
        let pilot = PilotVisibility { lights: directions.len(), fractions: Vec::new() };
        forest(&directions, &pilot, TreeKind::Geometric, 1.0)
    }

    fn upper_half() -> Vec<u8> {
        cube_map::directions(SIDE).iter().map(|d| OPEN * u8::from(d.y > 0.0)).collect()
    }

    #[test]
    fn known_functions_need_known_numbers_of_terms() {
        let forest = geometric();
        let all = vec![OPEN; FACES * SIDE * SIDE];
        let open = terms(&all, &forest, &wavelets(&all, SIDE), 0.5);
        assert_eq!(open, Terms { squared_error: 0.0, cut: 6, wavelets: 6 }, "a node and a coefficient a face");
        let half = upper_half();
        let exact = wavelets(&half, SIDE);
        // The top face needs one coefficient, the bottom none, and each side two: a mean and an edge.
        assert_eq!(exact.terms(0.0), 1 + 4 * 2);
        let cut = terms(&half, &forest, &exact, 0.0);
        assert!(cut.squared_error < 1e-9 && cut.cut >= 2 + 4 * 2 && cut.wavelets == 9, "{cut:?}");
    }

    #[test]
    fn wavelets_are_as_good_as_the_cut_and_one_fewer_is_not() {
        let directions = cube_map::directions(SIDE);
        let axis = Vec3::new(0.3, 0.8, 0.5).normalize();
        let visible: Vec<u8> = directions.iter().map(|d| OPEN * u8::from(d.dot(axis) > 0.2)).collect();
        let nonlinear = wavelets(&visible, SIDE);
        let mut before = usize::MAX;
        for sigma in [0.5, 1.0, 2.0] {
            let found = terms(&visible, &geometric(), &nonlinear, sigma);
            assert!(nonlinear.squared_error(found.wavelets) <= found.squared_error);
            assert!(nonlinear.squared_error(found.wavelets - 1) > found.squared_error, "negative control");
            assert!(found.cut < before, "a coarser bound, a smaller cut");
            before = found.cut;
        }
    }

    #[test]
    fn means_are_over_points_and_texels() {
        let points =
            [(4.0, 10, 8), (0.0, 30, 24)].map(|(squared_error, cut, wavelets)| Terms { squared_error, cut, wavelets });
        let matched = Matched::of(2.0, points.into_iter(), 50);
        assert_eq!((matched.rms, matched.cut_terms, matched.wavelet_terms), (0.2, 20.0, 16.0));
        assert!((matched.excess - 0.25).abs() < 1e-12);
    }
}
