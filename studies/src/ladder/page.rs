//! The ladder as a page, and as a section of other pages.

use super::files::{StepFigures, Summary};
use crate::report::{
    self,
    chart::{AxisScale, Chart, Line},
    figure, section,
    text::{seconds, short},
};
use maud::{Markup, html};

/// The whole page; pictures are files beside it.
pub fn page(summary: &Summary) -> String {
    let [width, height] = summary.size;
    let head = format!("lapidary ladder, version {}, {width} x {height}, on {}", summary.version, summary.renderer);
    let reference = &summary.reference;
    let cuts = html! {
        p {
            "The illumination cut is the budget of a picture: it starts with the clusters whose radiance varies too much, and \
             spends what is left on the brightest. Lit cuts know the light and do without it: their nodes move at most a share of \
             a vertex’s light. Their time includes their making. The reference is " (reference.what) ". It took "
            (seconds(reference.seconds)) ". Environment: “" (summary.environment) "”."
        }
        (pictures(summary))
    };
    let files = html! {
        p {
            "All figures are in " a href="ladder.json" { "ladder.json" } ", all pictures on one "
            a href="sheet.png" { "sheet" } "; each lies beside this page as PNG and as scene-linear EXR."
        }
    };
    let sections = [
        section("Which cut is enough", cuts),
        section("Error against size and time", charts(summary)),
        section("Files", files),
    ];
    report::page("ladder of cut sizes", &head, &sections)
}

/// All pictures with error and time, the reference last.
pub fn pictures(summary: &Summary) -> Markup {
    let truth = html! { b { "Reference" } "every light sample" br; (seconds(summary.reference.seconds)) };
    html! {
        div.grid.six {
            @for step in &summary.steps {
                @let alternative = alternative(step);
                (figure("", &step.png, summary.size, &alternative, caption(step)))
            }
            (figure("truth", &summary.reference.png, summary.size, "reference", truth))
        }
    }
}

fn alternative(step: &StepFigures) -> String {
    match step.cuts.size() {
        Some(size) => format!("illumination cut {size}"),
        None => step.cuts.label(),
    }
}

fn caption(step: &StepFigures) -> Markup {
    html! {
        b { (step.cuts.label()) }
        "relative RMSE " (short(step.rel_rmse)) br;
        "FLIP " (short(step.flip)) br;
        (seconds(step.seconds)) ", " (format!("{:.0}", step.mean_merged_nodes)) " merged nodes"
    }
}

/// Error against cut size, and against time. Lit cuts have no size: their errors are horizontal lines by size and points by time.
pub fn charts(summary: &Summary) -> Markup {
    let chart =
        |title, x_label, lines: &[Line]| Chart { title, x_label, x: AxisScale::Log, y: AxisScale::Log, lines }.svg();
    let by_size = chart("Error by size", "nodes of the illumination cut", &lines(summary, by_size));
    let by_time = chart("Error by time", "seconds a picture", &lines(summary, by_time));
    html! { div.grid.two { (by_size) (by_time) } }
}

/// Points of an error: steps with an illumination cut, and steps without.
type Drawn = fn(&Summary, Error) -> [Vec<(f64, f64)>; 2];
type Error = fn(&StepFigures) -> f64;

/// A line per error for the illumination cuts, then one for the lit cuts if there are any.
fn lines(summary: &Summary, drawn: Drawn) -> Vec<Line> {
    let errors: [(&str, Error); 2] = [("rel. RMSE", |s| s.rel_rmse), ("FLIP", |s| s.flip)];
    let of = |which: usize, of: &str| {
        let line = |(name, error): (&str, Error)| Line {
            name: format!("{of}{name}"),
            points: drawn(summary, error)[which].clone(),
        };
        errors.map(line)
    };
    of(0, "").into_iter().chain(of(1, "lit: ")).filter(|line| !line.points.is_empty()).collect()
}

fn by_size(summary: &Summary, error: Error) -> [Vec<(f64, f64)>; 2] {
    let sized = |step: &StepFigures| step.cuts.size().map(|size| (f64::from(size), error(step)));
    let stored: Vec<_> = summary.steps.iter().filter_map(sized).collect();
    let ends = || stored.first().into_iter().chain(stored.last()).map(|point| point.0);
    let unsized_steps = summary.steps.iter().filter(|step| step.cuts.size().is_none());
    let lit = unsized_steps.flat_map(|step| ends().map(move |x| (x, error(step)))).collect();
    [stored, lit]
}

fn by_time(summary: &Summary, error: Error) -> [Vec<(f64, f64)>; 2] {
    let (stored, lit): (Vec<_>, Vec<_>) = summary.steps.iter().partition(|step| step.cuts.size().is_some());
    [stored, lit].map(|steps: Vec<&StepFigures>| steps.into_iter().map(|step| (step.seconds, error(step))).collect())
}
