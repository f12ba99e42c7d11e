//! How far a bake is: one bar a phase, and when the present one will end.

use super::BakeStatus;
use crate::{
    actions::Action,
    panels::units::{duration, grouped},
};
use egui::{Grid, ProgressBar, RichText, Ui};
use lapidary_core::dataset::BakeMode;
use lapidary_precompute::Phase;

/// Shows a running bake, with a button to stop it.
pub fn show(ui: &mut Ui, status: &BakeStatus, actions: &mut Vec<Action>) {
    let BakeStatus::Running { mode, phase, done, total, unit, elapsed_secs, phase_elapsed_secs } = *status else {
        return;
    };
    let shown: Vec<Phase> = Phase::ALL.into_iter().filter(|p| *p == phase || runs_in(*p, mode)).collect();
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
    ui.label(remaining(done, total, phase_elapsed_secs));
    ui.label(RichText::new(format!("{} so far", duration(elapsed_secs))).weak());
    if ui.button("Cancel").on_hover_text("Stops the bake and keeps what was done, to resume later.").clicked() {
        actions.push(Action::CancelBake);
    }
}

/// Whether a bake of this mode goes through a phase; the light tree is made for any.
fn runs_in(phase: Phase, mode: BakeMode) -> bool {
    match phase {
        Phase::Import | Phase::Tessellate | Phase::Tree | Phase::Pack => true,
        Phase::Pilot | Phase::Visibility => mode.environment(),
        Phase::Points | Phase::SourceTree | Phase::SourceVisibility => mode.indirect(),
        Phase::SourceEnvironment => mode.indirect() && mode.environment(),
        Phase::Basis | Phase::Transport => mode.meshless(),
    }
}

/// A phase's name and what it does.
pub fn described(phase: Phase) -> (&'static str, &'static str) {
    match phase {
        Phase::Import => ("Import", "Reading the scene."),
        Phase::Tessellate => ("Tessellate", "Splitting triangles where visibility varies."),
        Phase::Pilot => ("Pilot", "Visibility of a few vertices, to cluster the lights by."),
        Phase::Tree => ("Light tree", "Clustering the lights."),
        Phase::Visibility => ("Visibility", "Tracing every vertex against every light."),
        Phase::Points => ("Sources", "Placing surface sources where light reaches."),
        Phase::SourceTree => ("Source tree", "Clustering the sources."),
        Phase::SourceVisibility => ("Bounces", "Tracing every vertex against every source."),
        Phase::SourceEnvironment => ("Sky of sources", "Tracing every source against every light."),
        Phase::Basis => ("Basis", "Placing the points of the meshless basis."),
        Phase::Transport => ("Transport", "Light between the functions of the meshless basis."),
        Phase::Pack => ("Pack", "Packing and writing the dataset."),
    }
}

/// How long the present phase will still take, at the mean speed so far.
fn remaining(done: u64, total: u64, phase_elapsed_secs: f64) -> String {
    if done == 0 || total == 0 {
        return "Time left is not known yet".into();
    }
    let left = total.saturating_sub(done) as f64 * phase_elapsed_secs / done as f64;
    format!("About {} left in this phase", duration(left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_from_the_speed_so_far() {
        assert_eq!(remaining(25, 100, 20.0), "About 1 min 00 s left in this phase");
        assert_eq!(remaining(100, 100, 20.0), "About 0.0 s left in this phase");
        assert_eq!(remaining(0, 100, 20.0), remaining(5, 0, 20.0));
        assert_ne!(remaining(50, 100, 20.0), remaining(25, 100, 20.0));
    }

    #[test]
    fn each_mode_shows_its_phases_under_names_of_their_own() {
        let phases = |mode| Phase::ALL.into_iter().filter(|p| runs_in(*p, mode)).count();
        let modes = [BakeMode::Environment, BakeMode::Indirect, BakeMode::Meshless, BakeMode::All];
        assert_eq!(modes.map(phases), [6, 7, 6, 12]);
        let names: std::collections::BTreeSet<_> = Phase::ALL.map(|p| described(p).0).into();
        assert_eq!(names.len(), Phase::ALL.len());
        assert!(!runs_in(Phase::Points, BakeMode::Environment) && !runs_in(Phase::Visibility, BakeMode::Indirect));
    }
}
