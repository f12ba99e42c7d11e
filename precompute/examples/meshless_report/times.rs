//! Work for a moved light: direct light, bounces, flattening to the vertices.

use crate::{
    median_ms, megabytes,
    prepared::{Lamp, Prepared, lit},
};
use lapidary_core::meshless::{Flattening, MeshlessBake, SenderSamples, SolveSettings, Solver};
use std::hint::black_box;

/// Prints medians of nine runs.
pub fn print(bake: &MeshlessBake, solver: &Solver, prepared: &Prepared, lamp: &Lamp) {
    let (mesh, surface) = (&prepared.scene.mesh, prepared.surface());
    let samples = SenderSamples::on_surface(&bake.basis, solver, &surface);
    let direct = || lit(&samples, solver, &surface, lamp);
    let (irradiance, gray) = direct();
    let time = median_ms(|| drop(black_box(direct())));
    println!("direct light on {} samples, {} senders fitted: {time:.1} ms", samples.points().len(), gray.len());
    for bounces in [1, 4] {
        let settings = SolveSettings { bounces, ..Default::default() };
        let time = median_ms(|| drop(black_box(solver.solve(bake, &irradiance, &gray, settings))));
        println!("solving {bounces} bounces {time:.1} ms");
    }
    let vertices: Vec<_> = mesh.positions.iter().copied().zip(mesh.normals.iter().copied()).collect();
    let flattening = Flattening::new(&bake.basis, &bake.transport, &vertices);
    let solution = solver.solve(bake, &irradiance, &gray, SolveSettings::default());
    let time = median_ms(|| drop(black_box(flattening.apply(&solution.coefficients))));
    println!(
        "flattening to {} vertices {time:.1} ms; {} weights, {:.1} MB",
        vertices.len(),
        flattening.weights(),
        megabytes(flattening.bytes())
    );
    println!("solver {:.1} MB", megabytes(solver.bytes()));
}
