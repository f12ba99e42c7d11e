//! Charts as inline SVG.

use super::text::{grouped, short};
use maud::{Markup, html};

/// A named line.
#[derive(Clone, Debug)]
pub struct Line {
    /// Label at its end.
    pub name: String,
    /// (x, y) by increasing x.
    pub points: Vec<(f64, f64)>,
}

/// Spacing of numbers on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// Linear from zero.
    Linear,
    /// By ratio; values of zero and below are at the low end.
    Log,
}

/// Lines over one pair of axes.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// Title of the chart.
    pub title: &'a str,
    /// Label of the horizontal axis.
    pub x_label: &'a str,
    /// Scale of the horizontal axis. Its ticks are the points of the first line if they are few and round.
    pub x: AxisScale,
    /// Scale of the vertical axis.
    pub y: AxisScale,
    /// The lines in color order.
    pub lines: &'a [Line],
}

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 280.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 92.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 46.0;
/// Most points that become ticks themselves.
const MOST_POINT_TICKS: usize = 9;
/// Least spacing of numbers on the horizontal axis.
const TICK_ROOM: f64 = 40.0;

impl Chart<'_> {
    /// The chart as an `svg` element.
    pub fn svg(&self) -> Markup {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = Axis::new(self.x, points().map(|p| p.0), [LEFT, WIDTH - RIGHT]);
        let y = Axis::new(self.y, points().map(|p| p.1), [HEIGHT - BOTTOM, TOP]);
        let axes_and_lines = html! {
            (rules(&y))
            (self.x_ticks(&x))
            text x=(0.5 * (LEFT + WIDTH - RIGHT)) y=(HEIGHT) text-anchor="middle" dy="-4" { (self.x_label) }
            @for (i, line) in self.lines.iter().enumerate() { (line.draw(i, &x, &y)) }
            (labels(self.lines, &y))
        };
        svg(self.title, self.title, axes_and_lines)
    }

    fn x_ticks(&self, x: &Axis) -> Markup {
        let own: Vec<f64> = self.lines.first().map(|l| l.points.iter().map(|p| p.0).collect()).unwrap_or_default();
        // Measured times and errors are not round enough for ticks.
        let round = |v: &f64| short(*v).parse() == Ok(*v);
        let at = if own.len() <= MOST_POINT_TICKS && own.iter().all(round) { own } else { x.ticks() };
        let mut right = f64::NEG_INFINITY;
        let far_enough = |&(_, place): &(f64, f64)| {
            let fits = place - right >= TICK_ROOM;
            if fits {
                right = place;
            }
            fits
        };
        let ticks: Vec<(f64, f64)> = at.into_iter().map(|v| (v, x.place(v))).filter(far_enough).collect();
        html! { @for (value, place) in ticks { (centered(place, HEIGHT - BOTTOM + 20.0, &short(value))) } }
    }
}

/// An `svg` element of chart size with a title; screen readers read `label`.
fn svg(label: &str, title: &str, body: Markup) -> Markup {
    html! {
        svg viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(label) {
            text.title x="0" y="14" { (title) }
            (body)
        }
    }
}

/// Text centered at a position.
fn centered(x: f64, y: f64, text: &str) -> Markup {
    html! { text x=(tenths(x)) y=(tenths(y)) text-anchor="middle" { (text) } }
}

/// A coordinate rounded to a tenth of a unit.
fn tenths(coordinate: f64) -> String {
    format!("{coordinate:.1}")
}

/// Maps numbers to positions.
struct Axis {
    scale: AxisScale,
    /// Smallest and largest number.
    range: [f64; 2],
    /// Their positions.
    place: [f64; 2],
}

impl Axis {
    fn new(scale: AxisScale, values: impl Iterator<Item = f64>, place: [f64; 2]) -> Self {
        let finite: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let top = finite.iter().copied().fold(0.0, f64::max);
        let range = match scale {
            AxisScale::Linear => [0.0, (top * 1.08).max(1e-6)],
            AxisScale::Log => {
                let low = finite.iter().copied().filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
                let low = if low.is_finite() { low } else { 0.1 };
                [low / 1.08, (top * 1.08).max(low * 1.2)]
            }
        };
        Self { scale, range, place }
    }

    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let part = match self.scale {
            AxisScale::Linear => (value - low) / (high - low),
            AxisScale::Log => (value.max(low) / low).ln() / (high / low).ln(),
        };
        self.place[0] + (self.place[1] - self.place[0]) * part.clamp(0.0, 1.0)
    }

    /// Round numbers: three to six of them, or the 1, 2 and 5 of each decade, or decades if there are many.
    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.range;
        if self.scale == AxisScale::Linear {
            let step = tick_step(high / 1.08);
            return (0..).map(|i| f64::from(i) * step).take_while(|v| *v <= high).collect();
        }
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let steps: &[f64] = if (high / low).log10() > 3.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)));
        let inside: Vec<f64> = all.filter(|v| (low..=high).contains(v)).collect();
        if inside.len() < 2 { vec![low * 1.08, high / 1.08] } else { inside }
    }
}

fn rules(y: &Axis) -> Markup {
    html! {
        @for value in y.ticks() {
            @let place = y.place(value);
            line.rule x1=(LEFT) x2=(WIDTH - RIGHT) y1=(tenths(place)) y2=(tenths(place)) {}
            text x=(LEFT - 8.0) y=(tenths(place + 4.0)) text-anchor="end" { (short(value)) }
        }
    }
}

impl Line {
    fn draw(&self, index: usize, x: &Axis, y: &Axis) -> Markup {
        let places: Vec<(f64, f64)> = self.points.iter().map(|p| (x.place(p.0), y.place(p.1))).collect();
        let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        html! {
            polyline class={ "s" (index) } points=(path.join(" ")) {}
            @for ((x, y), point) in places.iter().zip(&self.points) {
                circle class={ "s" (index) } cx=(tenths(*x)) cy=(tenths(*y)) r="3.5" {
                    title { (self.name) ": " (short(point.1)) " at " (short(point.0)) }
                }
            }
        }
    }
}

/// Line names at their ends, moved apart to avoid overlaps.
fn labels(lines: &[Line], y: &Axis) -> Markup {
    const LINE: f64 = 15.0;
    let end = |(i, line): (usize, &Line)| line.points.last().map(|p| (y.place(p.1), i));
    let mut ends: Vec<(f64, usize)> = lines.iter().enumerate().filter_map(end).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    for i in 1..ends.len() {
        ends[i].0 = ends[i].0.max(ends[i - 1].0 + LINE);
    }
    let overflow = ends.last().map_or(0.0, |e| (e.0 - (HEIGHT - BOTTOM)).max(0.0));
    html! {
        @for &(place, i) in &ends {
            text class={ "l" (i) } x=(WIDTH - RIGHT + 10.0) y=(tenths(place - overflow + 4.0)) { (lines[i].name) }
        }
    }
}

/// A round tick spacing that gives three to six ticks.
pub fn tick_step(largest: f64) -> f64 {
    let decade = 10_f64.powf(largest.max(1e-9).log10().floor());
    [0.2, 0.5, 1.0, 2.0].into_iter().map(|s| s * decade).find(|s| largest / s <= 6.0).unwrap_or(2.0 * decade)
}

/// Counts of cuts with `2^i` to `2^(i+1) - 1` nodes.
pub fn histogram(counts: &[u64]) -> Markup {
    let used = counts.iter().rposition(|&c| c > 0).map_or(0, |last| last + 1);
    let largest = counts.iter().max().copied().unwrap_or(0).max(1) as f64;
    let (base, room) = (HEIGHT - BOTTOM, HEIGHT - TOP - BOTTOM - 10.0);
    let width = (WIDTH - 10.0) / used.max(1) as f64;
    let bars = html! {
        @for (i, &count) in counts[..used].iter().enumerate() {
            @let (x, height) = (i as f64 * width, room * count as f64 / largest);
            @let middle = x + 0.5 * width - 3.0;
            rect.bar x=(tenths(x)) y=(tenths(base - height)) width=(tenths(width - 6.0)) height=(tenths(height)) {}
            (centered(middle, base - height - 6.0, &grouped(count)))
            (centered(middle, base + 18.0, &size_range(i)))
        }
        line.rule x1="0" x2=(WIDTH) y1=(base) y2=(base) {}
    };
    svg("Histogram of cut sizes", "Cuts by their number of nodes", bars)
}

fn size_range(exponent: usize) -> String {
    match exponent {
        0 => "1".into(),
        _ => format!("{}–{}", 1_u64 << exponent, (2_u64 << exponent) - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: &[(f64, f64)], scale: AxisScale) -> String {
        let lines = [Line { name: "a & b".into(), points: points.to_vec() }];
        Chart { title: "t", x_label: "nodes", x: AxisScale::Log, y: scale, lines: &lines }.svg().into_string()
    }

    #[test]
    fn ticks_are_round_and_few() {
        for largest in [0.07, 0.142, 0.5, 1.0, 3.3] {
            let count = largest / tick_step(largest);
            assert!((2.0..=6.0).contains(&count), "{largest}: {count}");
        }
        let log = Axis::new(AxisScale::Log, [0.03, 0.4].into_iter(), [0.0, 100.0]);
        assert_eq!(log.ticks().iter().map(|&v| short(v)).collect::<Vec<_>>(), ["0.05", "0.1", "0.2"]);
    }

    #[test]
    fn better_points_are_drawn_lower_and_equal_ratios_are_equally_long() {
        for scale in [AxisScale::Linear, AxisScale::Log] {
            let axis = Axis::new(scale, [0.1, 1.0].into_iter(), [200.0, 0.0]);
            assert!(axis.place(0.1) > axis.place(0.9));
        }
        let log = Axis::new(AxisScale::Log, [1.0, 64.0].into_iter(), [0.0, 100.0]);
        assert!((log.place(8.0) - log.place(2.0) - (log.place(32.0) - log.place(8.0))).abs() < 1e-9);
        assert_eq!([0, 1, 5].map(size_range), ["1", "2–3", "32–63"]);
    }

    #[test]
    fn charts_survive_nothing_to_show() {
        assert!(histogram(&[0, 0]).into_string().ends_with("</svg>"));
        for scale in [AxisScale::Linear, AxisScale::Log] {
            for points in [&[][..], &[(32.0, 0.0), (64.0, 0.0)], &[(1.0, f64::INFINITY)], &[(1.0, 0.5)]] {
                let svg = chart(points, scale);
                assert!(svg.ends_with("</svg>") && !svg.contains("NaN"), "{points:?}: {svg}");
            }
        }
        assert!(chart(&[(1.0, 1.0)], AxisScale::Log).contains("a &amp; b"));
    }

    #[test]
    fn ticks_are_at_points_if_those_are_round() {
        let sizes = chart(&[(1.0, 0.5), (32.0, 0.4), (512.0, 0.3)], AxisScale::Linear);
        assert!(sizes.contains(">32</text>") && sizes.contains(">512</text>"), "{sizes}");
        let times = chart(&[(0.1234567, 0.5), (1.2345678, 0.4)], AxisScale::Linear);
        assert!(times.contains(">0.2</text>") && !times.contains(">0.123</text>"), "{times}");
    }
}
