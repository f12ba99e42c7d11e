//! Presets from fast to good, and the check that turns options into settings.

use crate::{errors::SettingsError, setting::Setting};
use lapidary_core::{
    bounds::MOST_COORDINATE,
    cut::CutCriterion,
    dataset::{BakeSettings, IndirectSettings, MeshlessSettings},
    ground::Ground,
    light_tree::height_of,
    shot::Shot,
};
use serde::{Deserialize, Serialize};
use std::ops::Deref;

/// A named set of bake settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// A quarter of the lights and of the surface sources, few vertices, and a meshless basis of four levels and half the
    /// rays: for setting up a scene. Seconds for the environment alone.
    Draft,
    /// The paper's 32,768 lights and sigma 2, as many surface sources, and the meshless paper's six levels.
    #[default]
    Normal,
    /// Finer cuts over the environment and three times the vertices, for final pictures; sources and meshless basis as in
    /// [`Self::Normal`].
    High,
}

/// `most` vertices, or a quarter more than the mesh has. Without room for further vertices nothing is split, and large
/// triangles have no shadows. The bundled still life has 57,810 vertices; with 12,000 more its error falls to a third.
pub fn with_room(most: usize, mesh_vertices: usize) -> usize {
    most.max(mesh_vertices + mesh_vertices / 4)
}

impl Preset {
    /// The settings for a scene with this many vertices, with room for some more.
    pub fn settings_for(self, mesh_vertices: usize) -> BakeSettings {
        let settings = self.settings();
        let max_vertices = settings.max_vertices.map(|most| with_room(most, mesh_vertices));
        BakeSettings { max_vertices, ..settings }
    }

    /// The settings behind the name.
    pub fn settings(self) -> BakeSettings {
        let normal = BakeSettings::default();
        let sigma = |sigma| CutCriterion { sigma, ..CutCriterion::default() };
        match self {
            // Eq. 5 bounds |C| var: a quarter of the lights at half the sigma is the same error in solid angle.
            Self::Draft => BakeSettings {
                lights: 8192,
                criterion: sigma(1.5),
                pilot_clusters: 256,
                max_vertices: Some(30_000),
                indirect: IndirectSettings { sources: 8192, ..normal.indirect },
                meshless: MeshlessSettings { levels: 4, sender_levels: 3, rays: 256, ..normal.meshless },
                ..normal
            },
            Self::Normal => normal,
            Self::High => BakeSettings { criterion: sigma(1.5), max_vertices: Some(300_000), ..normal },
        }
    }
}

/// Checked settings: code that holds them may rely on their ranges. Only [`resolve`] makes them.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedBake(BakeSettings);

impl Deref for ResolvedBake {
    type Target = BakeSettings;

    fn deref(&self) -> &BakeSettings {
        &self.0
    }
}

impl ResolvedBake {
    /// The settings, free to be changed.
    pub fn into_settings(self) -> BakeSettings {
        self.0
    }

    /// The same with room for some more vertices than the mesh has; see [`with_room`].
    pub fn with_room_for(mut self, mesh_vertices: usize) -> Self {
        self.0.max_vertices = self.0.max_vertices.map(|most| with_room(most, mesh_vertices));
        self
    }

    /// The same over a ground.
    pub fn with_ground(mut self, ground: Ground) -> Self {
        self.0.ground = ground;
        self
    }

    /// The same for these pictures, which are checked.
    ///
    /// # Errors
    /// The first shot whose camera is not usable.
    pub fn for_shots(mut self, shots: Vec<Shot>) -> Result<Self, SettingsError> {
        check_shots(&shots)?;
        self.0.shots = shots;
        Ok(self)
    }
}

/// Checks settings once; nothing checks them again.
///
/// # Errors
/// The first setting out of range.
pub fn resolve(settings: BakeSettings) -> Result<ResolvedBake, SettingsError> {
    height_of(settings.lights)?;
    height_of(settings.indirect.sources).map_err(|_| SettingsError::Sources(settings.indirect.sources))?;
    check_shots(&settings.shots)?;
    for (setting, value, low, high) in ranges(&settings) {
        if !(value >= low && value <= high) {
            return Err(SettingsError::Range { setting, value, low, high });
        }
    }
    Ok(ResolvedBake(settings))
}

fn check_shots(shots: &[Shot]) -> Result<(), SettingsError> {
    match shots.iter().position(|shot| !shot.is_valid()) {
        Some(bad) => Err(SettingsError::Shot(bad + 1)),
        None => Ok(()),
    }
}

/// Each number with its least and greatest value; for a number that is left out, its least value.
fn ranges(settings: &BakeSettings) -> [(Setting, f64, f64, f64); 16] {
    let (sources, meshless) = (&settings.indirect.criterion, &settings.meshless);
    let optional = |value: Option<f64>, low| value.unwrap_or(low);
    let viewpoint = settings.indirect.viewpoint.unwrap_or_default().to_array().map(f64::from);
    let farthest = viewpoint.into_iter().fold(0.0, |a: f64, b| if a.is_nan() || b.abs() <= a.abs() { a } else { b });
    [
        (Setting::Viewpoint, farthest, -f64::from(MOST_COORDINATE), f64::from(MOST_COORDINATE)),
        (Setting::Beta, f64::from(settings.beta), 0.0, 1.0),
        (Setting::Sigma, f64::from(settings.criterion.sigma), 0.0, 1e3),
        (Setting::SourceSigma, f64::from(sources.sigma), 0.0, 1e3),
        (Setting::SourceContrast, f64::from(sources.contrast), 0.0, 1e3),
        (Setting::LargestSolidAngle, f64::from(sources.max_solid_angle), 1e-4, 10.0),
        (Setting::Levels, meshless.levels as f64, 1.0, 8.0),
        (Setting::SenderLevels, meshless.sender_levels as f64, 1.0, meshless.levels as f64),
        (Setting::GatherRays, meshless.rays as f64, 16.0, 65_536.0),
        (Setting::Epsilon, f64::from(meshless.epsilon), 0.0, 1.0),
        (Setting::CoarseRadius, optional(meshless.coarse_radius.map(f64::from), 1.0), 1e-6, 1e9),
        (Setting::MaxCut, f64::from(settings.criterion.max_nodes), 1.0, f64::from(u32::MAX)),
        (Setting::TotalError, optional(settings.criterion.total_error.map(f64::from), 0.0), 0.0, 1e3),
        (Setting::PilotClusters, settings.pilot_clusters as f64, 1.0, 65_536.0),
        (Setting::MaxVertices, optional(settings.max_vertices.map(|v| v as f64), 3.0), 3.0, 1e8),
        (Setting::MaxBytes, optional(settings.max_bytes.map(|v| v as f64), 1024.0), 1024.0, 1e12),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::camera::Camera;

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
