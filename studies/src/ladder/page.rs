//! The ladder as a page, and as a part of others.

use super::files::{StepFigures, Summary};
use crate::report::{
    self,
    chart::{Chart, Line, Scale},
    figure, section,
    text::{escaped, grouped, seconds, short},
};

/// The whole page; pictures lie beside it.
pub fn page(summary: &Summary) -> String {
    let [width, height] = summary.size;
    let head = format!("lapidary ladder, version {}, {width} x {height}, on {}", summary.version, summary.renderer);
    let reference = &summary.reference;
    let text = format!(
        "<p>The illumination cut is the budget of a picture: it starts with the clusters whose radiance varies too much, and \
         spends what is left on the brightest. The reference is {}. It took {}. Environment: “{}”.</p>",
        escaped(&reference.what),
        seconds(reference.seconds),
        escaped(&summary.environment),
    );
    let files = "<p>All figures are in <a href=\"ladder.json\">ladder.json</a>, all pictures on one \
                 <a href=\"sheet.png\">sheet</a>; each lies beside this page as PNG and as scene-linear EXR.</p>";
    let sections = [
        section("Which cut is enough", &format!("{text}{}", pictures(summary))),
        section("Error against size and time", &charts(summary)),
        section("Files", files),
    ];
    report::page("ladder of cut sizes", &head, &sections)
}

/// All pictures with error and time, the reference last.
pub fn pictures(summary: &Summary) -> String {
    let picture = |step: &StepFigures| {
        let caption = format!(
            "<b>{} node{}</b>relative RMSE {}<br>FLIP {}<br>{}, {:.0} merged nodes",
            grouped(step.illum_cut.into()),
            if step.illum_cut == 1 { "" } else { "s" },
            short(step.rel_rmse),
            short(step.flip),
            seconds(step.seconds),
            step.mean_merged_nodes,
        );
        figure("", &step.png, summary.size, &format!("illumination cut {}", step.illum_cut), &caption)
    };
    let caption = format!("<b>Reference</b>every light sample<br>{}", seconds(summary.reference.seconds));
    let truth = figure("truth", &summary.reference.png, summary.size, "reference", &caption);
    format!("<div class=\"grid six\">{}{truth}</div>", summary.steps.iter().map(picture).collect::<String>())
}

/// Error against cut size, and against time.
pub fn charts(summary: &Summary) -> String {
    let lines = |x: fn(&StepFigures) -> f64| {
        let line = |name: &str, y: fn(&StepFigures) -> f64| Line {
            name: name.into(),
            points: summary.steps.iter().map(|step| (x(step), y(step))).collect(),
        };
        [line("rel. RMSE", |s| s.rel_rmse), line("FLIP", |s| s.flip)]
    };
    let chart = |title, x_label, lines: &[Line]| Chart { title, x_label, x: Scale::Log, y: Scale::Log, lines }.svg();
    let by_size = chart("Error by size", "nodes of the illumination cut", &lines(|s| s.illum_cut.into()));
    let by_time = chart("Error by time", "seconds a picture", &lines(|s| s.seconds));
    format!("<div class=\"grid two\">{by_size}{by_time}</div>")
}
