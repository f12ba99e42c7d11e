//! Errors of sweeps.

use thiserror::Error;

/// Why a sweep cannot be parsed or applied to a look.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SweepError {
    /// The form is wrong.
    #[error("\"{0}\" is not a sweep; write NAME=FROM..TO or NAME=log:FROM..TO, as in roughness=0.05..0.8")]
    Form(String),
    /// The parameter does not exist.
    #[error("there is no parameter \"{name}\" to sweep; there are {known}")]
    Unknown {
        /// The requested name.
        name: String,
        /// The existing names.
        known: String,
    },
    /// An end is not a valid value.
    #[error("\"{text}\" is not a value of {parameter}: {reason}")]
    Value {
        /// Name of the parameter.
        parameter: String,
        /// The given text.
        text: String,
        /// Why it is invalid.
        reason: String,
    },
    /// A logarithmic sweep of a non-positive or non-numeric value.
    #[error("a logarithmic sweep goes between numbers above 0; leave log: out of {0}, or give other values")]
    Logarithm(String),
    /// `@NAME` on a parameter of the whole picture.
    #[error("{0} belongs to the whole picture; leave out the name after @")]
    NoName(String),
    /// The look merges no illumination cut.
    #[error("lit cuts have no illumination cut to sweep; choose --brdf refine or once (View > Cuts in the window)")]
    NoIllumCut,
    /// The look merges no lit cuts.
    #[error("there are no lit cuts to sweep; choose --brdf lit (View > Cuts in the window)")]
    NoLitCuts,
    /// No material has this name.
    #[error("the scene has no material \"{wanted}\"; it has {names}")]
    NoMaterial {
        /// The requested name.
        wanted: String,
        /// The existing names.
        names: String,
    },
    /// No swept material has the map.
    #[error("no material that is swept has a {map} map; load one first")]
    NoMap {
        /// Kind of map.
        map: &'static str,
    },
    /// No material's model has the parameter.
    #[error(
        "no material has a model with the parameter \"{parameter}\"; `lapidary models` lists the parameters of each"
    )]
    NotRead {
        /// Name of the parameter.
        parameter: String,
    },
    /// There is no light, or none with this name.
    #[error("there is no local light \"{wanted}\" to sweep; there are {names}")]
    NoLight {
        /// The requested name.
        wanted: String,
        /// The existing names.
        names: String,
    },
    /// Several lights for a parameter of a single one.
    #[error("{parameter} moves one light; name it after @, as in {parameter}@NAME=...: there are {names}")]
    WhichLight {
        /// Name of the parameter.
        parameter: String,
        /// The existing names.
        names: String,
    },
}
