//! `lapidary bench FILE.cuts --drag OBJECT`: picture times while an object is dragged.

use super::{JsonArgs, median};
use crate::args::{DeviceArgs, ViewedScene};
use anyhow::{Result, anyhow};
use glam::Vec3;
use lapidary_core::scene::{
    Scene,
    pose::{Objects, Pose, Poses},
};
use lapidary_render::{BackendError, ImplicitDetail, LitScene, Look, STRIDES, Tiles};
use serde::Serialize;
use std::{
    thread::sleep,
    time::{Duration, Instant},
};

/// Where a detail is not prepared by then, the first step prepares it.
const PATIENCE: Duration = Duration::from_secs(60);

/// All figures.
#[derive(Debug, Serialize)]
struct Drag {
    /// `cpu`, or the adapter's name.
    adapter: String,
    object: String,
    size: [u32; 2],
    vertices: usize,
    steps: u32,
    /// From the coarsest detail to the finest.
    details: Vec<Detailed>,
}

/// Figures of one detail.
#[derive(Debug, Serialize)]
pub(super) struct Detailed {
    surfels: u32,
    /// Bins per surfel.
    bins: usize,
    /// Most bounces followed.
    bounces: u32,
    /// Time to prepare, on a thread, once an object may be dragged.
    prepare_milliseconds: f64,
    /// Time from the first step to its light.
    pick_up_milliseconds: f64,
    /// Median time from a step to its light.
    light_milliseconds: f64,
    /// Median time from the light to a picture filled from the coarsest lattice.
    sketch_milliseconds: f64,
    /// Pictures per second, including light.
    pictures_per_second: f64,
}

/// Drags an object by half the width of its box at each detail, which is prepared as in the window: one step picks it up, `steps`
/// more follow. Prints the figures.
///
/// # Errors
/// A missing object, or no adapter if one is required.
pub fn run(viewed: &ViewedScene, object: &str, steps: u32, device: DeviceArgs, json: &JsonArgs) -> Result<()> {
    let scene = &viewed.baked.dataset.scene;
    let index = object_named(scene, object)?;
    let mut on = LitScene::new(device.open()?, viewed.baked.clone())?;
    let look = viewed.look()?;
    picture(&mut on, &look)?;
    let looks = dragged(scene, index, &look, steps);
    let details = ImplicitDetail::LADDER.into_iter().map(|detail| Detailed::measure(&mut on, detail, &looks));
    let drag = Drag {
        details: details.collect::<Result<_, _>>()?,
        adapter: on.backend().name(),
        object: object.into(),
        size: look.view.size,
        vertices: scene.mesh.positions.len(),
        steps,
    };
    json.tell(&drag, || text(&drag))
}

/// The index of an object.
///
/// # Errors
/// No such object; names those that exist.
pub(super) fn object_named(scene: &Scene, object: &str) -> Result<u32> {
    let index = scene.objects.iter().position(|known| known.name == object).ok_or_else(|| {
        let names: Vec<_> = scene.objects.iter().map(|known| known.name.as_str()).collect();
        anyhow!("there is no object \"{object}\"; there are {}", names.join(", "))
    })?;
    Ok(index as u32)
}

/// Looks of the step that picks an object up, and of `steps` more.
pub(super) fn dragged(scene: &Scene, object: u32, look: &Look, steps: u32) -> Vec<Look> {
    let vertices = Objects::of(scene);
    let places = vertices.vertices(object).iter().map(|&vertex| scene.mesh.positions[vertex as usize].x);
    let (least, most) = places.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let step = 0.5 * (most - least).max(0.0) / (steps + 1) as f32;
    let at = |i: u32| {
        let mut poses = Poses::default();
        poses.set(object, Pose { translate: Vec3::X * step * i as f32, ..Pose::AS_BAKED });
        Look { poses, ..look.clone() }
    };
    (1..=steps + 1).map(at).collect()
}

impl Detailed {
    /// Shows at least two looks in sequence.
    pub fn measure(on: &mut LitScene, detail: ImplicitDetail, looks: &[Look]) -> Result<Self, BackendError> {
        let start = Instant::now();
        while !on.prepare(detail) && start.elapsed() < PATIENCE {
            sleep(Duration::from_millis(1));
        }
        let prepared = start.elapsed();
        on.set_detail(detail);
        let mut times = looks.iter().map(|look| picture(on, look));
        let (pick_up, _) = times.next().expect("at least one step")?;
        let times = times.collect::<Result<Vec<_>, _>>()?;
        let (light, sketch): (Vec<_>, Vec<_>) = times.into_iter().unzip();
        let [light, sketch] = [light, sketch].map(median);
        Ok(Self {
            surfels: detail.surfels(),
            bins: detail.layout().cells.len(),
            bounces: detail.bounces(),
            prepare_milliseconds: 1e3 * prepared.as_secs_f64(),
            pick_up_milliseconds: 1e3 * pick_up.as_secs_f64(),
            light_milliseconds: light,
            sketch_milliseconds: sketch,
            pictures_per_second: 1e3 / (light + sketch),
        })
    }

    /// A line of a table.
    pub fn line(&self) -> String {
        let Self { surfels, bins, bounces, pick_up_milliseconds: first, light_milliseconds: light, .. } = self;
        let Self { prepare_milliseconds: prepared, sketch_milliseconds: sketch, pictures_per_second: rate, .. } = self;
        format!(
            "{surfels:>6} surfels, {bins} bins, {bounces} bounces: prepared in {prepared:.0} ms, first step {first:.0} ms, \
             then light {light:.0} ms and coarse picture {sketch:.0} ms, {rate:.1} pictures a second\n"
        )
    }
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
    let Drag { adapter, object, size: [width, height], vertices, steps, details } = drag;
    let mut text =
        format!("{adapter}: {width} x {height}, {vertices} vertices, \"{object}\" dragged in {steps} steps\n");
    details.iter().for_each(|detail| text += &detail.line());
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::dataset;
    use lapidary_render::{Appearance, Backend, Baked, CpuBackend, test_looks};

    #[test]
    fn one_step_after_the_pick_up_is_enough_for_all_figures() {
        let baked = Baked::from(dataset(&["a"], &[]));
        let scene = &baked.dataset.scene;
        let look = Look { appearance: Appearance::of(scene), ..test_looks::look() };
        let looks = dragged(scene, 0, &look, 1);
        let places: Vec<Vec3> = looks.iter().map(|look| look.poses.of(0).translate).collect();
        assert_eq!(places, [Vec3::X * 0.25, Vec3::X * 0.5]);
        let mut on = LitScene::new(Box::new(CpuBackend::new()) as Box<dyn Backend>, baked.clone()).unwrap();
        picture(&mut on, &look).unwrap();
        let Detailed {
            prepare_milliseconds,
            pick_up_milliseconds,
            light_milliseconds,
            sketch_milliseconds,
            pictures_per_second,
            ..
        } = Detailed::measure(&mut on, ImplicitDetail::LADDER[0], &looks).unwrap();
        assert!(
            prepare_milliseconds > 0.0
                && pick_up_milliseconds > 0.0
                && light_milliseconds > 0.0
                && sketch_milliseconds > 0.0
        );
        assert!(pictures_per_second > 0.0 && pictures_per_second.is_finite());
    }
}
