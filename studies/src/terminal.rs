//! The terminal: output of commands, progress, Ctrl-C, and exit codes.

mod console;
mod outcome;
mod output;
mod progress;
mod setting_names;
mod step_progress;
mod steps;

pub use console::Console;
pub use outcome::{Interrupted, Outcome};
pub use output::{error_text, json_text, print_out, write_json};
pub use progress::{ProgressReporter, ProgressStyle, phase_bar};
pub use setting_names::{option_name, remedy_option, with_options};
pub use step_progress::StepProgress;
pub use steps::Steps;
