//! The bounced light of a picture, by what shows it.

use crate::light::{
    bounce::{MeshlessLight, SourceLighting},
    local::LocalLighting,
    solver::BounceLight,
};
use std::sync::Arc;

/// Bounced light as the passes show it.
#[derive(Default)]
pub struct ShownBounce {
    /// Gathered in the merge.
    pub sources: Option<Arc<SourceLighting>>,
    /// Evaluated in a pass of their own.
    pub functions: Option<Arc<MeshlessLight>>,
}

impl ShownBounce {
    /// That of a picture, and a remark if no pass shows it.
    pub fn of(local: &LocalLighting) -> (Self, Option<String>) {
        let none = Self::default();
        match local.shown_bounce() {
            None => (none, None),
            Some(BounceLight::Sources(lighting)) => (Self { sources: Some(lighting.clone()), ..none }, None),
            Some(BounceLight::Functions(light)) => (Self { functions: Some(light.clone()), ..none }, None),
            Some(BounceLight::Vertices(_)) => {
                let remark = "the graphics adapter shows no bounced light of vertices; choose the CPU";
                (none, Some(remark.into()))
            }
        }
    }
}
