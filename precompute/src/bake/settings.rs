//! Presets from fast to good, and the check that turns options into settings.

use super::parts::{self, within};
use crate::{errors::SettingsError, setting::Setting};
use lapidary_core::{cut::CutCriterion, dataset::BakeSettings, ground::Ground, shot::Shot};
use serde::{Deserialize, Serialize};
use std::ops::Deref;

/// A named set of bake settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Few vertices, and draft settings for each part: for setting up a scene. Takes seconds for the environment alone.
    Draft,
    /// The papers' settings.
    #[default]
    Normal,
    /// Finer cuts over the environment and three times the vertices, for final pictures; all else as in [`Self::Normal`].
    High,
}

/// `most` vertices, or a quarter more than the mesh has. Without room for further vertices no triangle is split, and large
/// triangles have no shadows. The bundled still life has 57,810 vertices; with 12,000 more its error falls to a third.
pub fn with_room(most: usize, mesh_vertices: usize) -> usize {
    most.max(mesh_vertices + mesh_vertices / 4)
}

impl Preset {
    /// The settings for a scene with this many vertices, with room for more.
    pub fn settings_for(self, mesh_vertices: usize) -> BakeSettings {
        let settings = self.settings();
        let max_vertices = settings.max_vertices.map(|most| with_room(most, mesh_vertices));
        BakeSettings { max_vertices, ..settings }
    }

    /// The settings behind the name.
    pub fn settings(self) -> BakeSettings {
        let normal = BakeSettings::default();
        match self {
            Self::Draft => {
                let mut draft = BakeSettings { pilot_clusters: 256, max_vertices: Some(30_000), ..normal };
                parts::all().for_each(|part| part.draft(&mut draft));
                draft
            }
            Self::Normal => normal,
            Self::High => {
                let criterion = CutCriterion { sigma: 1.5, ..CutCriterion::default() };
                BakeSettings { criterion, max_vertices: Some(300_000), ..normal }
            }
        }
    }
}

/// Checked settings: code may rely on their ranges. Only [`resolve`] creates them.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedBake(BakeSettings);

impl Deref for ResolvedBake {
    type Target = BakeSettings;

    fn deref(&self) -> &BakeSettings {
        &self.0
    }
}

impl ResolvedBake {
    /// The settings for modification.
    pub fn into_settings(self) -> BakeSettings {
        self.0
    }

    /// Adds room for more vertices than the mesh has; see [`with_room`].
    pub fn with_room_for(mut self, mesh_vertices: usize) -> Self {
        self.0.max_vertices = self.0.max_vertices.map(|most| with_room(most, mesh_vertices));
        self
    }

    /// Sets the ground.
    pub fn with_ground(mut self, ground: Ground) -> Self {
        self.0.ground = ground;
        self
    }

    /// Sets shots after checking them.
    ///
    /// # Errors
    /// The first shot with an invalid camera.
    pub fn for_shots(mut self, shots: Vec<Shot>) -> Result<Self, SettingsError> {
        check_shots(&shots)?;
        self.0.shots = shots;
        Ok(self)
    }
}

/// Checks settings once; nothing checks them later.
///
/// # Errors
/// The first setting out of range.
pub fn resolve(settings: BakeSettings) -> Result<ResolvedBake, SettingsError> {
    check_shots(&settings.shots)?;
    within(&[
        (Setting::PilotClusters, settings.pilot_clusters as f64, 1.0, 65_536.0),
        (Setting::MaxVertices, settings.max_vertices.map_or(3.0, |most| most as f64), 3.0, 1e8),
    ])?;
    parts::all().try_for_each(|part| part.check(&settings))?;
    Ok(ResolvedBake(settings))
}

fn check_shots(shots: &[Shot]) -> Result<(), SettingsError> {
    match shots.iter().position(|shot| !shot.is_valid()) {
        Some(bad) => Err(SettingsError::Shot(bad + 1)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::{camera::Camera, dataset::IndirectSettings};

    #[test]
    fn a_dense_mesh_gets_room_for_more_vertices() {
        let vertices = |mesh| Preset::Draft.settings_for(mesh).max_vertices;
        assert_eq!((vertices(8), vertices(57_810)), (Some(30_000), Some(72_262)));
        assert_eq!(Preset::Draft.settings_for(8), Preset::Draft.settings());
    }

    #[test]
    fn presets_are_valid_and_bad_values_are_named() {
        for preset in [Preset::Draft, Preset::Normal, Preset::High] {
            assert!(resolve(preset.settings()).is_ok());
        }
        let normal = BakeSettings::default();
        assert!(matches!(resolve(BakeSettings { lights: 1000, ..normal.clone() }), Err(SettingsError::Lights(_))));
        let sources = IndirectSettings { sources: 1000, ..Default::default() };
        let odd = resolve(BakeSettings { indirect: sources, ..normal.clone() });
        assert_eq!(odd, Err(SettingsError::Sources(1000)));
        let toward = |target| Shot { camera: Camera::look_at(Vec3::ONE, target, 40.0), aspect: 1.0 };
        let shots = vec![toward(Vec3::ZERO), toward(Vec3::ONE)];
        assert!(resolve(BakeSettings { shots: shots[..1].to_vec(), ..normal.clone() }).is_ok());
        assert_eq!(resolve(BakeSettings { shots: shots.clone(), ..normal.clone() }), Err(SettingsError::Shot(2)));
        assert_eq!(resolve(normal.clone()).unwrap().for_shots(shots), Err(SettingsError::Shot(2)));
        let from = |x| IndirectSettings { viewpoint: Some(Vec3::new(1.0, x, 2.0)), ..normal.indirect };
        let viewpoint = |x| resolve(BakeSettings { indirect: from(x), ..normal.clone() });
        assert!(viewpoint(-1e9).is_ok());
        for far in [-1.1e9, f32::INFINITY, f32::NAN] {
            assert!(matches!(viewpoint(far), Err(SettingsError::Range { setting: Setting::Viewpoint, .. })), "{far}");
        }
        let beta = resolve(BakeSettings { beta: f32::NAN, ..normal });
        assert!(matches!(beta, Err(SettingsError::Range { setting: Setting::Beta, .. })));
    }
}
