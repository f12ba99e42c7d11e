//! What happens when a light moves: direct light on the senders, bounces, flattening to the vertices.

use crate::{
    median_ms, megabytes,
    prepared::{GREY, Lamp, Prepared},
};
use glam::Vec3;
use lapidary_core::meshless::{Flattening, MeshlessBake, SolveSettings, Solver};
use rayon::prelude::*;
use std::hint::black_box;

/// Prints medians of nine runs.
pub fn print(bake: &MeshlessBake, solver: &Solver, prepared: &Prepared, lamp: &Lamp) {
    let (mesh, surface) = (&prepared.scene.mesh, prepared.surface());
    let senders = &bake.basis.points()[bake.basis.senders()];
    let direct = || senders.par_iter().map(|p| Vec3::splat(lamp.direct(&surface, p))).collect::<Vec<Vec3>>();
    let lit = direct();
    let grey = vec![Vec3::splat(GREY); lit.len()];
    println!("direct light on {} senders {:.1} ms", lit.len(), median_ms(|| drop(black_box(direct()))));
    for bounces in [1, 4] {
        let settings = SolveSettings { bounces, ..Default::default() };
        let time = median_ms(|| drop(black_box(solver.solve(bake, &lit, &grey, settings))));
        println!("solving {bounces} bounces {time:.1} ms");
    }
    let vertices: Vec<_> = mesh.positions.iter().copied().zip(mesh.normals.iter().copied()).collect();
    let flattening = Flattening::new(&bake.basis, &bake.transport, &vertices);
    let solution = solver.solve(bake, &lit, &grey, SolveSettings::default());
    let time = median_ms(|| drop(black_box(flattening.apply(&solution.coefficients))));
    println!(
        "flattening to {} vertices {time:.1} ms; {} weights, {:.1} MB",
        vertices.len(),
        flattening.weights(),
        megabytes(flattening.bytes())
    );
    println!("solver {:.1} MB", megabytes(solver.bytes()));
}
