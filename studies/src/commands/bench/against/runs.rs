//! Runs of both programs, and the rows that they make.

use super::{
    jobs::{Figure, Job},
    report::{Row, Times},
};

/// One of both programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// That which compares.
    This,
    /// That which is named.
    Other,
}

impl Side {
    /// Its name in remarks.
    pub fn name(self) -> &'static str {
        match self {
            Self::This => "this program",
            Self::Other => "the other program",
        }
    }

    /// Both, each first in every second round, so that a drift of the machine favors neither.
    pub fn in_turn(round: usize) -> [Self; 2] {
        match round % 2 {
            0 => [Self::Other, Self::This],
            _ => [Self::This, Self::Other],
        }
    }
}

/// Figures of a run in milliseconds, those of the job in their order. Some programs do not tell all of them.
pub type Figures = Vec<Option<f64>>;

/// Runs of a program on a dataset.
pub struct Runs {
    /// Which one.
    pub program: Side,
    /// Who baked it.
    pub dataset: Side,
    /// Of each round.
    pub figures: Vec<Figures>,
    /// Why there are no more of them.
    pub trouble: Option<String>,
}

impl Runs {
    /// None yet.
    pub fn new(program: Side, dataset: Side) -> Self {
        Self { program, dataset, figures: Vec::new(), trouble: None }
    }

    /// With another run, or with why there is none.
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

    /// What is wrong with a figure.
    fn trouble_of(&self, figure: usize) -> Option<String> {
        let is_untold = self.times(figure).len() < self.figures.len();
        self.trouble.clone().or(is_untold.then(|| format!("{} does not tell it", self.program.name())))
    }
}

/// The rows of a job, from all its runs.
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
