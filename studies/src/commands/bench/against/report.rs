//! Times of both programs by row, as JSON and as a table.

use super::program::Program;
use crate::terminal::Outcome;
use serde::Serialize;
use std::{path::PathBuf, time::Duration};

/// Times of both programs, one pair per round.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Times {
    /// Milliseconds of this program.
    pub this: Vec<f64>,
    /// Milliseconds of the other one.
    pub other: Vec<f64>,
    /// Median ratio over all pairs, this program over the other.
    ratio: Option<f64>,
    /// Smallest and largest ratio, from at least two pairs.
    spread: Option<[f64; 2]>,
    /// Median milliseconds of this program.
    this_median: Option<f64>,
    /// Median milliseconds of the other one.
    other_median: Option<f64>,
}

impl Times {
    /// Computes medians and ratios.
    pub fn new(this: Vec<f64>, other: Vec<f64>) -> Self {
        let ratios: Vec<f64> = this.iter().zip(&other).map(|(this, other)| this / other).collect();
        let least_and_most = ratios.iter().fold([f64::INFINITY, 0.0], |[a, b], &r| [r.min(a), r.max(b)]);
        Self {
            ratio: median(&ratios),
            spread: (ratios.len() > 1).then_some(least_and_most),
            this_median: median(&this),
            other_median: median(&other),
            this,
            other,
        }
    }
}

/// Median; of an even number the mean of the middle two.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

/// One row of the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Scene and measured quantity.
    pub name: String,
    /// Each program on its own dataset.
    pub own: Times,
    /// Both on this program's dataset, if both ran on it.
    pub on_this: Times,
    /// Both on the other program's dataset.
    pub on_other: Times,
    /// Reason for missing figures.
    pub remark: Option<String>,
    /// Whether this fails the comparison; a missing device or display does not.
    pub failed: bool,
}

impl Row {
    /// Creates a row from times on the programs' own datasets.
    pub fn new(name: String, own: Times) -> Self {
        Self { name, own, on_this: Times::default(), on_other: Times::default(), remark: None, failed: false }
    }

    /// Adds a failure, if any.
    #[must_use]
    pub fn failing(self, trouble: Option<String>) -> Self {
        Self { failed: trouble.is_some(), remark: trouble, ..self }
    }

    /// A row that this machine cannot measure.
    pub fn left_out(name: String, reason: &str) -> Self {
        Self { remark: Some(format!("left out: {reason}")), ..Self::new(name, Times::default()) }
    }

    fn is_above(&self, bound: f32) -> bool {
        self.own.ratio.is_some_and(|ratio| ratio > f64::from(bound))
    }
}

/// Path and version of a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Named {
    path: PathBuf,
    version: String,
}

impl From<&Program> for Named {
    fn from(program: &Program) -> Self {
        Self { path: program.path.clone(), version: program.version.clone() }
    }
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    this: Named,
    other: Named,
    /// Threads of this machine.
    threads: usize,
    /// Duration of the comparison.
    seconds: f64,
    /// Ratio above which rows are listed.
    fail_above: Option<f32>,
    /// Rows with a larger ratio.
    above: Vec<String>,
    rows: Vec<Row>,
}

impl Report {
    /// Creates the report from all rows of `this` and `other`.
    pub fn new([this, other]: [&Program; 2], rows: Vec<Row>, time: Duration, fail_above: Option<f32>) -> Self {
        Self::of_rows([this.into(), other.into()], rows, time, fail_above)
    }

    fn of_rows([this, other]: [Named; 2], rows: Vec<Row>, time: Duration, fail_above: Option<f32>) -> Self {
        let is_above = |row: &&Row| fail_above.is_some_and(|bound| row.is_above(bound));
        Self {
            above: rows.iter().filter(is_above).map(|row| row.name.clone()).collect(),
            this,
            other,
            threads: rayon::current_num_threads(),
            seconds: time.as_secs_f64(),
            fail_above,
            rows,
        }
    }

    /// Failed rows take precedence over slow ones.
    pub fn outcome(&self) -> Outcome {
        match () {
            () if self.rows.iter().any(|row| row.failed) => Outcome::Failed,
            () if !self.above.is_empty() => Outcome::OutOfBounds,
            () => Outcome::Done,
        }
    }

    /// The report as text.
    pub fn table(&self) -> String {
        let named = |Named { path, version }: &Named| format!("{} ({version})", path.display());
        let mut text = format!(
            "this:  {}\nother: {}\n{} threads, {:.0} s in all; ratios are this over other, medians of pairs\n\n",
            named(&self.this),
            named(&self.other),
            self.threads,
            self.seconds
        );
        text += &line("", ["other ms", "this ms", "ratio", "least..most", "on this's", "on other's"], "");
        for row in &self.rows {
            let Row { own, on_this, on_other, .. } = row;
            let spread = own.spread.map(|[least, most]| format!("{least:.2}..{most:.2}"));
            let cells = [milliseconds(own.other_median), milliseconds(own.this_median), ratio(own.ratio)];
            let [other, this, own] = cells.each_ref().map(String::as_str);
            let (on_this, on_other) = (ratio(on_this.ratio), ratio(on_other.ratio));
            let cells = [other, this, own, spread.as_deref().unwrap_or("-"), &on_this, &on_other];
            text += &line(&row.name, cells, row.remark.as_deref().unwrap_or(""));
        }
        text + &self.summary()
    }

    fn summary(&self) -> String {
        let Some(bound) = self.fail_above else { return String::new() };
        match self.above.len() {
            0 => format!("\nNo ratio is above {bound}.\n"),
            n => format!("\nAbove {bound} ({n} of {} rows): {}\n", self.rows.len(), self.above.join("; ")),
        }
    }
}

fn milliseconds(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.1}"))
}

fn ratio(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.2}"))
}

fn line(name: &str, [other, this, own, spread, on_this, on_other]: [&str; 6], remark: &str) -> String {
    let line = format!("{name:<40} {other:>9} {this:>9} {own:>6} {spread:>12} {on_this:>9} {on_other:>10}  {remark}");
    line.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(rows: Vec<Row>, fail_above: Option<f32>) -> Report {
        let named = |name: &str| Named { path: name.into(), version: "lapidary 1".into() };
        Report::of_rows([named("new"), named("old")], rows, Duration::from_secs(7), fail_above)
    }

    fn row(name: &str, this: &[f64], other: &[f64]) -> Row {
        Row::new(name.into(), Times::new(this.into(), other.into()))
    }

    #[test]
    fn ratios_are_of_pairs() {
        let times = Times::new(vec![10.0, 40.0, 30.0], vec![10.0, 20.0, 10.0]);
        assert_eq!((times.ratio, times.spread), (Some(2.0), Some([1.0, 3.0])));
        assert_eq!((times.this_median, times.other_median), (Some(30.0), Some(10.0)));
        assert_ne!(times.ratio, Some(3.0), "negative control: not the ratio of the medians");
        let even = Times::new(vec![10.0, 40.0], vec![10.0, 20.0]);
        assert_eq!((even.ratio, even.this_median), (Some(1.5), Some(25.0)));
        let one = Times::new(vec![10.0], vec![20.0]);
        assert_eq!((one.ratio, one.spread), (Some(0.5), None));
        let none = Times::new(vec![10.0], vec![]);
        assert_eq!((none.ratio, none.this_median, none.other_median), (None, Some(10.0), None));
    }

    #[test]
    fn the_table_has_all_rows_and_names_those_above_the_bound() {
        let crossed =
            Row { on_this: Times::new(vec![30.0], vec![20.0]), ..row("room: frame", &[20.0, 25.0], &[10.0, 10.0]) };
        let failed = row("room: drag", &[5.0], &[]).failing(Some("the other program has no --drag".into()));
        let left_out = Row::left_out("room: window".into(), "there is none");
        let table = report(vec![crossed, failed, left_out], Some(2.0)).table();
        let lines: Vec<String> =
            table.lines().skip(5).map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        assert_eq!(
            lines,
            [
                "room: frame 10.0 22.5 2.25 2.00..2.50 1.50 -",
                "room: drag - 5.0 - - - - the other program has no --drag",
                "room: window - - - - - - left out: there is none",
                "",
                "Above 2 (1 of 3 rows): room: frame",
            ],
            "{table}"
        );
    }

    #[test]
    fn a_row_that_failed_counts_before_one_that_is_slow() {
        let slow = || row("a", &[20.0], &[10.0]);
        let failed = || row("b", &[], &[]).failing(Some("the other program failed".into()));
        let left_out = || Row::left_out("c".into(), "there is none");
        assert_eq!(report(vec![slow(), left_out()], None).outcome(), Outcome::Done);
        assert_eq!(report(vec![slow(), left_out()], Some(2.0)).outcome(), Outcome::Done);
        assert_eq!(report(vec![slow(), left_out()], Some(1.9)).outcome(), Outcome::OutOfBounds);
        assert_eq!(report(vec![slow(), failed()], Some(1.9)).outcome(), Outcome::Failed);
    }
}
