//! Radiosity on any kind of surface: a room of triangles, an implicit surface and an isosurface of a volume light each
//! other through one meshless basis (after Fig. 6 of the meshless paper).
//!
//! Run with `cargo run --release -p lapidary-precompute --example any_surface -- --out DIR`. It writes `direct.png`,
//! `indirect.png` and `full.png`. Nothing but [`lapidary_core::surfel::Surface`] ties the light transport to the scene.

mod aggregate;
mod implicit;
mod lamp;
mod room;
mod volume;

use aggregate::Aggregate;
use anyhow::{Context, Result};
use clap::Parser;
use glam::{Mat3A, Vec2, Vec3};
use lamp::Lamp;
use lapidary_core::{
    camera::Camera,
    dataset::MeshlessSettings,
    image::Image,
    meshless::{MeshlessBake, SenderSamples, SolveSettings, Solver, irradiance},
    surfel::{Surface, Surfel},
};
use lapidary_precompute::{Silent, meshless_bake};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, path::PathBuf, time::Instant};

/// Radiosity on a mesh, an implicit surface and an isosurface of a volume in one scene
#[derive(Parser)]
struct Args {
    /// Folder for the pictures
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Width of the pictures in pixels
    #[arg(long, default_value_t = 480)]
    width: u32,
    /// Levels of the basis
    #[arg(long, default_value_t = 4)]
    levels: usize,
}

fn main() -> Result<()> {
    let args = Args::parse();
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot make the folder; check the path ({})", args.out.display()))?;
    let scene = Aggregate::new(vec![
        Box::new(room::Room::new()),
        Box::new(implicit::Implicit::pot()),
        Box::new(volume::Isosurface::foliage()),
    ]);
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.95), Vec3::new(0.0, 0.8, -1.0), 80.0);
    let start = Instant::now();
    let settings = MeshlessSettings { levels: args.levels, sender_levels: args.levels.min(3), ..Default::default() };
    let (bake, report) = meshless_bake(&scene, camera.eye, &settings, &Silent)?;
    println!("{} functions, {} links, {:.1} s", bake.basis.len(), report.links, start.elapsed().as_secs_f32());
    let lamp = Lamp::default();
    let coefficients = indirect(&bake, &scene, &lamp);
    let size = [args.width, args.width * 3 / 4];
    let pixels: Vec<Shaded> = (0..size[0] * size[1])
        .into_par_iter()
        .map(|i| {
            shade(
                &bake,
                &scene,
                &lamp,
                &coefficients,
                &camera,
                Vec2::new((i % size[0]) as f32, (i / size[0]) as f32),
                size,
            )
        })
        .collect();
    let picture = |value: fn(&Shaded) -> Vec3| Image { size, pixels: pixels.iter().map(value).collect() };
    for (name, image) in [
        ("direct.png", picture(|p| p.direct)),
        ("indirect.png", picture(|p| p.indirect)),
        ("full.png", picture(|p| p.direct + p.indirect)),
    ] {
        image.write(&args.out.join(name))?;
    }
    Ok(())
}

/// Direct light, and what it becomes in four bounces.
fn indirect(bake: &MeshlessBake, scene: &Aggregate, lamp: &Lamp) -> Vec<Mat3A> {
    let solver = Solver::new(bake);
    let samples = SenderSamples::on_surface(&bake.basis, &solver, scene);
    let direct: Vec<Vec3> = samples.points().par_iter().map(|p| lamp.irradiance(scene, p)).collect();
    let reflectance: Vec<Vec3> = samples.points().iter().map(|p| scene.reflectance(p)).collect();
    let (direct, reflectance) = samples.fit(&solver, &direct, &reflectance);
    let solution = solver.solve(bake, &direct, &reflectance, SolveSettings::default());
    for (bounce, mean) in solution.mean_irradiance.iter().enumerate() {
        println!("mean irradiance after {bounce} bounces: {:.4} {:.4} {:.4}", mean.x, mean.y, mean.z);
    }
    solution.coefficients
}

/// Radiance of a pixel.
#[derive(Clone, Copy, Default)]
struct Shaded {
    direct: Vec3,
    indirect: Vec3,
}

/// The mean of four rays through a pixel.
fn shade(
    bake: &MeshlessBake,
    scene: &Aggregate,
    lamp: &Lamp,
    coefficients: &[Mat3A],
    camera: &Camera,
    pixel: Vec2,
    size: [u32; 2],
) -> Shaded {
    let mut sum = Shaded::default();
    for k in 0..4 {
        let within = Vec2::new((k % 2) as f32, (k / 2) as f32) * 0.5 + 0.25;
        let Some(hit) = scene.first_hit(camera.eye, camera.direction_through(pixel + within, size)) else { continue };
        let reflected = scene.reflectance(&hit) * (0.25 * FRAC_1_PI);
        sum.direct += reflected * lamp.irradiance(scene, &hit);
        sum.indirect += reflected * indirect_at(bake, coefficients, &hit);
    }
    sum
}

fn indirect_at(bake: &MeshlessBake, coefficients: &[Mat3A], at: &Surfel) -> Vec3 {
    irradiance(&bake.basis.evaluate(bake.basis.levels(), at.position, at.normal, coefficients), at.normal)
}
