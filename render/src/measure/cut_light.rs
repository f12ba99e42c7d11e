//! The two kinds of light that cuts gather.

use crate::{
    light::{
        bounce::SourceLighting,
        environment::{EnvironmentLight, SceneLighting},
    },
    remedy::{Remedy, Wording},
    shade::node_field::{NodeField, SourceField},
};
use lapidary_core::{cut::packed::PackedCuts, dataset::Dataset};
use serde::Serialize;
use std::{error::Error, fmt, sync::Arc};

/// Light on a tree, with its illumination cut.
#[derive(Clone, Copy, Debug)]
pub enum CutLight<'a> {
    /// The environment: leaves are directions.
    Environment(&'a SceneLighting),
    /// Bounced light: leaves are sources on surfaces.
    Sources(&'a SourceLighting),
}

/// A [`CutLight`] that owns its light.
#[derive(Clone)]
pub enum GatheredLight {
    /// Light of the environment.
    Environment(Arc<EnvironmentLight>),
    /// Light bounced by surface sources.
    Sources(Arc<SourceLighting>),
}

impl GatheredLight {
    /// The light.
    pub fn light(&self) -> CutLight<'_> {
        match self {
            Self::Environment(lighting) => CutLight::Environment(lighting),
            Self::Sources(lighting) => CutLight::Sources(lighting),
        }
    }
}

/// Kind of light tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TreeOf {
    /// Leaves are directions.
    Environment,
    /// Leaves are sources on surfaces.
    Sources,
}

/// Why a tree has no cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCuts {
    /// Visibility of the environment was not baked.
    Environment,
    /// Surface sources were not baked.
    Sources,
}

impl NoCuts {
    /// The message, with remedies in `wording`.
    pub fn text(self, wording: Wording) -> String {
        let (what, remedy) = match self {
            Self::Environment => ("visibility of the environment", Remedy::EnvironmentBake),
            Self::Sources => ("surface sources", Remedy::SourceBake),
        };
        format!("the dataset has no {what}; {}", wording(remedy))
    }
}

impl fmt::Display for NoCuts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Remedy::words))
    }
}

impl Error for NoCuts {}

impl<'a> CutLight<'a> {
    /// Tree of this light.
    pub fn tree(&self) -> TreeOf {
        match self {
            Self::Environment(_) => TreeOf::Environment,
            Self::Sources(_) => TreeOf::Sources,
        }
    }

    /// The vertices' cuts over its tree.
    ///
    /// # Errors
    /// The cuts were not baked.
    pub fn cuts_of(&self, dataset: &'a Dataset) -> Result<&'a PackedCuts, NoCuts> {
        match self {
            Self::Environment(_) if dataset.settings.mode.environment() => Ok(&dataset.cuts),
            Self::Environment(_) => Err(NoCuts::Environment),
            Self::Sources(_) => dataset.indirect.as_ref().map(|bake| &bake.cuts).ok_or(NoCuts::Sources),
        }
    }

    /// Passes the tree to a job that handles both kinds.
    pub(crate) fn with_field<T>(self, job: impl FieldJob<Output = T>) -> T {
        match self {
            Self::Environment(lighting) => job.run(lighting),
            Self::Sources(lighting) => job.run(SourceField::new(lighting)),
        }
    }
}

/// Work on a tree of either kind.
pub(crate) trait FieldJob {
    /// Type of the result.
    type Output;
    /// Runs the job.
    fn run<F: NodeField + Sync>(self, field: F) -> Self::Output;
}
