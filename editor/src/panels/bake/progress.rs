//! How far a bake is: one bar a phase, and when the present one will end.

use super::BakeStatus;
use crate::{
    actions::Action,
    panels::units::{duration, grouped},
};
use egui::{Grid, ProgressBar, RichText, Ui};
use lapidary_precompute::Phase;

const PHASES: [(Phase, &str, &str); 6] = [
    (Phase::Import, "Import", "Reading the scene."),
    (Phase::Tessellate, "Tessellate", "Splitting triangles where visibility varies."),
    (Phase::Pilot, "Pilot", "Visibility of a few vertices, to cluster the lights by."),
    (Phase::Tree, "Light tree", "Clustering the lights."),
    (Phase::Visibility, "Visibility", "Tracing every vertex against every light."),
    (Phase::Pack, "Pack", "Packing and writing the dataset."),
];

/// Shows a running bake, with a button to stop it.
pub fn show(ui: &mut Ui, status: &BakeStatus, actions: &mut Vec<Action>) {
    let BakeStatus::Running { phase, done, total, unit, elapsed_secs, phase_elapsed_secs } = *status else { return };
    let current = PHASES.iter().position(|(p, ..)| *p == phase).unwrap_or_default();
    Grid::new("phases").num_columns(2).show(ui, |ui| {
        for (i, (_, name, help)) in PHASES.iter().enumerate() {
            let text = RichText::new(*name);
            ui.label(if i == current { text.strong() } else { text.weak() }).on_hover_text(*help);
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
}
