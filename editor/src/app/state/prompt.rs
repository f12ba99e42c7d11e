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
        /// The action that waits.
        then: Then,
    },
    /// Work of crashed processes was found.
    Recover(Vec<Recovery>),
    /// Files of a session are missing.
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
        /// The step after the answer.
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
    /// Name and version of the program.
    About,
}

/// The step that waits for permission to read files outside a folder.
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

/// Waiting questions, and the steps after their answers.
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
    /// With a first question, if there is one.
    pub fn of(first: Option<Prompt>) -> Self {
        Self { waiting: first.into_iter().collect(), ..Self::default() }
    }

    /// Queues a question. Of two about leaving the document, the later counts.
    pub fn ask(&mut self, prompt: Prompt) {
        if let Prompt::Unsaved { .. } = prompt {
            self.waiting.retain(|waiting| !matches!(waiting, Prompt::Unsaved { .. }));
        }
        self.waiting.push_back(prompt);
    }
}
