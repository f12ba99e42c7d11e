//! Questions that wait for an answer.

use crate::{
    app::opening::{Ready, Target},
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
    /// A scene or a material names files outside its folder.
    Outside {
        /// The scene or the material.
        file: PathBuf,
        /// The files, as it names them.
        names: Vec<String>,
        /// What is done once there is an answer.
        then: Again,
    },
    /// A file has several materials.
    Several {
        /// The file.
        file: PathBuf,
        /// Their names.
        names: Vec<String>,
        /// The material that one of them replaces.
        material: usize,
    },
    /// The identity of this program.
    About,
}

/// What waits for the answer whether files outside a folder are read.
pub enum Again {
    /// A document is opened.
    Open(Target),
    /// This material is loaded.
    Load(usize),
}

/// The action after the document may be left.
pub enum Then {
    /// The window closes.
    Quit,
    /// A document that was opened takes its place.
    Show(Box<Ready>),
}
