//! Radiosity on any kind of surface: a room of triangles, an implicit surface and an isosurface of a volume light each other
//! through one meshless basis (after Fig. 6 of the meshless paper).
//!
//! Run with `cargo run --release -p lapidary-precompute --example any_surface -- --out DIR`. It writes `direct.png`,
//! `indirect.png` and `full.png`. `--progressive` solves without links, and writes `bounce-1.png` and so on.
//! Nothing but [`lapidary_core::surfel::Surface`] ties the light transport to the scene.

mod aggregate;
mod implicit;
mod lamp;
mod progressive;
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
    meshless::{MeshlessBake, RadiositySettings, SenderSamples, Solution, SolveSettings, Solver, irradiance},
    surfel::{Surface, Surfel},
};
use lapidary_interchange::image;
use lapidary_precompute::{Silent, meshless_bake, place_basis};
use progressive::Progressive;
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
    /// Solve bounce by bounce without links, with a picture of each
    #[arg(long)]
    progressive: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot make the folder; check the path ({})", args.out.display()))?;
    let (scene, camera) = (scene(), camera());
    let start = Instant::now();
    let settings = MeshlessSettings { levels: args.levels, sender_levels: args.levels.min(3), ..Default::default() };
    let lamp = Lamp::default();
    let size = [args.width, args.width * 3 / 4];
    let write = |name: &str, value: fn(&Shaded) -> Vec3, received: &Received| {
        let pixel = |i: u32| value(&shade(&scene, &lamp, received, &camera, [i % size[0], i / size[0]], size));
        let image = Image { size, pixels: (0..size[0] * size[1]).into_par_iter().map(pixel).collect() };
        image::write(&image, &args.out.join(name))
    };
    let pictures = |received: &Received| -> Result<()> {
        write("direct.png", |pixel| pixel.direct, received)?;
        write("indirect.png", |pixel| pixel.indirect, received)?;
        Ok(write("full.png", |pixel| pixel.direct + pixel.indirect, received)?)
    };
    if args.progressive {
        let (basis, _) = place_basis(&scene, camera.eye, &settings, &Silent)?;
        println!("{} functions, {:.1} s", basis.len(), start.elapsed().as_secs_f32());
        let mut solver = Progressive::new(&basis, &scene, &lamp, RadiositySettings::DEFAULT)?;
        for bounce in 1.. {
            let has_more = solver.bounce();
            println!("bounce {bounce}: {} gathers, {:.1} s", solver.gathers(), start.elapsed().as_secs_f32());
            write(&format!("bounce-{bounce}.png"), |pixel| pixel.indirect, &|at| solver.at(at))?;
            if !has_more {
                break;
            }
        }
        return pictures(&|at| solver.at(at));
    }
    let (bake, report) = meshless_bake(&scene, camera.eye, &settings, &Silent)?;
    println!("{} functions, {} links, {:.1} s", bake.basis.len(), report.links, start.elapsed().as_secs_f32());
    let solution = indirect(&bake, &scene, &lamp, SolveSettings::default());
    for (bounce, mean) in solution.mean_irradiance.iter().enumerate() {
        println!("mean irradiance after {bounce} bounces: {:.4} {:.4} {:.4}", mean.x, mean.y, mean.z);
    }
    pictures(&|at| indirect_at(&bake, &solution.coefficients, at))
}

/// Bounced irradiance at a surface point in W/m².
type Received<'a> = dyn Fn(&Surfel) -> Vec3 + Sync + 'a;

/// A room of triangles, an implicit pot, and foliage as an isosurface of a volume.
fn scene() -> Aggregate {
    Aggregate::new(vec![
        Box::new(room::Room::new()),
        Box::new(implicit::Implicit::pot()),
        Box::new(volume::Isosurface::foliage()),
    ])
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 1.0, 0.95), Vec3::new(0.0, 0.8, -1.0), 80.0)
}

/// Solves for the bounces of the lamp's direct light.
fn indirect(bake: &MeshlessBake, scene: &Aggregate, lamp: &Lamp, settings: SolveSettings) -> Solution {
    let solver = Solver::new(bake);
    let samples = SenderSamples::on_surface(&bake.basis, &solver, scene);
    let direct: Vec<Vec3> = samples.points().par_iter().map(|p| lamp.irradiance(scene, p)).collect();
    let reflectance: Vec<Vec3> = samples.points().iter().map(|p| scene.reflectance(p)).collect();
    let (direct, reflectance) = samples.fit(&solver, &direct, &reflectance);
    solver.solve(bake, &direct, &reflectance, settings)
}

/// Radiance of a pixel.
#[derive(Clone, Copy, Default)]
struct Shaded {
    direct: Vec3,
    indirect: Vec3,
}

/// The mean of four rays through a pixel.
fn shade(
    scene: &Aggregate,
    lamp: &Lamp,
    received: &Received,
    camera: &Camera,
    pixel: [u32; 2],
    size: [u32; 2],
) -> Shaded {
    let (mut sum, pixel) = (Shaded::default(), Vec2::from(pixel.map(|i| i as f32)));
    for k in 0..4 {
        let within = Vec2::new((k % 2) as f32, (k / 2) as f32) * 0.5 + 0.25;
        let Some(hit) = scene.first_hit(camera.eye, camera.direction_through(pixel + within, size)) else { continue };
        let reflected = scene.reflectance(&hit) * (0.25 * FRAC_1_PI);
        sum.direct += reflected * lamp.irradiance(scene, &hit);
        sum.indirect += reflected * received(&hit);
    }
    sum
}

fn indirect_at(bake: &MeshlessBake, coefficients: &[Mat3A], at: &Surfel) -> Vec3 {
    irradiance(&bake.basis.evaluate(bake.basis.levels(), at.position, at.normal, coefficients), at.normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::sphere::{cosine_direction, frame_around};
    use std::f32::consts::PI;

    /// Rays per point; the lamp's light at each hit takes sixteen more.
    const RAYS: usize = 256;

    /// Irradiance in one bounce, by rays.
    fn gathered(scene: &Aggregate, lamp: &Lamp, at: &Surfel) -> Vec3 {
        let (frame, origin) = (frame_around(at.normal), at.position + at.normal * scene.offset());
        let sent = |i: usize| {
            let direction = cosine_direction((i as f32 + 0.5) / RAYS as f32, (i as f32 * 0.618_034).fract());
            let hit = scene.first_hit(origin, frame * direction)?;
            Some(scene.reflectance(&hit) * lamp.irradiance(scene, &hit) * FRAC_1_PI)
        };
        (0..RAYS).filter_map(sent).sum::<Vec3>() * (PI / RAYS as f32)
    }

    /// Checks one bounce at places of each part that the camera sees.
    fn assert_is_what_rays_find(scene: &Aggregate, lamp: &Lamp, received: &Received) {
        let camera = camera();
        let mut of_part = [const { Vec::<(f32, f32)>::new() }; 3];
        for pixel in 0..48 * 36 {
            let direction = camera.direction_through(Vec2::new((pixel % 48) as f32, (pixel / 48) as f32), [48, 36]);
            let Some(hit) = scene.first_hit(camera.eye, direction) else { continue };
            let seen = &mut of_part[scene.part_of(&hit)];
            if seen.len() < 60 {
                seen.push((gathered(scene, lamp, &hit).y, received(&hit).y));
            }
        }
        let error = |pairs: &[(f32, f32)], scale: f32| {
            let sum = |f: &dyn Fn(&(f32, f32)) -> f32| pairs.iter().map(f).sum::<f32>();
            (sum(&|p| (p.0 - scale * p.1).powi(2)) / sum(&|p| p.0 * p.0)).sqrt()
        };
        for (part, pairs) in ["room", "pot", "foliage"].iter().zip(&of_part) {
            assert!(pairs.len() == 60, "{part}: {} places", pairs.len());
            assert!(error(pairs, 1.0) < 0.2, "{part}: {}", error(pairs, 1.0));
            assert!(error(pairs, 1.5) > 0.3, "negative control, too much light: {part} {}", error(pairs, 1.5));
        }
    }

    fn settings() -> MeshlessSettings {
        MeshlessSettings { levels: 4, sender_levels: 3, rays: 128, ..Default::default() }
    }

    #[test]
    fn each_kind_of_surface_gets_the_light_that_rays_find() {
        let (scene, lamp) = (scene(), Lamp::default());
        let (bake, _) = meshless_bake(&scene, camera().eye, &settings(), &Silent).expect("a bake");
        let once = SolveSettings { bounces: 1, ..Default::default() };
        let coefficients = indirect(&bake, &scene, &lamp, once).coefficients;
        assert_is_what_rays_find(&scene, &lamp, &|at| indirect_at(&bake, &coefficients, at));
    }

    #[test]
    fn the_first_bounce_without_links_is_what_rays_find_and_further_ones_add_to_it() {
        let (scene, lamp) = (scene(), Lamp::default());
        let (basis, _) = place_basis(&scene, camera().eye, &settings(), &Silent).unwrap();
        let mut solver = Progressive::new(&basis, &scene, &lamp, RadiositySettings::DEFAULT).unwrap();
        assert!(solver.bounce());
        assert_is_what_rays_find(&scene, &lamp, &|at| solver.at(at));
        let sum = |solver: &Progressive| basis.points().iter().map(|at| solver.at(at).y).sum::<f32>();
        let (once, mut bounces) = (sum(&solver), 1);
        while solver.bounce() {
            bounces += 1;
        }
        assert!(bounces > 2 && sum(&solver) > 1.2 * once, "{bounces} {} {once}", sum(&solver));
    }
}
