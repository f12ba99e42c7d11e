//! The error of a picture by causes, as bars with numbers.

use super::ExplainRequest;
use egui::{Align, Layout, ProgressBar, Rect, RichText, Role, Sense, Ui, WidgetInfo, vec2};
use lapidary_render::{ErrorSplit, SplitStep};

/// Width of the names of causes in points.
const NAMES: f32 = 112.0;
/// Width of the numbers in points.
const NUMBERS: f32 = 56.0;

/// Shows the bars or their progress, and the button that makes them.
pub fn show(ui: &mut Ui, split: Option<&ErrorSplit>, progress: Option<f32>) -> Option<ExplainRequest> {
    if let Some(split) = split {
        bars(ui, split);
    }
    if let Some(done) = progress {
        ui.add(ProgressBar::new(done).show_percentage()).accessible_name("Error split progress");
        // On the other side than the button that begins.
        let cancel = ui.with_layout(Layout::right_to_left(Align::Min), |ui| ui.button("Cancel").clicked()).inner;
        return cancel.then_some(ExplainRequest::CancelSplit);
    }
    let help = "Replaces one factor at a time with its exact value. Traces light paths and takes a while.";
    let name = if split.is_some() { "Split again" } else { "Split the error" };
    ui.button(name).on_hover_text(help).clicked().then_some(ExplainRequest::Split)
}

fn bars(ui: &mut Ui, split: &ErrorSplit) {
    let rows = || split.steps.iter().chain([&split.total]);
    let top = rows().map(|step| step.rel_rmse).filter(|error| error.is_finite()).fold(0.0, f64::max);
    for step in rows() {
        bar(ui, step, top);
    }
    let [width, height] = split.region.size();
    let noise = 100.0 * split.total.noise;
    let text = format!("{width} x {height} pixels, {} light paths each: noise {noise:.1} %", split.spp);
    ui.label(RichText::new(text).weak());
}

/// One cause: its name, a bar up to `top`, its relative RMSE; the tooltip has the rest.
fn bar(ui: &mut Ui, step: &SplitStep, top: f64) {
    let height = ui.spacing().interact_size.y;
    let text = format!("{:.1} %", 100.0 * step.rel_rmse);
    ui.horizontal(|ui| {
        let name = RichText::new(label(step));
        ui.add_sized([NAMES, height], egui::Label::new(name).halign(egui::Align::Min));
        let room = (ui.available_width() - NUMBERS - ui.spacing().item_spacing.x).max(8.0);
        let (rect, response) = ui.allocate_exact_size(vec2(room, height), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Meter, true, format!("{} {text}", label(step))));
        let share = if top > 0.0 { (step.rel_rmse / top).clamp(0.0, 1.0) as f32 } else { 0.0 };
        let filled = Rect::from_min_size(rect.min, vec2(room * share, height)).shrink2(vec2(0.0, 4.0));
        ui.painter().rect_filled(filled, 2.0, ui.visuals().selection.bg_fill);
        response.on_hover_text(format!(
            "Relative RMSE {:.4}, RMSE {:.4}, FLIP {:.4}\n{} against {}",
            step.rel_rmse,
            step.rmse,
            step.flip,
            step.from.name(),
            step.to.name()
        ));
        ui.add_sized([NUMBERS, height], egui::Label::new(RichText::new(&text).monospace()));
    });
}

fn label(step: &SplitStep) -> String {
    let mut letters = step.factor.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    first + letters.as_str()
}
