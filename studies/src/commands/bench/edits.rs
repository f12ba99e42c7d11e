//! `lapidary bench FILE.cuts --edits MATERIAL`: interactive picture times after a material edit, a camera step, and a rotation of
//! the environment.

use super::{JsonArgs, median};
use crate::args::{DeviceArgs, ViewedScene};
use anyhow::{Result, anyhow, ensure};
use glam::Quat;
use lapidary_core::{brdf::Value, scene::Scene};
use lapidary_render::{LitScene, Look, STRIDES, Tiles};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Rotation in radians of environment or camera, as small as a drag by some pixels.
const TURN: f32 = 0.05;

/// Edited parameters, if the material's model has them.
const QUANTITIES: [&str; 2] = ["roughness", "base_color"];
/// Alternating factor on both parameters.
const EDIT: f32 = 0.9;

/// All figures.
#[derive(Debug, Serialize)]
struct Edits {
    /// `cpu`, or the adapter's name.
    adapter: String,
    material: String,
    size: [u32; 2],
    vertices: usize,
    /// Edits of each kind in the median, after one to warm up.
    frames: u32,
    /// Times from an edit of the material.
    edit: Sketched,
    /// Times from a step of the camera around its target.
    orbit: Sketched,
    /// Times from a rotation of the environment; absent without one.
    turned: Option<Turned>,
}

/// Median times of a change that shows a sketch first.
#[derive(Debug, Serialize)]
struct Sketched {
    /// Time to the coarsest sketch on the display.
    sketch_milliseconds: f64,
    /// Time to the finished first sample.
    finished_milliseconds: f64,
}

/// Median times of a rotated environment.
#[derive(Debug, Serialize)]
struct Turned {
    /// Time to its light.
    light_milliseconds: f64,
    /// Time to the first sample, including new lit cuts.
    finished_milliseconds: f64,
}

/// Edits, orbits and rotates; prints the times.
///
/// # Errors
/// A missing material, or no adapter if one is required.
pub fn run(viewed: &ViewedScene, material: &str, frames: u32, device: DeviceArgs, json: &JsonArgs) -> Result<()> {
    let scene = &viewed.baked.dataset.scene;
    let edited = index_of(scene, material)?;
    let on = LitScene::new(device.open()?, viewed.baked.clone())?.keep_unseen_changes();
    let mut subject = Subject { scene: on, look: viewed.look()?, edited, frames };
    subject.scene.show_whole(&subject.look)?;
    let edits = Edits {
        edit: subject.edit()?,
        orbit: subject.orbit()?,
        turned: subject.look.components.environment.then(|| subject.turn()).transpose()?,
        adapter: subject.scene.backend().name(),
        material: material.into(),
        size: viewed.view.size,
        vertices: scene.mesh.positions.len(),
        frames,
    };
    json.tell(&edits, || text(&edits))
}

fn index_of(scene: &Scene, material: &str) -> Result<usize> {
    let index = scene.materials.iter().position(|known| known.name == material).ok_or_else(|| {
        let names: Vec<_> = scene.materials.iter().map(|known| known.name.as_str()).collect();
        anyhow!("there is no material \"{material}\"; there are {}", names.join(", "))
    })?;
    let has_any = QUANTITIES.iter().any(|quantity| scene.materials[index].parameter_for(quantity).is_some());
    ensure!(has_any, "\"{material}\" has neither a base color nor a roughness to edit; name another material");
    Ok(index)
}

/// A scene on the renderer, with a finished picture of its look.
struct Subject {
    scene: LitScene,
    look: Look,
    edited: usize,
    frames: u32,
}

impl Subject {
    fn edit(&mut self) -> Result<Sketched> {
        let mut factors = [EDIT, 1.0 / EDIT].into_iter().cycle();
        self.sketched(|look, edited| {
            let factor = factors.next().unwrap_or(1.0);
            let material = &mut look.appearance.materials[edited];
            for parameter in QUANTITIES.map(|quantity| material.parameter_for(quantity)).into_iter().flatten() {
                let edited = match material.parameters.value(parameter) {
                    Value::Number(x) => Value::Number(factor * x),
                    Value::Color(c) => Value::Color(factor * c),
                };
                material.parameters.set(parameter.name, edited);
            }
        })
    }

    fn orbit(&mut self) -> Result<Sketched> {
        let (view, mut turns) = (self.look.view.clone(), [TURN, 0.0].into_iter().cycle());
        let sketched = self.sketched(|look, _| {
            let arm = Quat::from_rotation_y(turns.next().unwrap_or(0.0)) * (view.camera.eye - view.camera.target);
            look.view.camera.eye = view.camera.target + arm;
        });
        self.look.view = view;
        sketched
    }

    fn turn(&mut self) -> Result<Turned> {
        let [light_milliseconds, finished_milliseconds] = medians(self.frames, || {
            self.look.illumination.rotation += TURN;
            turned(&mut self.scene, &self.look)
        })?;
        Ok(Turned { light_milliseconds, finished_milliseconds })
    }

    /// Picture times after each change; `change` receives the index of the edited material.
    fn sketched(&mut self, mut change: impl FnMut(&mut Look, usize)) -> Result<Sketched> {
        let tiles: Vec<u32> = (0..Tiles::of(self.look.view.size).count()).collect();
        let [sketch_milliseconds, finished_milliseconds] = medians(self.frames, || {
            change(&mut self.look, self.edited);
            sketched(&mut self.scene, &self.look, &tiles)
        })?;
        Ok(Sketched { sketch_milliseconds, finished_milliseconds })
    }
}

/// Median milliseconds of the two parts of some work, after one run to warm up.
fn medians(frames: u32, mut work: impl FnMut() -> Result<[Duration; 2]>) -> Result<[f64; 2]> {
    work()?;
    let times = (0..frames).map(|_| work()).collect::<Result<Vec<_>>>()?;
    Ok([0, 1].map(|part| median(times.iter().map(|parts| parts[part]).collect())))
}

/// Lights a look and renders its first sample in the window's steps, including shading of pixels that no neighbor fits. Returns the
/// times to the coarsest sketch on the display and to the finished sample.
fn sketched(scene: &mut LitScene, look: &Look, tiles: &[u32]) -> Result<[Duration; 2]> {
    let start = Instant::now();
    scene.light(look)?;
    scene.resume(&look.view, look.sampling)?;
    let [first, finer @ ..] = STRIDES;
    scene.sketch(first, tiles)?;
    scene.fill(0)?;
    scene.backend().display(&look.post, 0)?;
    let sketched = start.elapsed();
    for stride in finer {
        scene.sketch(stride, tiles)?;
    }
    scene.backend().display(&look.post, 1)?;
    Ok([sketched, start.elapsed()])
}

/// Times from a rotated environment to its light, and to the first sample.
fn turned(scene: &mut LitScene, look: &Look) -> Result<[Duration; 2]> {
    let start = Instant::now();
    scene.light(look)?;
    let lit = start.elapsed();
    scene.resume(&look.view, look.sampling)?;
    scene.render_rows(0, 0..look.view.size[1])?;
    Ok([lit, start.elapsed()])
}

fn text(edits: &Edits) -> String {
    let Edits { adapter, material, size: [width, height], vertices, frames, edit, orbit, turned } = edits;
    let mut text =
        format!("{adapter}: {width} x {height}, {vertices} vertices, medians of {frames}, \"{material}\" edited\n");
    for (what, Sketched { sketch_milliseconds, finished_milliseconds }) in [("edit", edit), ("orbit", orbit)] {
        text += &format!(
            "{what:>8}: first sketch after {sketch_milliseconds:.1} ms, finished after {finished_milliseconds:.1} ms\n"
        );
    }
    if let Some(Turned { light_milliseconds, finished_milliseconds }) = turned {
        text += &format!(
            "    turn: light after {light_milliseconds:.1} ms, finished after {finished_milliseconds:.1} ms\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::dataset;
    use lapidary_render::{Appearance, Backend, Baked, Components, CpuBackend, test_looks};

    fn subject(components: Components) -> Subject {
        let baked = Baked::from(dataset(&["a"], &[]));
        let look = Look { appearance: Appearance::of(&baked.dataset.scene), components, ..test_looks::look() };
        let scene = LitScene::new(Box::new(CpuBackend::new()) as Box<dyn Backend>, baked).unwrap();
        let mut subject = Subject { scene, look, edited: 0, frames: 2 };
        subject.scene.show_whole(&subject.look).unwrap();
        subject
    }

    #[test]
    fn the_sketch_comes_before_the_finished_picture_and_the_view_is_as_before() {
        let mut subject = subject(Components { indirect: false, ..Components::ALL });
        let before = subject.look.view.camera.eye;
        let (edit, orbit, turned) = (subject.edit().unwrap(), subject.orbit().unwrap(), subject.turn().unwrap());
        for Sketched { sketch_milliseconds, finished_milliseconds } in [edit, orbit] {
            assert!(0.0 < sketch_milliseconds && sketch_milliseconds < finished_milliseconds);
        }
        assert!(0.0 < turned.light_milliseconds && turned.light_milliseconds < turned.finished_milliseconds);
        assert_eq!(subject.look.view.camera.eye, before);
        assert!(subject.look.illumination.rotation > 0.3 + 2.0 * TURN, "three turns");
    }

    #[test]
    fn a_material_that_is_not_there_is_told_with_those_that_are() {
        let dataset = dataset(&["gold", "wood"], &[]);
        assert_eq!(index_of(&dataset.scene, "wood").unwrap(), 1);
        let error = index_of(&dataset.scene, "Wood").unwrap_err().to_string();
        assert_eq!(error, "there is no material \"Wood\"; there are gold, wood");
    }
}
