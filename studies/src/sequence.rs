//! Image sequences: turntables, sweeps of any parameter, and animations. All frames are planned ([`plan()`]) before any is rendered
//! ([`SequenceTask::run`]), for the window and the command line alike.

mod blocked;
mod error;
mod motion;
mod names;
mod parameter;
mod plan;
mod record;
mod run;
mod sweep;
mod turn;

pub use blocked::{blocked_frames, blocked_words};
pub use motion::{Moment, Motion, Times};
pub use names::FrameNames;
pub use parameter::{Domain, Parameter, Target};
pub use plan::{SequenceFrame, SequenceSettings, plan};
pub use run::{Existing, Prepared, SequenceEnd, SequenceTask, SheetTask, sequence_files};
pub use sweep::{Sweep, Value};
pub use turn::{Spin, Turn};
