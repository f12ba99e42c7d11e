//! Which size of the illumination cut is enough for this shot: pictures at growing sizes beside the reference, each with its error
//! and time, both curves, and a sentence.

use crate::{actions::Action, jobs::ladder::StepFigures};
use egui::{Button, Color32, ProgressBar, RichText, ScrollArea, TextureHandle, Ui, Vec2};
use egui_plot::{GridMark, HoverPosition, Line, Plot, PlotPoints, Points};

/// Width of a tile in points.
const TILE: f32 = 216.0;
/// Height of the curves.
const CURVE: f32 = 150.0;
/// A size is enough if its error is at most so many times that of the largest size.
const ENOUGH: f64 = 1.25;

/// A picture at one size.
pub struct LadderTile {
    /// Most nodes of the illumination cut.
    pub illum_cut: u32,
    /// The picture.
    pub texture: TextureHandle,
    /// Its figures, once the reference is there.
    pub figures: Option<StepFigures>,
}

/// The reference.
pub struct LadderTruth {
    /// The picture.
    pub texture: TextureHandle,
    /// Seconds of tracing.
    pub seconds: f64,
    /// What was traced.
    pub what: String,
}

/// What is known so far.
#[derive(Default)]
pub struct LadderResult {
    /// The pictures, by growing size.
    pub tiles: Vec<LadderTile>,
    /// The reference, once it is traced.
    pub truth: Option<LadderTruth>,
    /// Share of the reference that is traced; `None` when nothing is on its way.
    pub progress: Option<f32>,
    /// Why there is no more.
    pub problem: Option<String>,
}

/// Shows all of it. `current` is the size in use.
pub fn show(ui: &mut Ui, result: &LadderResult, current: u32, actions: &mut Vec<Action>) {
    if let Some(problem) = &result.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    if let Some(progress) = result.progress {
        let text = format!("Tracing the reference, {:.0} %", 100.0 * progress);
        ui.add(ProgressBar::new(progress).text(text));
    }
    let figures: Vec<StepFigures> = result.tiles.iter().filter_map(|tile| tile.figures).collect();
    if let Some(verdict) = verdict(&figures) {
        ui.label(RichText::new(verdict).strong());
    }
    ScrollArea::vertical().show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(10.0);
            result.tiles.iter().for_each(|tile| show_tile(ui, tile, tile.illum_cut == current, actions));
            result.truth.iter().for_each(|truth| show_truth(ui, truth));
        });
        if figures.len() > 1 {
            ui.add_space(6.0);
            curves(ui, &figures);
        }
    });
}

/// The smallest size whose error is about that of the largest, in words.
fn verdict(figures: &[StepFigures]) -> Option<String> {
    let last = figures.last()?;
    let enough = figures.iter().find(|f| f.metrics.rel_rmse <= ENOUGH * last.metrics.rel_rmse)?;
    let percent = |f: &StepFigures| format!("{:.1} %", 100.0 * f.metrics.rel_rmse);
    let time = |f: &StepFigures| time_text(f.seconds);
    Some(if enough.illum_cut == last.illum_cut {
        format!("Every size still helps: {} nodes leave {} in {}.", last.illum_cut, percent(last), time(last))
    } else {
        format!(
            "{} nodes are enough: they leave {} in {}, and {} nodes {} in {}. The rest comes from interpolated visibility.",
            enough.illum_cut,
            percent(enough),
            time(enough),
            last.illum_cut,
            percent(last),
            time(last)
        )
    })
}

fn time_text(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
}

fn tile(ui: &mut Ui, texture: &TextureHandle, contents: impl FnOnce(&mut Ui)) {
    ui.vertical(|ui| {
        ui.set_width(TILE);
        let size = texture.size_vec2();
        ui.image((texture.id(), size * (TILE / size.x)));
        contents(ui);
    });
}

fn show_tile(ui: &mut Ui, of: &LadderTile, current: bool, actions: &mut Vec<Action>) {
    tile(ui, &of.texture, |ui| {
        ui.horizontal(|ui| {
            let nodes = if of.illum_cut == 1 { "1 node".into() } else { format!("{} nodes", of.illum_cut) };
            ui.label(RichText::new(nodes).strong());
            let label = if current { "In use" } else { "Use" };
            let button = ui.add_enabled(!current, Button::new(label).small());
            if button.on_hover_text(format!("Use {} nodes of light in the viewport", of.illum_cut)).clicked() {
                actions.push(Action::UseIllumCut(of.illum_cut));
            }
        });
        let text = of.figures.map_or("error not known yet".into(), |f| {
            let merged = f.mean_merged_nodes;
            let error = 100.0 * f.metrics.rel_rmse;
            format!("error {error:.2} %, FLIP {:.3}, {}, {merged:.0} merged", f.metrics.flip, time_text(f.seconds))
        });
        ui.label(RichText::new(text).small());
    });
}

fn show_truth(ui: &mut Ui, truth: &LadderTruth) {
    tile(ui, &truth.texture, |ui| {
        ui.label(RichText::new("Reference").strong()).on_hover_text(&truth.what);
        ui.label(RichText::new(format!("traced, without cuts, {}", time_text(truth.seconds))).small());
    });
}

/// Error against size and against time, on logarithmic scales.
fn curves(ui: &mut Ui, figures: &[StepFigures]) {
    let width = 0.5 * (ui.available_width() - 10.0);
    ui.horizontal(|ui| {
        let by_size = points(figures, |f| f64::from(f.illum_cut));
        curve(ui, width, "Error, % by nodes of light", by_size, |v| format!("{v:.0}"));
        let by_time = points(figures, |f| 1e3 * f.seconds);
        curve(ui, width, "Error, % by milliseconds of the picture", by_time, |v| format!("{v:.0}"));
    });
}

/// Logarithms of something and of the error in percent.
fn points(figures: &[StepFigures], of: impl Fn(&StepFigures) -> f64) -> Vec<[f64; 2]> {
    let log = |value: f64| value.max(1e-6).log10();
    let point = |f: &StepFigures| [log(of(f)), log(100.0 * f.metrics.rel_rmse)];
    figures.iter().filter(|f| f.metrics.rel_rmse.is_finite()).map(point).collect()
}

fn curve(ui: &mut Ui, width: f32, title: &str, points: Vec<[f64; 2]>, format: fn(f64) -> String) {
    ui.vertical(|ui| {
        ui.label(RichText::new(title).small());
        let accent: Color32 = ui.visuals().selection.bg_fill;
        let power = move |mark: GridMark| format(10_f64.powf(mark.value));
        let plot = Plot::new(title).width(width).height(CURVE).allow_drag(false).allow_zoom(false).allow_scroll(false);
        let plot = plot
            .x_axis_formatter(move |mark, _| power(mark))
            .y_axis_formatter(|mark, _| format!("{:.1}", 10_f64.powf(mark.value)))
            .label_formatter(|hover| match hover {
                HoverPosition::NearDataPoint { position: at, .. } => {
                    Some(format!("{:.0}: {:.2} %", 10_f64.powf(at.x), 10_f64.powf(at.y)))
                }
                HoverPosition::Elsewhere { .. } => None,
            });
        plot.show(ui, |plot| {
            plot.line(Line::new("error", PlotPoints::from(points.clone())).color(accent));
            plot.points(Points::new("sizes", PlotPoints::from(points)).radius(3.5).color(accent));
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_render::compare::Metrics;

    fn figures(errors: &[f64]) -> Vec<StepFigures> {
        let metrics = |rel_rmse| Metrics {
            rmse: rel_rmse,
            rel_rmse,
            rel_mse: 0.0,
            psnr: 30.0,
            ssim: 1.0,
            flip: 0.01,
            pixels: 100,
            non_finite_pixels: 0,
        };
        let step = |(i, &e): (usize, &f64)| StepFigures {
            illum_cut: 32 << i,
            seconds: 0.1 * (i + 1) as f64,
            mean_merged_nodes: 100.0,
            metrics: metrics(e),
        };
        errors.iter().enumerate().map(step).collect()
    }

    #[test]
    fn the_verdict_names_the_smallest_size_that_is_about_as_good() {
        let text = verdict(&figures(&[0.3, 0.06, 0.051, 0.05])).unwrap();
        assert!(text.starts_with("64 nodes are enough: they leave 6.0 % in 200 ms, and 256 nodes 5.0 %"), "{text}");
        let text = verdict(&figures(&[0.3, 0.2, 0.1])).unwrap();
        assert!(text.starts_with("Every size still helps: 128 nodes leave 10.0 %"), "{text}");
        assert_eq!(verdict(&[]), None);
    }

    #[test]
    fn what_is_infinite_is_in_no_curve() {
        let points = points(&figures(&[f64::INFINITY, 0.1]), |f| f64::from(f.illum_cut));
        assert_eq!(points.len(), 1);
        assert!((points[0][0] - 64_f64.log10()).abs() < 1e-12 && (points[0][1] - 1.0).abs() < 1e-12);
    }
}
