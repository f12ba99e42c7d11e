//! Progress: a bar with rate and time left or JSON lines on standard error, lines for a farm on standard output, or none.

use super::{Console, option_name};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle as BarStyle};
use lapidary_precompute::{Event, Observer, Phase, Warning};
use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressStyle {
    /// A bar with rate and time left
    #[default]
    Bar,
    /// One JSON object per line
    Json,
    /// Lines on standard output that report percentage, phase and warnings to an Open Job Description worker
    Openjd,
    /// No progress; warnings are printed unless --quiet is given
    None,
}

/// Shows a job's messages and cancels it on Ctrl-C.
pub struct ProgressReporter {
    style: ProgressStyle,
    /// Prints the warnings where no progress is shown.
    console: Console,
    bar: Mutex<ProgressBar>,
    percentage: Mutex<Percentage>,
    cancelled: Arc<AtomicBool>,
}

impl ProgressReporter {
    /// Shows nothing until the first message, and nothing at all on a quiet console.
    pub fn new(style: ProgressStyle, console: Console) -> Self {
        let style = if console.quiet { ProgressStyle::None } else { style };
        let (bar, percentage) = (Mutex::new(ProgressBar::hidden()), Mutex::default());
        Self { style, console, bar, percentage, cancelled: Arc::default() }
    }

    /// A bar unless the console is quiet; cancels as [`Self::cancel_on_interrupt`].
    pub fn interruptible(console: Console) -> Self {
        let reporter = Self::new(ProgressStyle::Bar, console);
        reporter.cancel_on_interrupt();
        reporter
    }

    /// Cancels on Ctrl-C; a second one ends the process at once.
    pub fn cancel_on_interrupt(&self) {
        let flag = Arc::clone(&self.cancelled);
        let handler = move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
            eprintln!("\nstopping after the current step; press Ctrl-C again to stop at once");
        };
        // Fails only if a handler exists, which then serves as well.
        let _ = ctrlc::set_handler(handler);
    }

    /// Shows a warning, above the bar if there is one. Only a quiet console hides it.
    pub fn warn(&self, message: &str) {
        match self.style {
            ProgressStyle::Json => self.print_json(&Event::Warning { message: Warning::Text(message.to_owned()) }),
            ProgressStyle::Bar => self.bar().suspend(|| eprintln!("warning: {message}")),
            ProgressStyle::Openjd => println!("openjd_status: warning: {message}"),
            ProgressStyle::None => self.console.warning(message),
        }
    }

    /// Ends the display.
    pub fn finish(&self) {
        self.bar().finish_and_clear();
    }

    fn bar(&self) -> std::sync::MutexGuard<'_, ProgressBar> {
        self.bar.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn print_json(&self, event: &Event) {
        if let Ok(line) = serde_json::to_string(event) {
            eprintln!("{line}");
        }
    }

    fn print_openjd(&self, event: &Event) {
        let mut percentage = self.percentage.lock().unwrap_or_else(PoisonError::into_inner);
        if let Event::Started { phase, .. } = event {
            println!("openjd_status: {}", phase.name());
        }
        if let Some(percent) = percentage.after(event) {
            println!("openjd_progress: {percent}");
        }
    }

    fn start_bar(&self, phase: Phase, total: u64, unit: &str) {
        let mut bar = self.bar();
        bar.finish_and_clear();
        *bar = phase_bar(phase.name(), total, unit);
    }
}

/// Percentage of a bake: all phases count equally, and it never decreases.
#[derive(Default)]
struct Percentage {
    phase: usize,
    total: u64,
    told: Option<u64>,
}

impl Percentage {
    /// The percentage after a message, if it has increased.
    fn after(&mut self, event: &Event) -> Option<u64> {
        let done = match *event {
            Event::Started { phase, total, .. } => {
                (self.phase, self.total) = (Phase::ALL.iter().position(|p| *p == phase).unwrap_or(0), total);
                0
            }
            Event::Advanced { done } => done,
            Event::Warning { .. } => return None,
        };
        let part = done.min(self.total) as f64 / self.total.max(1) as f64;
        let percent = (100.0 * (self.phase as f64 + part) / Phase::ALL.len() as f64) as u64;
        if self.told.is_some_and(|told| told >= percent) {
            return None;
        }
        self.told = Some(percent);
        self.told
    }
}

/// A bar for a named step of `total` units on standard error.
pub fn phase_bar(name: &str, total: u64, unit: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(8));
    let template = if total > 0 {
        format!("{name:>10} [{{bar:32}}] {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left")
    } else {
        format!("{name:>10} {{elapsed}}")
    };
    if let Ok(style) = BarStyle::with_template(&template) {
        bar.set_style(style.progress_chars("=> "));
    }
    if total == 0 {
        // No unit advances it, but its seconds should tick.
        bar.enable_steady_tick(Duration::from_millis(250));
    }
    bar
}

impl Observer for ProgressReporter {
    fn event(&self, event: Event) {
        match (self.style, event) {
            (_, Event::Warning { message }) => self.warn(&message.text(option_name)),
            (ProgressStyle::None, _) => {}
            (ProgressStyle::Json, event) => self.print_json(&event),
            (ProgressStyle::Openjd, event) => self.print_openjd(&event),
            (ProgressStyle::Bar, Event::Started { phase, total, unit }) => self.start_bar(phase, total, unit),
            (ProgressStyle::Bar, Event::Advanced { done }) => self.bar().set_position(done),
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentage_rises_through_all_phases_and_is_told_once() {
        let mut percentage = Percentage::default();
        let mut told = Vec::new();
        for phase in Phase::ALL {
            told.extend(percentage.after(&Event::Started { phase, total: 4, unit: "points" }));
            // Threads may report out of order.
            for done in [1, 3, 2, 4, 4, 9] {
                told.extend(percentage.after(&Event::Advanced { done }));
            }
        }
        assert!(told.is_sorted_by(|a, b| a < b), "{told:?}");
        assert_eq!((told.first(), told.last()), (Some(&0), Some(&100)));
        assert!(told.len() > 2 * Phase::ALL.len());
    }
}
