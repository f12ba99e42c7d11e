//! Finds the cut size that suffices for a shot: shows pictures of growing sizes and of lit cuts beside the reference, each with its
//! error and time, two curves, and a verdict.

use crate::{
    actions::{Action, LadderAction},
    widgets::copyable,
};
use egui::{Button, Color32, Grid, ProgressBar, RichText, ScrollArea, TextureHandle, Ui, Vec2, vec2};
use egui_plot::{GridMark, HoverPosition, Line, Plot, PlotPoints, Points};
use lapidary_studies::{
    jobs::ladder::StepFigures,
    ladder::Cuts,
    report::{chart::tick_step, text::short},
};

/// Width of a tile in points.
const TILE: f32 = 216.0;
/// Points between tiles.
const GAP: f32 = 10.0;
/// Points beside the tiles for the scroll bar.
const BAR: f32 = 16.0;
/// Window size in points for four tiles side by side, and both curves below.
pub const SIZE: Vec2 = vec2(4.0 * (TILE + GAP) + BAR, 800.0);
/// Height of the curves.
const CURVE: f32 = 150.0;
/// A size suffices if its relative RMSE and its FLIP are at most this multiple of those of the largest size. A few dark
/// shadows dominate the first, visible differences the second.
const ENOUGH: f64 = 1.25;

/// Width in points below which the curves' numbers would run together.
pub const LEAST_WIDTH: f32 = 2.0 * (TILE + GAP) + BAR;

/// A picture of some cuts.
pub struct LadderTile {
    /// The merged cuts.
    pub cuts: Cuts,
    /// The picture.
    pub texture: TextureHandle,
    /// Its figures, once part of the reference exists.
    pub figures: Option<StepFigures>,
}

/// The reference.
pub struct LadderTruth {
    /// The picture.
    pub texture: TextureHandle,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Description of the reference.
    pub what: String,
}

/// Results so far.
#[derive(Default)]
pub struct LadderResult {
    /// The pictures, by growing size, then lit cuts.
    pub tiles: Vec<LadderTile>,
    /// The reference, once it is traced.
    pub truth: Option<LadderTruth>,
    /// Traced share of the reference; `None` when nothing runs.
    pub progress: Option<f32>,
    /// Why the ladder stopped.
    pub problem: Option<String>,
}

/// Shows the results. `current` are the cuts in use.
pub fn show(ui: &mut Ui, result: &LadderResult, current: Cuts, actions: &mut Vec<Action>) {
    if let Some(problem) = &result.problem {
        copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color));
    }
    if let Some(progress) = result.progress {
        let text = format!("Tracing the reference, {:.0} %", 100.0 * progress);
        ui.add(ProgressBar::new(progress).text(text));
    }
    let figures: Vec<StepFigures> = result.tiles.iter().filter_map(|tile| tile.figures).collect();
    let complete = result.progress.is_none() && result.problem.is_none();
    if let Some(verdict) = verdict(&figures).filter(|_| figures.len() == result.tiles.len()) {
        if complete {
            copyable(ui, RichText::new(verdict).strong());
        } else {
            ui.label(format!("So far: {verdict}"));
        }
        let [width, height] = result.tiles.first().map_or([0; 2], |tile| tile.texture.size());
        ui.weak(format!(
            "Times are for {width} x {height} pixels with one sample each, a size with a quick reference."
        ));
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        tiles(ui, result, current, actions);
        if figures.len() > 1 {
            ui.add_space(6.0);
            curves(ui, &figures);
        }
    });
}

/// Lays out as many tiles side by side as fit.
fn tiles(ui: &mut Ui, result: &LadderResult, current: Cuts, actions: &mut Vec<Action>) {
    let columns = (((ui.available_width() + GAP) / (TILE + GAP)) as usize).max(1);
    Grid::new("cut sizes").num_columns(columns).spacing(Vec2::splat(GAP)).show(ui, |ui| {
        for (i, tile) in result.tiles.iter().enumerate() {
            show_tile(ui, tile, tile.cuts == current, actions);
            if (i + 1) % columns == 0 {
                ui.end_row();
            }
        }
        result.truth.iter().for_each(|truth| show_truth(ui, truth));
    });
}

/// Verdict on sizes, and on lit cuts.
fn verdict(figures: &[StepFigures]) -> Option<String> {
    let (stored, lit): (Vec<StepFigures>, Vec<StepFigures>) = figures.iter().partition(|f| f.cuts.size().is_some());
    let sentences: Vec<String> = size_verdict(&stored).into_iter().chain(lit.iter().map(lit_verdict)).collect();
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

fn lit_verdict(lit: &StepFigures) -> String {
    format!("Lit cuts leave {} in {}, including making them.", error_text(lit), time_text(lit.seconds))
}

fn error_text(f: &StepFigures) -> String {
    format!("{:.1} % (FLIP {:.3})", 100.0 * f.metrics.rel_rmse, f.metrics.flip)
}

/// Verdict on the smallest size whose error is about the largest size's.
fn size_verdict(figures: &[StepFigures]) -> Option<String> {
    let last = figures.last()?;
    let is_enough = |f: &&StepFigures| {
        f.metrics.rel_rmse <= ENOUGH * last.metrics.rel_rmse && f.metrics.flip <= ENOUGH * last.metrics.flip
    };
    let enough = figures.iter().find(is_enough)?;
    let time = |f: &StepFigures| time_text(f.seconds);
    let (all, left) = (last.cuts.label(), error_text(last));
    Some(if enough.cuts == last.cuts {
        format!("Every size lowers the error: {all} leave {left} in {}.", time(last))
    } else {
        format!(
            "{} enough: {} of error in {}, where {all} leave {left} in {}. A larger illumination cut does not help further: Why? shows the causes of the rest.",
            if enough.cuts.size() == Some(1) { "1 node is".into() } else { format!("{} are", enough.cuts.label()) },
            error_text(enough),
            time(enough),
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
            ui.label(RichText::new(of.cuts.label()).strong());
            let label = if current { "In use" } else { "Use" };
            let button = ui.add_enabled(!current, Button::new(label).small());
            let help = match of.cuts.size() {
                Some(_) => format!("Use an illumination cut of {} in the viewport", of.cuts.label()),
                None => "Use lit cuts in the viewport".into(),
            };
            if button.on_hover_text(help).clicked() {
                actions.push(Action::Ladder(LadderAction::UseCuts(of.cuts)));
            }
        });
        let text = of.figures.map_or("error not known yet".into(), |f| {
            let merged = f.mean_merged_nodes;
            let error = 100.0 * f.metrics.rel_rmse;
            let time = time_text(f.seconds);
            format!("error {error:.2} %, FLIP {:.3}\n{time}, merged cut of {merged:.0} nodes", f.metrics.flip)
        });
        copyable(ui, RichText::new(text).small());
    });
}

fn show_truth(ui: &mut Ui, truth: &LadderTruth) {
    tile(ui, &truth.texture, |ui| {
        ui.label(RichText::new("Reference").strong()).on_hover_text(&truth.what);
        ui.label(RichText::new(format!("traced, without cuts, {}", time_text(truth.seconds))).small());
    });
}

/// Grid marks of equal strength.
fn marks(at: impl Iterator<Item = f64>, largest: f64) -> Vec<GridMark> {
    at.map(|value| GridMark { value, step_size: largest }).collect()
}

/// From zero to `largest`, at round values.
fn round_marks(largest: f64) -> Vec<GridMark> {
    let step = tick_step(largest);
    let count = (largest / step) as i32;
    marks((0..=count).map(|i| f64::from(i) * step), largest)
}

/// Error in percent against size, which is on a logarithmic scale, and against time. Lit cuts have no size: against size they are a
/// level line.
fn curves(ui: &mut Ui, figures: &[StepFigures]) {
    let (stored, lit): (Vec<StepFigures>, Vec<StepFigures>) = figures.iter().partition(|f| f.cuts.size().is_some());
    let width = 0.5 * (ui.available_width() - 10.0);
    ui.horizontal(|ui| {
        let by_size = points(&stored, log_size);
        let ends = || by_size.first().into_iter().chain(by_size.last()).map(|point| point[0]);
        let level = points(&lit, |_| 0.0).into_iter().flat_map(|point| ends().map(move |x| [x, point[1]])).collect();
        let sizes = Horizontal { value: |v| 10_f64.powf(v), marks: |at, largest| marks(at.iter().copied(), largest) };
        curve(ui, width, "Error in % by nodes of the illumination cut", [by_size, level], sizes);
        let by_time = [stored, lit].map(|figures| points(&figures, |f| 1e3 * f.seconds));
        let times = Horizontal { value: |v| v, marks: |_, largest| round_marks(largest) };
        curve(ui, width, "Error in % by render time in milliseconds", by_time, times);
    });
}

fn log_size(figures: &StepFigures) -> f64 {
    figures.cuts.size().map_or(0.0, |size| f64::from(size).log10())
}

/// Points of a quantity against the error in percent.
fn points(figures: &[StepFigures], of: impl Fn(&StepFigures) -> f64) -> Vec<[f64; 2]> {
    let point = |f: &StepFigures| [of(f), 100.0 * f.metrics.rel_rmse];
    figures.iter().filter(|f| f.metrics.rel_rmse.is_finite()).map(point).collect()
}

/// The horizontal axis of a curve.
struct Horizontal {
    /// Labeled value of a position.
    value: fn(f64) -> f64,
    /// Positions of labels, from the positions of points and the largest position shown.
    marks: fn(&[f64], f64) -> Vec<GridMark>,
}

/// Points of illumination cuts, and of lit cuts in a color of their own. Both axes begin at zero.
fn curve(ui: &mut Ui, width: f32, title: &str, points: [Vec<[f64; 2]>; 2], across: Horizontal) {
    let Horizontal { value, marks } = across;
    ui.vertical(|ui| {
        ui.label(RichText::new(title).small());
        let colors: [Color32; 2] = [ui.visuals().selection.bg_fill, ui.visuals().warn_fg_color];
        let plot = Plot::new(title)
            .width(width)
            .height(CURVE)
            .include_x(0.0)
            .include_y(0.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false);
        let at: Vec<f64> = points[0].iter().map(|point| point[0]).collect();
        let plot =
            plot.x_grid_spacer(move |axis| marks(&at, axis.bounds.1)).y_grid_spacer(|axis| round_marks(axis.bounds.1));
        let plot = plot
            .x_axis_formatter(move |mark, _| short(value(mark.value)))
            .y_axis_formatter(|mark, _| format!("{:.2}", mark.value))
            .label_formatter(move |hover| match hover {
                HoverPosition::NearDataPoint { position: at, .. } => {
                    Some(format!("{}: {:.2} %", short(value(at.x)), at.y))
                }
                HoverPosition::Elsewhere { .. } => None,
            });
        plot.show(ui, |plot| {
            for ((name, color), points) in ["sizes", "lit cuts"].into_iter().zip(colors).zip(points) {
                plot.line(Line::new(name, PlotPoints::from(points.clone())).color(color));
                plot.points(Points::new(name, PlotPoints::from(points)).radius(3.5).color(color));
            }
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
            cuts: Cuts::Refine(32 << i),
            seconds: 0.1 * (i + 1) as f64,
            mean_merged_nodes: 100.0,
            metrics: metrics(e),
        };
        errors.iter().enumerate().map(step).collect()
    }

    #[test]
    fn the_verdict_names_the_smallest_size_that_is_about_as_good() {
        let text = verdict(&figures(&[0.3, 0.06, 0.051, 0.05])).unwrap();
        assert!(
            text.starts_with("64 nodes are enough: 6.0 % (FLIP 0.010) of error in 200 ms, where 256 nodes leave 5.0 %"),
            "{text}"
        );
        let mut seen = figures(&[0.05, 0.05, 0.05]);
        seen[0].metrics.flip = 0.02;
        assert!(verdict(&seen).unwrap().starts_with("64 nodes are enough"), "what is seen counts, too");
        let text = verdict(&figures(&[0.3, 0.2, 0.1])).unwrap();
        assert!(
            text.starts_with("Every size lowers the error: 128 nodes leave 10.0 % (FLIP 0.010) in 300 ms"),
            "{text}"
        );
        assert_eq!(verdict(&[]), None);
        let mut with_lit = figures(&[0.3, 0.2, 0.1, 0.01]);
        with_lit[3].cuts = Cuts::Lit(0.003);
        let text = verdict(&with_lit).unwrap();
        assert!(text.starts_with("Every size lowers the error: 128 nodes leave 10.0 %"), "of sizes alone: {text}");
        assert!(text.ends_with("Lit cuts leave 1.0 % (FLIP 0.010) in 400 ms, including making them."), "{text}");
        assert!(!verdict(&with_lit[..3]).unwrap().contains("Lit"), "negative control");
    }

    #[test]
    fn what_is_infinite_is_in_no_curve() {
        let points = points(&figures(&[f64::INFINITY, 0.1]), log_size);
        assert_eq!(points.len(), 1);
        assert!((points[0][0] - 64_f64.log10()).abs() < 1e-12 && (points[0][1] - 10.0).abs() < 1e-12);
    }
}
