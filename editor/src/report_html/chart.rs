//! Charts as inline SVG.

use super::text::grouped;

/// A named line of (cut size, error).
pub struct Series<'a> {
    /// Style class and label: `refined` or `once`.
    pub class: &'a str,
    /// Points by growing cut size.
    pub points: Vec<(u32, f64)>,
}

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 280.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 70.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 46.0;

/// Error against cut size, which is on a logarithmic axis.
pub fn error_chart(title: &str, series: &[Series]) -> String {
    let sizes: Vec<u32> = series[0].points.iter().map(|p| p.0).collect();
    let largest = series.iter().flat_map(|s| &s.points).map(|p| p.1).fold(0.0, f64::max);
    let axis = Axis { step: tick_step(largest), top: (largest * 1.08).max(1e-6) };
    let x = |size: u32| {
        let span = f64::from(sizes[sizes.len() - 1]).log2() - f64::from(sizes[0]).log2();
        LEFT + (WIDTH - LEFT - RIGHT) * (f64::from(size).log2() - f64::from(sizes[0]).log2()) / span
    };
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{title} against cut size">"#);
    svg += &format!(r#"<text class="title" x="0" y="14">{title}</text>"#);
    svg += &axis.rules();
    for &size in &sizes {
        let (x, y) = (x(size), HEIGHT - BOTTOM + 20.0);
        svg += &format!(r#"<text x="{x:.1}" y="{y}" text-anchor="middle">{size}</text>"#);
    }
    let middle = 0.5 * (LEFT + WIDTH - RIGHT);
    svg += &format!(
        r#"<text x="{middle}" y="{HEIGHT}" text-anchor="middle" dy="-4">nodes of the illumination cut</text>"#
    );
    for line in series {
        svg += &line.draw(&x, &axis);
    }
    svg + &labels(series, &axis) + "</svg>"
}

struct Axis {
    step: f64,
    top: f64,
}

impl Axis {
    fn y(&self, value: f64) -> f64 {
        HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / self.top
    }

    fn rules(&self) -> String {
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        let ticks = (0..).map(|i| f64::from(i) * self.step).take_while(|&v| v <= self.top);
        let rule = |value: f64| {
            let (y, right) = (self.y(value), WIDTH - RIGHT);
            format!(
                r#"<line class="rule" x1="{LEFT}" x2="{right}" y1="{y:.1}" y2="{y:.1}"/><text x="{}" y="{:.1}" text-anchor="end">{value:.decimals$}</text>"#,
                LEFT - 8.0,
                y + 4.0
            )
        };
        ticks.map(rule).collect()
    }
}

impl Series<'_> {
    fn draw(&self, x: &impl Fn(u32) -> f64, axis: &Axis) -> String {
        let class = self.class;
        let points: Vec<String> = self.points.iter().map(|&(s, e)| format!("{:.1},{:.1}", x(s), axis.y(e))).collect();
        let mut svg = format!(r#"<polyline class="{class}" points="{}"/>"#, points.join(" "));
        for &(size, error) in &self.points {
            let (x, y) = (x(size), axis.y(error));
            svg += &format!(
                r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="3.5"><title>{size} nodes: {error:.4}</title></circle>"#
            );
        }
        svg
    }
}

/// The lines' names at their ends, moved apart where they would overlap.
fn labels(series: &[Series], axis: &Axis) -> String {
    const LINE: f64 = 15.0;
    let mut ends: Vec<(f64, &str)> =
        series.iter().filter_map(|s| s.points.last().map(|p| (axis.y(p.1), s.class))).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    for i in 1..ends.len() {
        let gap = ends[i].0 - ends[i - 1].0;
        if gap < LINE {
            ends[i - 1].0 -= 0.5 * (LINE - gap);
            ends[i].0 += 0.5 * (LINE - gap);
        }
    }
    let x = WIDTH - RIGHT + 12.0;
    ends.iter()
        .map(|(y, class)| format!(r#"<text class="label-{class}" x="{x}" y="{:.1}">{class}</text>"#, y + 4.0))
        .collect()
}

/// A round distance of ticks that gives three to six of them.
fn tick_step(largest: f64) -> f64 {
    let decade = 10_f64.powf(largest.max(1e-9).log10().floor());
    [0.2, 0.5, 1.0, 2.0].into_iter().map(|s| s * decade).find(|s| largest / s <= 6.0).unwrap_or(2.0 * decade)
}

/// Counts of cuts with `2^i` to `2^(i+1) - 1` nodes.
pub fn histogram(counts: &[u64]) -> String {
    let used = counts.iter().rposition(|&c| c > 0).map_or(0, |last| last + 1);
    let largest = counts.iter().max().copied().unwrap_or(0).max(1) as f64;
    let (base, room) = (HEIGHT - BOTTOM, HEIGHT - TOP - BOTTOM - 10.0);
    let width = (WIDTH - 10.0) / used.max(1) as f64;
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Histogram of cut sizes">"#);
    svg += r#"<text class="title" x="0" y="14">Cuts by their number of nodes</text>"#;
    for (i, &count) in counts[..used].iter().enumerate() {
        let (x, height) = (i as f64 * width, room * count as f64 / largest);
        let middle = x + 0.5 * width - 3.0;
        svg += &format!(
            r#"<rect class="bar" x="{x:.1}" y="{:.1}" width="{:.1}" height="{height:.1}"/>"#,
            base - height,
            width - 6.0
        );
        let label =
            |y: f64, text: &str| format!(r#"<text x="{middle:.1}" y="{y:.1}" text-anchor="middle">{text}</text>"#);
        svg += &label(base - height - 6.0, &grouped(count));
        svg += &label(base + 18.0, &size_range(i));
    }
    svg + &format!(r#"<line class="rule" x1="0" x2="{WIDTH}" y1="{base}" y2="{base}"/></svg>"#)
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

    #[test]
    fn ticks_are_round_and_few() {
        for largest in [0.07, 0.142, 0.5, 1.0, 3.3] {
            let count = largest / tick_step(largest);
            assert!((2.0..=6.0).contains(&count), "{largest}: {count}");
        }
    }

    #[test]
    fn better_points_are_drawn_lower() {
        let axis = Axis { step: 0.1, top: 1.0 };
        assert!(axis.y(0.1) > axis.y(0.9));
        assert_eq!([0, 1, 5].map(size_range), ["1", "2–3", "32–63"]);
    }

    #[test]
    fn charts_survive_nothing_to_show() {
        assert!(histogram(&[0, 0]).ends_with("</svg>"));
        let flat = Series { class: "once", points: vec![(32, 0.0), (64, 0.0)] };
        assert!(!error_chart("t", &[flat]).contains("NaN"));
    }
}
