//! The sizes of cuts as bars.

use crate::widgets::units::grouped;
use egui::Ui;
use egui_plot::{Bar, BarChart, Plot};

/// Height of the histogram in points.
const PLOT_HEIGHT: f32 = 110.0;

/// Bars over the powers of two; the tooltip has the range and the number of bake points.
pub fn histogram(ui: &mut Ui, counts: &[u64]) {
    let bars = counts.iter().enumerate().map(|(i, &n)| Bar::new(i as f64, n as f64).width(0.9).name(bar_text(i, n)));
    let chart = BarChart::new("Bake points", bars.collect()).element_formatter(Box::new(|bar, _| bar.name.clone()));
    let chart = chart.color(ui.visuals().selection.bg_fill);
    let plot = Plot::new("cut sizes")
        .height(PLOT_HEIGHT)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .allow_axis_zoom_drag(false)
        .show_grid([false, true])
        .show_axes([true, false])
        .x_grid_spacer(|input| {
            let (first, last) = (input.bounds.0.ceil() as i64, input.bounds.1.floor() as i64);
            let mark = |i: i64| egui_plot::GridMark { value: i as f64, step_size: 1.0 };
            (first..=last.min(first + 64)).map(mark).collect()
        })
        .x_axis_formatter(|mark, _| power_of_two(mark.value));
    plot.show(ui, |plot| plot.bar_chart(chart));
}

/// The label under a bar: its smallest cut.
fn power_of_two(exponent: f64) -> String {
    if (0.0..=20.0).contains(&exponent) { format!("{}", 1_u64 << exponent as u32) } else { String::new() }
}

fn bar_text(index: usize, points: u64) -> String {
    let low = 1_u64 << index.min(40);
    let range = if low == 1 { "1 node".into() } else { format!("{low} to {} nodes", 2 * low - 1) };
    format!("{range}: {} points", grouped(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_name_their_range() {
        assert_eq!(bar_text(0, 5), "1 node: 5 points");
        assert_eq!(bar_text(4, 12_345), "16 to 31 nodes: 12,345 points");
        assert_eq!([0.0, 7.0, -1.0].map(power_of_two), ["1", "128", ""]);
    }
}
