//! Runs of both programs and the rows built from them.

use super::{
    jobs::{Figure, Job},
    report::{Row, Times},
};

/// One of the two programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The running program.
    This,
    /// The program it is compared with.
    Other,
}

impl Side {
    /// Name in remarks.
    pub fn name(self) -> &'static str {
        match self {
            Self::This => "this program",
            Self::Other => "the other program",
        }
    }

    /// Both sides; each is first in every second round, so drift of the machine favors neither.
    pub fn in_turn(round: usize) -> [Self; 2] {
        match round % 2 {
            0 => [Self::Other, Self::This],
            _ => [Self::This, Self::Other],
        }
    }
}

/// Figures of a run in milliseconds, in the job's order. Some programs do not report all of them.
pub type Figures = Vec<Option<f64>>;

/// Runs of a program on a dataset.
pub struct Runs {
    /// The program.
    pub program: Side,
    /// The program that baked the dataset.
    pub dataset: Side,
    /// Figures of each round.
    pub figures: Vec<Figures>,
    /// Reason for missing runs.
    pub trouble: Option<String>,
}

impl Runs {
    /// Starts without runs.
    pub fn new(program: Side, dataset: Side) -> Self {
        Self { program, dataset, figures: Vec::new(), trouble: None }
    }

    /// Adds a run, or the reason why it failed.
    pub fn add(&mut self, run: Result<Figures, String>) {
        match run {
            Ok(figures) => self.figures.push(figures),
            Err(trouble) if self.program == self.dataset => {
                self.trouble = Some(format!("{} {trouble}", self.program.name()));
            }
            Err(trouble) => {
                self.trouble =
                    Some(format!("on the dataset of {}, {} {trouble}", self.dataset.name(), self.program.name()));
            }
        }
    }

    /// Times of a figure.
    fn times(&self, figure: usize) -> Vec<f64> {
        self.figures.iter().filter_map(|figures| figures[figure]).collect()
    }

    /// Reason why a figure is incomplete.
    fn trouble_of(&self, figure: usize) -> Option<String> {
        let is_untold = self.times(figure).len() < self.figures.len();
        self.trouble.clone().or(is_untold.then(|| format!("{} does not report it", self.program.name())))
    }
}

/// Rows of a job from all its runs.
pub fn rows(job: &Job, all: &[Runs]) -> Vec<Row> {
    let row = |(number, figure): (usize, &Figure)| {
        let times = |program: Side, dataset: Side| {
            let found = all.iter().find(|runs| (runs.program, runs.dataset) == (program, dataset));
            found.map_or(Vec::new(), |runs| runs.times(number))
        };
        let pairs =
            |this_on: Side, other_on: Side| Times::new(times(Side::This, this_on), times(Side::Other, other_on));
        let trouble = all.iter().find_map(|runs| runs.trouble_of(number));
        Row {
            on_this: pairs(Side::This, Side::This),
            on_other: pairs(Side::Other, Side::Other),
            ..Row::new(job.name_of(figure), pairs(Side::This, Side::Other))
        }
        .failing(trouble)
    };
    job.figures.iter().enumerate().map(row).collect()
}
