//! Announces the phases of a bake and records their times.

use crate::observer::{Event, Observer, Phase};
use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

pub(super) struct Clock<'a> {
    pub observer: &'a dyn Observer,
    start: Instant,
    seconds: BTreeMap<String, f64>,
}

impl<'a> Clock<'a> {
    pub fn new(observer: &'a dyn Observer, import_secs: f64) -> Self {
        let mut seconds: BTreeMap<String, f64> =
            [Phase::Tessellate, Phase::Pilot, Phase::Tree, Phase::Visibility, Phase::Pack]
                .map(|p| (p.name().to_owned(), 0.0))
                .into();
        seconds.insert(Phase::Import.name().into(), import_secs);
        Self { observer, start: Instant::now(), seconds }
    }

    pub fn time<T>(&mut self, phase: Phase, total: u64, unit: &'static str, work: impl FnOnce() -> T) -> T {
        self.observer.event(Event::Started { phase, total, unit });
        let start = Instant::now();
        let result = work();
        self.add(phase, start.elapsed());
        result
    }

    pub fn add(&mut self, phase: Phase, duration: Duration) {
        self.seconds.insert(phase.name().into(), duration.as_secs_f64());
    }

    pub fn finish(mut self) -> BTreeMap<String, f64> {
        let total = self.start.elapsed().as_secs_f64() + self.seconds["import"];
        self.seconds.insert("total".into(), total);
        self.seconds
    }
}
