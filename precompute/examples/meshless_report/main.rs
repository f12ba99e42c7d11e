//! Figures of the meshless light transport in `docs/results.md`: size of the operator, error of one bounce against rays, and times
//! of a moving light.
//!
//! ```sh
//! cargo run --release -p lapidary-precompute --example meshless_report -- SCENE --levels 6 --sender-levels 4 --gather-rays 300 --epsilon 0.025
//! ```
//!
//! `SCENE` is a file that the program can import, or `boxes`: a closed room of 2 m with two boxes. Everything is half gray
//! and lit by one point light.

mod errors;
mod prepared;
mod times;

use anyhow::{Context, Result};
use clap::Parser;
use glam::Vec3;
use lapidary_core::{dataset::MeshlessSettings, meshless::Solver, surfel::Surface};
use lapidary_precompute::{Silent, find_viewpoint, meshless_bake};
use prepared::{Lamp, Prepared};
use std::time::Instant;

/// Size, error and speed of the meshless light transport in a scene
#[derive(Parser)]
struct Args {
    /// Scene file, or `boxes`
    scene: String,
    /// Levels of the basis
    #[arg(long, default_value_t = 6)]
    levels: usize,
    /// Number of first levels that send; at most all
    #[arg(long, default_value_t = 4)]
    sender_levels: usize,
    /// Rays per gather
    #[arg(long, default_value_t = 512)]
    gather_rays: usize,
    /// Least significant link
    #[arg(long, default_value_t = 0.025)]
    epsilon: f32,
    /// Distance of the coarsest points in meters [default: about 300 points]
    #[arg(long)]
    coarse_radius: Option<f32>,
    /// Position of the light [default: the center of the scene's bounds]
    #[arg(long, value_parser = place, allow_hyphen_values = true)]
    light: Option<Vec3>,
    /// Viewpoint for reachable surfaces [default: searched for]
    #[arg(long, value_parser = place, allow_hyphen_values = true)]
    viewpoint: Option<Vec3>,
    /// Points at which light is compared with rays
    #[arg(long, default_value_t = 600)]
    points: usize,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let prepared = Prepared::load(&args.scene)?;
    let surface = prepared.surface();
    let scene = &prepared.scene;
    let viewpoint = find_viewpoint(&surface, args.viewpoint, &scene.cameras, &scene.lights)?;
    let lamp = Lamp { position: args.light.unwrap_or_else(|| surface.bounds().center()) };
    println!(
        "{}: {} triangles, viewpoint {viewpoint}, light {}",
        args.scene,
        scene.mesh.triangles.len(),
        lamp.position
    );
    let settings = MeshlessSettings {
        levels: args.levels,
        sender_levels: args.sender_levels.clamp(1, args.levels.max(1)),
        coarse_radius: args.coarse_radius,
        rays: args.gather_rays,
        epsilon: args.epsilon,
    };
    let start = Instant::now();
    let (bake, report) =
        meshless_bake(&surface, viewpoint, &settings, &Silent).context("cannot bake the meshless basis")?;
    let seconds = start.elapsed().as_secs_f32();
    let solver = Solver::new(&bake);
    println!("functions {:?}, {} of them send", report.functions, report.senders);
    println!("links {}, {:.4} % of the possible ones", report.links, 100.0 * report.share);
    println!(
        "bytes of links {:.1} MB, of points {:.1} MB",
        megabytes(report.bytes_links),
        megabytes(report.bytes_points)
    );
    println!("bake {seconds:.1} s");
    errors::print(&bake, &solver, &surface, &lamp, viewpoint, args.points);
    times::print(&bake, &solver, &prepared, &lamp);
    Ok(())
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

/// Median milliseconds of nine runs.
fn median_ms(mut work: impl FnMut()) -> f32 {
    let mut times: Vec<f32> = (0..9)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f32() * 1e3
        })
        .collect();
    times.sort_unstable_by(f32::total_cmp);
    times[times.len() / 2]
}

/// A position from three comma-separated numbers.
fn place(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("give three numbers separated by commas, such as 0,1.5,-2".into()),
    }
}
