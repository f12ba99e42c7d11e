//! The status line: the last message, and the figures of the picture.

use super::state::EditorState;
use crate::{
    jobs::render_thread::RenderedFrame,
    messages::{self, Severity},
    widgets::copyable,
};
use egui::{Align, Label, Layout, RichText, Ui};

/// Shows the line.
pub fn show(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            figures(ui, state.picture.shown().filter(|_| state.work.scene.rendered().is_some()));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let running = state.exporting.is_running();
                if running
                    && ui.small_button("Cancel").on_hover_text("Stop the export and keep complete frames").clicked()
                {
                    state.exporting.cancel();
                }
                message(ui, state);
            });
        });
    });
}

fn message(ui: &mut Ui, state: &EditorState) {
    let opening = state.opening.as_ref().map(|o| format!("Opening {}...", o.what));
    let shaders = || state.picture.render.compiles().then(|| "Compiling shaders...".to_owned());
    let remark = || state.work.messages.last_remark().map(str::to_owned);
    let held = || state.ladder.is_climbing().then(|| "The full picture waits while cut sizes are tried".to_owned());
    let work = || state.exporting.line().or_else(|| state.baking.line()).or_else(held);
    let text = match opening.or_else(shaders).or_else(work).or_else(remark) {
        Some(line) => RichText::new(line),
        None => match state.work.messages.last() {
            Some(entry) if entry.severity != Severity::Note => {
                RichText::new(&entry.text).color(messages::color(ui, entry.severity))
            }
            Some(entry) => RichText::new(&entry.text),
            None => RichText::new("F1 shows the keys").weak(),
        },
    };
    ui.add(Label::new(text).truncate().selectable(true));
}

/// From right to left, so that they stay at the edge while their figures change.
fn figures(ui: &mut Ui, shown: Option<&RenderedFrame>) {
    if let Some(bytes) = resident_bytes() {
        figure(ui, format!("{:>5} MB", bytes >> 20), "Memory used by Lapidary");
    }
    let Some(shown) = shown else { return };
    let stats = &shown.stats;
    figure(ui, format!("{:>4.0} BRDFs", stats.mean_brdf_evaluations), "BRDF evaluations per pixel");
    figure(ui, format!("{:>4.0} nodes", stats.mean_merged_nodes), "Nodes of the merged cut per pixel");
    figure(ui, time_text(shown.millis), "Render time");
    let size = format!("{} x {}", shown.size[0], shown.size[1]);
    let reduced = if shown.full_size && shown.samples > 0 { "" } else { " (preview)" };
    let samples = format!("{:>3}/{}", shown.samples, shown.of_samples);
    figure(ui, format!("{size}{reduced}  {samples}"), "Picture size in pixels, and samples per pixel");
    figure(ui, shown.backend.clone(), "Renderer");
}

fn figure(ui: &mut Ui, text: String, what: &str) {
    copyable(ui, RichText::new(text).monospace().weak()).on_hover_text(what);
    ui.add_space(8.0);
}

/// Memory of this process, if the system reports it.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kb| kb << 10)
}

/// Milliseconds as long as they fit into four digits.
fn time_text(millis: f64) -> String {
    if millis < 1e4 { format!("{millis:>5.0} ms") } else { format!("{:>5.1} s", 1e-3 * millis) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_times_are_in_seconds() {
        assert_eq!([720.0, 9999.0, 78_562.0].map(time_text), ["  720 ms", " 9999 ms", " 78.6 s"]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_memory_of_this_process_is_some_megabytes() {
        let bytes = resident_bytes().unwrap();
        assert!((1 << 20..1 << 40).contains(&bytes), "{bytes}");
    }
}
