//! The ladder as a page, and as a part of others.

use super::files::{StepFigures, Summary};
use crate::report::{
    self,
    chart::{AxisScale, Chart, Line},
    figure, section,
    text::{grouped, seconds, short},
};
use maud::{Markup, html};

/// The whole page; pictures lie beside it.
pub fn page(summary: &Summary) -> String {
    let [width, height] = summary.size;
    let head = format!("lapidary ladder, version {}, {width} x {height}, on {}", summary.version, summary.renderer);
    let reference = &summary.reference;
    let cuts = html! {
        p {
            "The illumination cut is the budget of a picture: it starts with the clusters whose radiance varies too much, and \
             spends what is left on the brightest. The reference is " (reference.what) ". It took "
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
                @let alternative = format!("illumination cut {}", step.illum_cut);
                (figure("", &step.png, summary.size, &alternative, caption(step)))
            }
            (figure("truth", &summary.reference.png, summary.size, "reference", truth))
        }
    }
}

fn caption(step: &StepFigures) -> Markup {
    html! {
        b { (grouped(step.illum_cut.into())) @if step.illum_cut == 1 { " node" } @else { " nodes" } }
        "relative RMSE " (short(step.rel_rmse)) br;
        "FLIP " (short(step.flip)) br;
        (seconds(step.seconds)) ", " (format!("{:.0}", step.mean_merged_nodes)) " merged nodes"
    }
}

/// Error against cut size, and against time.
pub fn charts(summary: &Summary) -> Markup {
    let lines = |x: fn(&StepFigures) -> f64| {
        let line = |name: &str, y: fn(&StepFigures) -> f64| Line {
            name: name.into(),
            points: summary.steps.iter().map(|step| (x(step), y(step))).collect(),
        };
        [line("rel. RMSE", |s| s.rel_rmse), line("FLIP", |s| s.flip)]
    };
    let chart =
        |title, x_label, lines: &[Line]| Chart { title, x_label, x: AxisScale::Log, y: AxisScale::Log, lines }.svg();
    let by_size = chart("Error by size", "nodes of the illumination cut", &lines(|s| s.illum_cut.into()));
    let by_time = chart("Error by time", "seconds a picture", &lines(|s| s.seconds));
    html! { div.grid.two { (by_size) (by_time) } }
}
