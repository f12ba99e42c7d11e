//! `lapidary bench FILE.cuts --drag OBJECT`: how long a picture takes while an object is dragged.

use super::median;
use crate::{
    args::{BackendOption, ViewedScene},
    terminal::{json_text, print_out},
};
use anyhow::{Result, anyhow};
use glam::Vec3;
use lapidary_core::scene::pose::{Objects, Pose, Poses};
use lapidary_render::{BackendError, LitScene, Look, STRIDES, Tiles};
use serde::Serialize;
use std::time::{Duration, Instant};

/// All figures.
#[derive(Debug, Serialize)]
struct Drag {
    /// `cpu`, or the adapter's name.
    adapter: String,
    object: String,
    size: [u32; 2],
    vertices: usize,
    steps: u32,
    /// From the first step to the light of its picture.
    pick_up_milliseconds: f64,
    /// From a step to the light of its picture: the median.
    light_milliseconds: f64,
    /// From there to a whole picture from the pixels of the coarsest lattice: the median.
    sketch_milliseconds: f64,
    /// Pictures a second of both.
    pictures_per_second: f64,
}

/// Drags an object by half the width of its box in `steps` steps, and prints.
///
/// # Errors
/// An object that is not there, or no adapter where one is asked for.
pub fn run(viewed: &ViewedScene, object: &str, steps: u32, backend: BackendOption, json: bool) -> Result<()> {
    let scene = &viewed.baked.dataset.scene;
    let index = scene.objects.iter().position(|known| known.name == object).ok_or_else(|| {
        let names: Vec<_> = scene.objects.iter().map(|known| known.name.as_str()).collect();
        anyhow!("there is no object \"{object}\"; there are {}", names.join(", "))
    })?;
    let mut on = LitScene::new(backend.open()?, viewed.baked.clone())?;
    let look = viewed.look()?;
    picture(&mut on, &look)?;
    let vertices = Objects::of(scene);
    let places = vertices.vertices(index as u32).iter().map(|&vertex| scene.mesh.positions[vertex as usize].x);
    let (least, most) = places.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let step = 0.5 * (most - least).max(0.0) / steps as f32;
    let mut times = (1..=steps).map(|i| {
        let mut poses = Poses::default();
        poses.set(index as u32, Pose { translate: Vec3::X * step * i as f32, ..Pose::AS_BAKED });
        picture(&mut on, &Look { poses, ..look.clone() })
    });
    let (pick_up, _) = times.next().expect("at least one step")?;
    let times = times.collect::<Result<Vec<_>, _>>()?;
    let (light, sketch): (Vec<_>, Vec<_>) = times.into_iter().unzip();
    let [light, sketch] = [light, sketch].map(median);
    let drag = Drag {
        adapter: on.backend().name(),
        object: object.into(),
        size: look.view.size,
        vertices: scene.mesh.positions.len(),
        steps,
        pick_up_milliseconds: 1e3 * pick_up.as_secs_f64(),
        light_milliseconds: light,
        sketch_milliseconds: sketch,
        pictures_per_second: 1e3 / (light + sketch),
    };
    print_out(&if json { json_text(&drag)? } else { text(&drag) })
}

/// Times from a look to its light, and from there to a coarse picture.
fn picture(scene: &mut LitScene, look: &Look) -> Result<(Duration, Duration), BackendError> {
    let start = Instant::now();
    scene.light(look)?;
    let lit = start.elapsed();
    scene.begin(&look.view, look.sampling)?;
    let tiles: Vec<u32> = (0..Tiles::of(look.view.size).count()).collect();
    scene.sketch(STRIDES[0], &tiles)?;
    scene.fill(u32::MAX)?;
    scene.display(&look.post)?;
    Ok((lit, start.elapsed() - lit))
}

fn text(drag: &Drag) -> String {
    let Drag { adapter, object, size: [width, height], vertices, steps, .. } = drag;
    let Drag { pick_up_milliseconds: first, light_milliseconds: light, sketch_milliseconds: sketch, .. } = drag;
    let rate = drag.pictures_per_second;
    format!(
        "{adapter}: {width} x {height}, {vertices} vertices, \"{object}\" dragged in {steps} steps\n\
         light of the first step in {first:.0} ms, then in {light:.0} ms, coarse picture in {sketch:.0} ms: \
         {rate:.1} pictures a second\n"
    )
}
