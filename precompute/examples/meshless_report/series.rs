//! Several bounces as one operator, beside the same bounces one by one.

use crate::{
    errors::Comparison,
    median_ms, megabytes,
    prepared::{Lamp, lit},
};
use glam::Mat3A;
use lapidary_core::meshless::{
    MeshlessBake, Projection, SenderSamples, SolveSettings, Solver, irradiance, neumann::Series,
};
use lapidary_precompute::MeshSurface;
use rayon::prelude::*;
use std::{hint::black_box, time::Instant};

/// Prints links, bytes, seconds, and the difference to iterating at the points of all functions. Links below `least` are
/// dropped.
pub fn print(bake: &MeshlessBake, solver: &Solver, surface: &MeshSurface, lamp: &Lamp, bounces: u32, least: f32) {
    let (direct, grey) = lit(&SenderSamples::on_surface(&bake.basis, solver, surface), solver, surface, lamp);
    let start = Instant::now();
    let Some(series) = Series::new(bake, solver, &grey, bounces, least, &|| false) else { return };
    let seconds = start.elapsed().as_secs_f32();
    let projected = Projection::new(&bake.basis, bake.basis.sender_levels()).pull_push(&direct);
    let time = median_ms(|| drop(black_box(series.apply(&projected))));
    let iterated = solver.solve(bake, &direct, &grey, SolveSettings { bounces, ..Default::default() });
    println!(
        "series of {bounces} bounces: {} links (one bounce: {}), {:.1} MB, made in {seconds:.1} s, applied in {time:.1} ms",
        series.links(),
        bake.transport.packed().len(),
        megabytes(series.bytes())
    );
    let at_points = |coefficients: &[Mat3A]| -> Vec<f32> {
        let value = |p: &_| {
            let p: &lapidary_core::surfel::Surfel = p;
            let vector = bake.basis.evaluate(bake.basis.levels(), p.position, p.normal, coefficients);
            irradiance(&vector, p.normal).x
        };
        bake.basis.points().par_iter().map(value).collect()
    };
    let summed = at_points(&series.apply(&projected));
    let pairs: Vec<(f32, f32)> = at_points(&iterated.coefficients).into_iter().zip(summed).collect();
    println!("  against iterating, at the points of all functions: {}", Comparison::of(&pairs));
}
