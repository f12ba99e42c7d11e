//! What is measured of a baked scene: frames, an edit of a material, a step of the camera, a turn of the environment, and
//! lit cuts.

use super::{meter::Meter, scenes::Case};
use anyhow::Result;
use glam::{Quat, Vec3};
use lapidary_core::{
    color::luminance,
    cut::{
        lit::{CutValues, DEFAULT_TAU, LitCuts},
        packed::PackedCuts,
    },
};
use lapidary_render::{Backend, BrdfSampling, CpuBackend, LitScene, Look, STRIDES, Tiles};
use std::time::{Duration, Instant};

/// Radians that the environment or the camera is turned by, as little as a drag by some pixels does.
const TURN: f32 = 0.05;

/// Factor of the base colour and the roughness of the edited material, to and fro.
const EDIT: f32 = 0.9;

/// Measures all of a scene but its bake.
///
/// # Errors
/// Ctrl-C.
pub fn measure(case: &Case, meter: &mut Meter) -> Result<()> {
    let scene = LitScene::new(Box::new(CpuBackend::new()), case.baked.clone())?.keep_unseen_changes();
    let mut subject = Subject { case, scene, look: case.look.clone() };
    subject.frames(meter)?;
    subject.drag(meter)?;
    subject.orbit(meter)?;
    if case.look.components.environment {
        subject.rotation(meter)?;
    }
    subject.lit_cuts(meter)
}

/// A scene on the renderer.
struct Subject<'a> {
    case: &'a Case,
    scene: LitScene<CpuBackend>,
    look: Look,
}

impl Subject<'_> {
    fn named(&self, what: &str) -> String {
        format!("{}: {what}", self.case.name)
    }

    /// A sample of the whole picture under light that stays, for each way of merging.
    fn frames(&mut self, meter: &mut Meter) -> Result<()> {
        let ways = [("lit", BrdfSampling::Lit), ("refine", BrdfSampling::Refine), ("once", BrdfSampling::Once)];
        for (name, sampling) in ways {
            self.scene.light(&Look { sampling, ..self.look.clone() })?;
            meter.measure([self.named(&format!("frame, {name}"))], || {
                self.scene.begin(&self.look.view, sampling)?;
                timed(|| Ok(self.scene.render_rows(0, 0..self.look.view.size[1])?))
            })?;
        }
        self.scene.light(&self.look)?;
        self.scene.show_whole(&self.look)?;
        Ok(())
    }

    /// From an edit of a material to the first sketch on the display, and to the finished first sample.
    fn drag(&mut self, meter: &mut Meter) -> Result<()> {
        let names = ["drag, first sketch", "drag, finished"].map(|what| self.named(what));
        let tiles: Vec<u32> = (0..Tiles::of(self.look.view.size).count()).collect();
        let mut factors = [EDIT, 1.0 / EDIT].into_iter().cycle();
        meter.measure(names, || {
            let factor = factors.next().unwrap_or(1.0);
            let parameters = &mut self.look.appearance.materials[self.case.edited].parameters;
            parameters.set("roughness", factor * parameters.number("roughness"));
            parameters.set("base_color", factor * parameters.color("base_color"));
            sketched(&mut self.scene, &self.look, &tiles)
        })
    }

    /// From a step of the camera around its target to the first sketch on the display, and to the finished first sample.
    fn orbit(&mut self, meter: &mut Meter) -> Result<()> {
        let names = ["orbit, first sketch", "orbit, finished"].map(|what| self.named(what));
        let tiles: Vec<u32> = (0..Tiles::of(self.look.view.size).count()).collect();
        let (view, mut steps) = (self.look.view.clone(), [TURN, 0.0].into_iter().cycle());
        meter.measure(names, || {
            let arm = Quat::from_rotation_y(steps.next().unwrap_or(0.0)) * (view.camera.eye - view.camera.target);
            self.look.view.camera.eye = view.camera.target + arm;
            sketched(&mut self.scene, &self.look, &tiles)
        })?;
        self.look.view = view;
        Ok(())
    }

    /// From a turned environment to its light, and to the first sample, for which lit cuts are made anew.
    fn rotation(&mut self, meter: &mut Meter) -> Result<()> {
        let names = ["rotation, light", "rotation, finished"].map(|what| self.named(what));
        meter.measure(names, || {
            self.look.light.rotation += TURN;
            let start = Instant::now();
            self.scene.light(&self.look)?;
            let lit = start.elapsed();
            self.scene.resume(&self.look.view, self.look.sampling)?;
            self.scene.render_rows(0, 0..self.look.view.size[1])?;
            Ok([lit, start.elapsed()])
        })
    }

    /// Lit cuts of all vertices, over the environment and over surface sources.
    fn lit_cuts(&mut self, meter: &mut Meter) -> Result<()> {
        let dataset = self.case.baked.dataset.clone();
        if let Some(lighting) = self.scene.environment().filter(|_| self.look.components.environment) {
            let name = self.named("lit cuts, environment");
            measure_lit_cuts(meter, name, &dataset.cuts, CutValues::Visibility, &lighting.nodes.radiance)?;
        }
        let sources = self.scene.local().and_then(|local| local.sources()).zip(dataset.indirect.as_ref());
        if let Some((lighting, indirect)) = sources {
            let name = self.named("lit cuts, sources");
            measure_lit_cuts(meter, name, &indirect.cuts, CutValues::SolidAngles, &lighting.nodes.radiance)?;
        }
        Ok(())
    }
}

/// Lights a look and renders its first sample in the steps of the window, which also shades pixels that nothing resembles.
/// Times when the coarsest sketch was displayed, and when the sample was.
fn sketched(scene: &mut LitScene<CpuBackend>, look: &Look, tiles: &[u32]) -> Result<[Duration; 2]> {
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

fn measure_lit_cuts(
    meter: &mut Meter,
    name: String,
    cuts: &PackedCuts,
    values: CutValues,
    radiance: &[Vec3],
) -> Result<()> {
    meter.measure([name], || {
        timed(|| {
            LitCuts::new(values, radiance.iter().copied().map(luminance), DEFAULT_TAU).make_all(cuts);
            Ok(())
        })
    })
}

fn timed(work: impl FnOnce() -> Result<()>) -> Result<[Duration; 1]> {
    let start = Instant::now();
    work()?;
    Ok([start.elapsed()])
}
