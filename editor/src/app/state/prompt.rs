//! Questions that wait for an answer.

use crate::{
    document::{autosave::Recovery, session::LoadedSession},
    jobs::opening::{Ready, Target},
};
use std::{collections::VecDeque, path::PathBuf};

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

/// Questions that wait, and what follows their answers.
#[derive(Default)]
pub struct Questions {
    /// The one that is asked comes first.
    pub waiting: VecDeque<Prompt>,
    /// The action after the session has been saved.
    pub after_save: Option<Then>,
    /// Nothing is left to ask: the window may close.
    pub may_close: bool,
}

impl Questions {
    /// With one to begin with, if there is one.
    pub fn of(first: Option<Prompt>) -> Self {
        Self { waiting: first.into_iter().collect(), ..Self::default() }
    }

    /// Asks a question, after those that wait. Of two about leaving the document the later counts.
    pub fn ask(&mut self, prompt: Prompt) {
        if let Prompt::Unsaved { .. } = prompt {
            self.waiting.retain(|waiting| !matches!(waiting, Prompt::Unsaved { .. }));
        }
        self.waiting.push_back(prompt);
    }
}
