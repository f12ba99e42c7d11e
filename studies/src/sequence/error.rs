//! Why a sweep cannot be.

use thiserror::Error;

/// What keeps a sweep from being read, or from being applied to a look.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SweepError {
    /// Not of the form that is needed.
    #[error("\"{0}\" is no sweep; write NAME=FROM..TO or NAME=log:FROM..TO, as in roughness=0.05..0.8")]
    Form(String),
    /// A parameter that does not exist.
    #[error("there is no parameter \"{name}\" to sweep; there are {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// An end that is no value.
    #[error("\"{text}\" is no value of {parameter}: {reason}")]
    Value {
        /// Which parameter.
        parameter: String,
        /// What was given.
        text: String,
        /// What is wrong.
        reason: String,
    },
    /// Logarithms of what has none.
    #[error("a logarithmic sweep goes between numbers above 0; leave log: out of {0}, or give others")]
    Logarithm(String),
    /// `@NAME` where there are no names.
    #[error("{0} belongs to the whole picture; leave out the name after @")]
    NoName(String),
    /// An illumination cut where none is merged.
    #[error("lit cuts have no illumination cut to sweep; choose --brdf refine or once (View > Cuts in the window)")]
    NoIllumCut,
    /// Lit cuts where none are merged.
    #[error("there are no lit cuts to sweep; choose --brdf lit (View > Cuts in the window)")]
    NoLitCuts,
    /// No material of that name.
    #[error("the scene has no material \"{wanted}\"; it has {names}")]
    NoMaterial {
        /// What was asked for.
        wanted: String,
        /// What there is.
        names: String,
    },
    /// No material has the map.
    #[error("no material that is swept has a {map} map; load one first")]
    NoMap {
        /// Which map.
        map: &'static str,
    },
    /// A parameter that no model of the materials has.
    #[error(
        "no material has a model with the parameter \"{parameter}\"; `lapidary models` lists the parameters of each"
    )]
    NotRead {
        /// Which.
        parameter: String,
    },
    /// No light, or none of that name.
    #[error("there is no local light \"{wanted}\" to sweep; there are {names}")]
    NoLight {
        /// What was asked for.
        wanted: String,
        /// What there is.
        names: String,
    },
    /// Several lights where one is moved.
    #[error("{parameter} moves one light; name it after @, as in {parameter}@NAME=...: there are {names}")]
    WhichLight {
        /// Which parameter.
        parameter: String,
        /// What there is.
        names: String,
    },
}
