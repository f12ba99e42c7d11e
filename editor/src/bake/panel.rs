//! The bake: presets with their cost, all settings, progress, and the report of the last one.

mod estimate;
pub mod histogram;
pub mod mode;
mod progress;
mod report;
mod settings;
#[cfg(test)]
mod tests;
mod views;

#[cfg(test)]
pub use estimate::{Estimate, test_speed};
pub use estimate::{NODE_BYTES, SceneStats, Speed};
pub use progress::line;

use crate::{
    actions::{Action, BakeAction},
    control_names::error_text,
    document::Document,
    widgets::{copyable, section},
};
use egui::{RichText, Ui};
use lapidary_core::dataset::{BakeParts, Dataset};
use lapidary_precompute::{BounceTrial, Leftover, Phase, Trial, resolve};

/// Input of the panel.
pub struct BakeContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The dataset that is shown, with its report.
    pub dataset: Option<&'a Dataset>,
    /// Status of the bake.
    pub status: &'a BakeStatus,
    /// Differences between the dataset and a new bake.
    pub reasons: &'a [String],
    /// Size of the scene before tessellation, if it is known.
    pub scene_stats: Option<SceneStats>,
    /// Result of a trial of a few of its points, if known.
    pub trial: Option<Trial>,
    /// The same for the parts that bounce light, if they are to be baked.
    pub bounce_trial: Option<BounceTrial>,
    /// Cores that a bake may use, for estimates.
    pub cores: usize,
}

impl BakeContext<'_> {
    /// Vertices of the scene before tessellation, if they are known.
    fn source_vertices(&self) -> Option<usize> {
        let of_scene = self.scene_stats.map(|s| s.vertices);
        of_scene.or(self.dataset.map(|d| d.report.source_vertices)).filter(|v| *v > 0)
    }
}

/// Stage of a bake that may begin with a draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Draft {
    /// There is none.
    None,
    /// It is being baked.
    UnderWay,
    /// It is shown while the bake continues.
    Shown,
}

/// Status of the bake.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeStatus {
    /// Nothing was baked yet.
    None,
    /// Another bake would give the same dataset.
    UpToDate,
    /// Another bake would give another dataset.
    Stale {
        /// The differences, in sentences.
        reasons: Vec<String>,
    },
    /// A bake is running.
    Running {
        /// Parts that are baked.
        mode: BakeParts,
        /// Whether a draft comes first.
        draft: Draft,
        /// Its phase.
        phase: Phase,
        /// Units of the phase that are complete.
        done: u64,
        /// Units of the phase; 0 if unknown.
        total: u64,
        /// Name of a unit.
        unit: &'static str,
        /// Whether it was asked to stop, and has not stopped yet.
        cancelling: bool,
        /// Seconds since the bake began.
        elapsed_secs: f64,
        /// Seconds that the phase will still take, if that is known.
        left_secs: Option<f64>,
    },
    /// It was stopped.
    Cancelled {
        /// Its remains.
        leftover: Leftover,
    },
    /// It went wrong.
    Failed {
        /// Cause and remedy.
        message: String,
        /// Its remains.
        leftover: Leftover,
    },
}

/// Shows the panel. It keeps nothing between frames.
pub fn show(ui: &mut Ui, context: &BakeContext, actions: &mut Vec<Action>) {
    if let BakeStatus::Running { .. } = context.status {
        progress::show(ui, context.status, actions);
    } else {
        notice(ui, context.status);
        if let BakeStatus::Cancelled { .. } | BakeStatus::Failed { .. } = context.status {
            differences(ui, context.reasons);
        }
        let speed = Speed::known(context);
        mode::show(ui, &context.document.bake, &speed, actions);
        views::show(ui, context.document, actions);
        buttons(ui, context, actions);
        settings::presets(ui, context, &speed, actions);
        section(ui, "Advanced", false, |ui| {
            settings::advanced(ui, &context.document.bake, actions);
            mode::advanced(ui, context.document.bake.mode, actions);
        });
    }
    if let Some(dataset) = context.dataset {
        section(ui, "Report", true, |ui| report::show(ui, &dataset.report, &dataset.settings));
    }
}

/// Notice before a bake.
fn notice(ui: &mut Ui, status: &BakeStatus) {
    let warn = ui.visuals().warn_fg_color;
    match status {
        BakeStatus::None => ui.label("Not baked yet. After one bake, edit materials and light freely."),
        BakeStatus::UpToDate => ui.label("The bake is up to date."),
        BakeStatus::Stale { reasons } => {
            ui.label(RichText::new("The bake is out of date").color(warn).strong());
            ui.label(listed(reasons))
        }
        BakeStatus::Cancelled { leftover } => ui.label(match leftover {
            Leftover::Fitting => "The bake was stopped. Resume continues it.",
            Leftover::OfAnother => {
                "A bake with other settings, or of another version of the scene, was stopped. Choose its settings again \
                 to resume it; another bake discards it."
            }
            Leftover::Nothing => "The bake was stopped before anything could be kept.",
        }),
        BakeStatus::Failed { message, .. } => {
            copyable(ui, RichText::new(message).color(ui.visuals().error_fg_color))
        }
        BakeStatus::Running { .. } => return,
    };
}

fn listed(reasons: &[String]) -> String {
    reasons.iter().map(|r| format!("• {r}")).collect::<Vec<_>>().join("\n")
}

/// The parts of the shown bake that are out of date, after another bake did not finish.
fn differences(ui: &mut Ui, reasons: &[String]) {
    if !reasons.is_empty() {
        ui.label("The previous bake is shown, and is out of date:");
        ui.label(listed(reasons));
    }
}

fn buttons(ui: &mut Ui, context: &BakeContext, actions: &mut Vec<Action>) {
    let obstacle = obstacle(context.document);
    let can_resume = matches!(
        context.status,
        BakeStatus::Cancelled { leftover: Leftover::Fitting } | BakeStatus::Failed { leftover: Leftover::Fitting, .. }
    );
    ui.horizontal(|ui| {
        let mut button = |text: &str, help: &str, resume: bool| {
            let button = ui.add_enabled(obstacle.is_none(), egui::Button::new(text)).on_hover_text(help);
            if button.on_disabled_hover_text(obstacle.as_deref().unwrap_or_default()).clicked() {
                actions.push(Action::Bake(BakeAction::Begin { resume }));
            }
        };
        if can_resume {
            button("Resume", "Continues from the checkpoint.", true);
            button("Start over", "Bakes from the beginning.", false);
        } else {
            button("Bake", "Traces the visibility of the scene.", false);
        }
    });
    if let Some(obstacle) = obstacle {
        ui.label(RichText::new(obstacle).color(ui.visuals().warn_fg_color));
    }
}

/// Why there can be no bake now.
fn obstacle(document: &Document) -> Option<String> {
    if document.scene.is_none() {
        return Some("Open the scene file to bake it; a dataset alone cannot be baked again.".into());
    }
    resolve(document.bake.clone()).err().map(|error| error_text(&error))
}
