//! Questions that wait for an answer.

use crate::{
    app::opening::Ready,
    document::{autosave::Recovery, session::LoadedSession},
};
use std::path::PathBuf;

/// A question.
pub enum Prompt {
    /// Changes would be lost.
    Unsaved {
        /// What was asked for.
        then: Then,
    },
    /// Work of processes that ended too early was found.
    Recover(Vec<Recovery>),
    /// Files of a session are not there.
    Missing {
        /// The session.
        loaded: Box<LoadedSession>,
        /// Its file.
        path: Option<PathBuf>,
        /// The autosave it was read from, which nothing else keeps.
        recovery: Option<Recovery>,
    },
    /// The identity of this program.
    About,
}

/// The action after the document may be left.
pub enum Then {
    /// The window closes.
    Quit,
    /// A document that was opened takes its place.
    Show(Box<Ready>),
}
