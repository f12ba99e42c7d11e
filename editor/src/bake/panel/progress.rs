//! Progress of a bake: one bar per step, and the time left in the present one. Phases are named after their light.

use super::{BakeStatus, Draft};
use crate::{
    actions::{Action, BakeAction},
    bake::parts::{self, Step},
    widgets::units::{duration, grouped},
};
use egui::{Align, Button, Grid, Layout, ProgressBar, RichText, Ui};
use lapidary_core::dataset::BakeParts;
use lapidary_precompute::Phase;

/// Phases of every bake.
const OF_ALL: [Step; 4] = [
    (Phase::Import, "Reading the scene", "Geometry and materials."),
    (Phase::Tessellate, "Refining the mesh", "Splitting triangles where shadows vary."),
    (Phase::Tree, "Building the light tree", "Clustering similar directions of the environment."),
    (Phase::Pack, "Writing the bake", "Packing and writing the file."),
];

/// Shows a running bake, with a button to stop it.
pub fn show(ui: &mut Ui, status: &BakeStatus, actions: &mut Vec<Action>) {
    let BakeStatus::Running { mode, draft, phase, done, total, unit, cancelling, elapsed_secs, left_secs } = *status
    else {
        return;
    };
    let title = match draft {
        Draft::None => "Baking",
        Draft::UnderWay => "Baking a first draft",
        Draft::Shown => "Baking in full",
    };
    ui.strong(title);
    ui.label(RichText::new(draft.meaning()).weak().small());
    let shown = steps(phase, mode);
    let current = shown.iter().position(|p| *p == phase).unwrap_or_default();
    Grid::new("phases").num_columns(2).show(ui, |ui| {
        for (i, shown) in shown.iter().enumerate() {
            let (name, help) = described(*shown);
            let text = RichText::new(name);
            ui.label(if i == current { text.strong() } else { text.weak() }).on_hover_text(help);
            let part = match i {
                i if i < current => 1.0,
                i if i == current && total > 0 => (done as f32 / total as f32).clamp(0.0, 1.0),
                _ => 0.0,
            };
            let bar = ui.add(ProgressBar::new(part).desired_height(8.0).desired_width(ui.available_width()));
            bar.accessible_name(format!("{name} progress"));
            ui.end_row();
        }
    });
    if total > 0 {
        ui.label(format!("{} of {} {unit}", grouped(done), grouped(total)));
    }
    if cancelling {
        ui.label("Canceling: stops at the next point");
    } else {
        let left = left_secs.map(duration);
        ui.label(left.map_or("Time left unknown".into(), |left| {
            format!("About {left} left in this step, longer while you work")
        }));
    }
    ui.label(RichText::new(format!("{} so far", duration(elapsed_secs))).weak());
    // On the other side than the button that begins a bake, whose double click would cancel it.
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        let cancel = ui.add_enabled(!cancelling, Button::new("Cancel"));
        if cancel.on_hover_text("Stops the bake and keeps its progress for later.").clicked() {
            actions.push(Action::Bake(BakeAction::Cancel));
        }
    });
}

impl Draft {
    /// Describes the present picture and the next.
    fn meaning(self) -> &'static str {
        match self {
            Self::None => "The picture stays as it is until the bake is complete.",
            Self::UnderWay => "The coarse draft is shown when it is done. The full bake follows.",
            Self::Shown => {
                "The picture shows the draft: lights and materials can be edited. The full bake replaces it."
            }
        }
    }
}

/// One line about a running bake: its phase, its progress and the time left.
pub fn line(status: &BakeStatus) -> Option<String> {
    let BakeStatus::Running { mode, draft, phase, done, total, left_secs, .. } = *status else { return None };
    let shown = steps(phase, mode);
    let step = shown.iter().position(|p| *p == phase).unwrap_or_default() + 1;
    let what = match draft {
        Draft::None => "Baking",
        Draft::UnderWay => "Baking a draft, the full bake follows",
        Draft::Shown => "Draft shown, full bake running",
    };
    let mut line = format!("{what}: {}", described(phase).0);
    if total > 0 {
        line += &format!(", {:.0} %", 100.0 * (done as f64 / total as f64).min(1.0));
    }
    if let Some(left) = left_secs.map(duration) {
        line += &format!(", {left} left");
    }
    Some(format!("{line} (step {step} of {})", shown.len()))
}

/// The phases of a bake of this mode, and the present one in any case.
fn steps(phase: Phase, mode: BakeParts) -> Vec<Phase> {
    Phase::ALL.into_iter().filter(|p| *p == phase || runs_in(*p, mode)).collect()
}

/// Whether a bake of this mode goes through a phase.
fn runs_in(phase: Phase, mode: BakeParts) -> bool {
    let mut steps = OF_ALL.into_iter().chain(mode.parts().flat_map(|part| parts::of(part).steps(mode)));
    steps.any(|(step, ..)| step == phase)
}

/// Name and description of a phase.
pub fn described(phase: Phase) -> (&'static str, &'static str) {
    let mut steps = OF_ALL.into_iter().chain(parts::all().flat_map(|part| part.steps(BakeParts::ALL)));
    let step = steps.find(|(step, ..)| *step == phase);
    step.map_or((phase.name(), ""), |(_, name, help)| (name, help))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_what_is_a_draft_and_what_comes() {
        let running = |draft, phase, done| BakeStatus::Running {
            mode: BakeParts::INDIRECT,
            draft,
            phase,
            done,
            total: 1000,
            unit: "points",
            cancelling: false,
            elapsed_secs: 90.0,
            left_secs: (done > 0).then_some(55.0),
        };
        let line = |draft, phase, done| line(&running(draft, phase, done)).unwrap();
        let drafting = line(Draft::UnderWay, Phase::Points, 0);
        assert_eq!(drafting, "Baking a draft, the full bake follows: Placing surface sources, 0 % (step 4 of 7)");
        let shown = line(Draft::Shown, Phase::SourceVisibility, 450);
        assert_eq!(shown, "Draft shown, full bake running: Source visibility, 45 %, 55 s left (step 6 of 7)");
        assert_eq!(super::line(&BakeStatus::UpToDate), None);
    }

    #[test]
    fn each_mode_shows_its_phases_under_names_of_their_own() {
        let phases = |mode| Phase::ALL.into_iter().filter(|p| runs_in(*p, mode)).count();
        let modes = [BakeParts::ENVIRONMENT, BakeParts::INDIRECT, BakeParts::CUTS, BakeParts::MESHLESS, BakeParts::ALL];
        assert_eq!(modes.map(phases), [6, 7, 10, 6, 12]);
        let names: std::collections::BTreeSet<_> = Phase::ALL.map(|p| described(p).0).into();
        assert_eq!(names.len(), Phase::ALL.len());
        assert!(Phase::ALL.iter().all(|phase| !described(*phase).1.is_empty()), "each has words");
        assert!(!runs_in(Phase::Points, BakeParts::ENVIRONMENT) && !runs_in(Phase::Visibility, BakeParts::INDIRECT));
    }
}
