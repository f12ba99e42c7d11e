//! Fig. 7: pictures and errors at growing illumination cuts and with lit cuts, for each scene under each kind of light.

use super::{Measurement, cases::Case, notebook::Notebook};
use crate::{
    args::DeviceArgs,
    ladder::{self, Found, Settings, Summary, Truth},
    report::text::seconds,
    terminal::Interrupted,
};
use anyhow::Result;
use lapidary_render::{Baked, LitScene, Look, Post};
use maud::{Markup, html};
use serde::Serialize;

/// Origin of a picture's light, as in the paper's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightKind {
    /// The environment, without bounces.
    Environment,
    /// Local lights and one bounce.
    Bounce,
}

/// A ladder of one scene.
pub struct SceneLadder {
    scene: String,
    /// Kind of light.
    pub light: LightKind,
    /// Its figures.
    pub summary: Summary,
    /// The reference of the pictures.
    pub truth: Truth,
}

#[derive(Serialize)]
struct Entry<'a> {
    scene: &'a str,
    light: LightKind,
    sheet: String,
    #[serde(flatten)]
    summary: &'a Summary,
}

impl SceneLadder {
    /// Whether it belongs to a case under the environment.
    pub fn of_environment_of(&self, case: &Case) -> bool {
        self.is_of(case, LightKind::Environment)
    }

    /// Whether it belongs to a case under this kind of light.
    pub fn is_of(&self, case: &Case, light: LightKind) -> bool {
        self.scene == case.name && self.light == light
    }
}

/// A baked case under one kind of light.
pub struct LitCase {
    /// Kind of light.
    pub light: LightKind,
    /// The scene with its bake for this light.
    pub baked: Baked,
    /// The look of its pictures.
    pub look: Look,
}

/// A case under each of its kinds of light.
pub fn lit_cases(measurement: &Measurement, case: &Case, size: [u32; 2]) -> Vec<LitCase> {
    let environment = case.environment.as_ref().map(|bakes| {
        let (baked, look) = (bakes.mixed().clone().into(), measurement.lit_from_afar(bakes.mixed(), size));
        LitCase { light: LightKind::Environment, baked, look }
    });
    let bounce = case.bounces.as_ref().map(|dataset| {
        let (baked, look) = (dataset.clone().into(), measurement.lit_by_lamps(dataset, size));
        LitCase { light: LightKind::Bounce, baked, look }
    });
    environment.into_iter().chain(bounce).collect()
}

/// Climbs all ladders; each is written when complete.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, cases: &[Case], notebook: &mut Notebook) -> Result<Vec<SceneLadder>> {
    let mut ladders = Vec::new();
    for case in cases {
        for lit in lit_cases(measurement, case, measurement.scale.view) {
            ladders.push(climb(measurement, case, lit)?);
        }
    }
    let entry = |ladder: &'_ SceneLadder| format!("fig7-{}", stem(&ladder.scene, ladder.light));
    let entries: Vec<Entry> = ladders
        .iter()
        .map(|l| Entry { scene: &l.scene, light: l.light, sheet: entry(l) + ".png", summary: &l.summary })
        .collect();
    notebook.record("fig7_ladder", "Fig. 7: size of the illumination cut", markup(&ladders), &entries)?;
    Ok(ladders)
}

fn stem(scene: &str, light: LightKind) -> String {
    let light = match light {
        LightKind::Environment => "environment",
        LightKind::Bounce => "bounce",
    };
    format!("{scene}-{light}")
}

fn climb(measurement: &Measurement, case: &Case, lit: LitCase) -> Result<SceneLadder> {
    let LitCase { light, baked, look } = lit;
    let name = stem(&case.name, light);
    measurement.steps.begin(&format!("ladder of {name}"));
    let prefix = format!("fig7-{name}-");
    let progress = measurement.steps.progress("reference", "pixels");
    let mut scene = LitScene::new(DeviceArgs::CPU.open()?, baked)?;
    let write = &mut |found: Found| ladder::write_picture(found, measurement.out, &prefix);
    let ladder = ladder::climb(&mut scene, &look, &Settings::of(&look), None, &progress, write)?;
    progress.finish();
    let ladder = ladder.ok_or(Interrupted)?;
    ladder::sheet(&ladder, &Post::default()).write_png(&measurement.out.join(format!("fig7-{name}.png")))?;
    let summary = Summary::new(&look, &ladder, &prefix);
    Ok(SceneLadder { scene: case.name.clone(), light, summary, truth: ladder.truth })
}

fn markup(ladders: &[SceneLadder]) -> Markup {
    html! {
        p {
            "The illumination cut is the budget of a picture. Errors are against the same lights without cuts, ray traced at \
             every pixel, on surfaces alone. The paper finds artefacts at 1 and 32 nodes, and 256 in many cases sufficient; \
             here a node’s light is read where visibility and BRDF have split it, so that short cuts lose less. The last picture \
             is of lit cuts, which need no illumination cut."
        }
        @for ladder in ladders {
            @let reference = &ladder.summary.reference;
            h3 { (stem(&ladder.scene, ladder.light)) }
            p { "Reference: " (reference.what) "; " (seconds(reference.seconds)) "." }
            (ladder::pictures(&ladder.summary))
            (ladder::charts(&ladder.summary))
        }
    }
}
