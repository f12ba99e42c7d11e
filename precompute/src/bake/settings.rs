//! Presets along quality and time, and the check that turns options into settings.

use crate::errors::SettingsError;
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeMode, BakeSettings, IndirectSettings, MeshlessSettings},
    light_tree::{TreeKind, height_of},
};
use serde::{Deserialize, Serialize};

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

/// `most` vertices, or a quarter more than a mesh has: without room for further ones nothing is split, and large triangles
/// have no shadows. The bundled still life has 57,810 vertices; with 12,000 more its error falls to a third.
pub fn with_room(most: usize, mesh_vertices: usize) -> usize {
    most.max(mesh_vertices + mesh_vertices / 4)
}

impl Preset {
    /// The settings for a scene of so many vertices, which get room for some more.
    pub fn settings_for(self, mesh_vertices: usize) -> BakeSettings {
        let settings = self.settings();
        let max_vertices = settings.max_vertices.map(|most| with_room(most, mesh_vertices));
        BakeSettings { max_vertices, ..settings }
    }

    /// The settings behind the name.
    pub fn settings(self) -> BakeSettings {
        let normal = BakeSettings {
            lights: 32_768,
            tree: TreeKind::Mixed,
            beta: 0.5,
            criterion: CutCriterion::default(),
            pilot_clusters: 1024,
            max_vertices: Some(100_000),
            shots: Vec::new(),
            max_bytes: None,
            mode: BakeMode::Environment,
            indirect: IndirectSettings::default(),
            meshless: MeshlessSettings::default(),
        };
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

/// Checks settings once; nothing validates them again.
///
/// # Errors
/// The first setting out of range.
pub fn resolve(settings: BakeSettings) -> Result<BakeSettings, SettingsError> {
    height_of(settings.lights)?;
    height_of(settings.indirect.sources).map_err(|_| SettingsError::Sources(settings.indirect.sources))?;
    if let Some(bad) = settings.shots.iter().position(|shot| !shot.is_valid()) {
        return Err(SettingsError::Shot(bad + 1));
    }
    let optional = |value: Option<f64>, low| value.unwrap_or(low);
    for (name, value, low, high) in [
        ("--beta", f64::from(settings.beta), 0.0, 1.0),
        ("--sigma", f64::from(settings.criterion.sigma), 0.0, 1e3),
        ("--source-sigma", f64::from(settings.indirect.criterion.sigma), 0.0, 1e3),
        ("source contrast", f64::from(settings.indirect.criterion.contrast), 0.0, 1e3),
        ("largest solid angle", f64::from(settings.indirect.criterion.max_solid_angle), 1e-4, 10.0),
        ("--levels", settings.meshless.levels as f64, 1.0, 8.0),
        ("--sender-levels", settings.meshless.sender_levels as f64, 1.0, settings.meshless.levels as f64),
        ("--gather-rays", settings.meshless.rays as f64, 16.0, 65_536.0),
        ("--epsilon", f64::from(settings.meshless.epsilon), 0.0, 1.0),
        ("--coarse-radius", optional(settings.meshless.coarse_radius.map(f64::from), 1.0), 1e-6, 1e9),
        ("--max-cut", f64::from(settings.criterion.max_nodes), 1.0, f64::from(u32::MAX)),
        ("--total-error", optional(settings.criterion.total_error.map(f64::from), 0.0), 0.0, 1e3),
        ("--pilot-clusters", settings.pilot_clusters as f64, 1.0, 65_536.0),
        ("--max-vertices", optional(settings.max_vertices.map(|v| v as f64), 3.0), 3.0, 1e8),
        ("--max-bytes", optional(settings.max_bytes.map(|v| v as f64), 1024.0), 1024.0, 1e12),
    ] {
        if !(value >= low && value <= high) {
            return Err(SettingsError::Range { name, value, low, high });
        }
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::{camera::Camera, shot::Shot};

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
        let normal = Preset::Normal.settings();
        assert!(matches!(resolve(BakeSettings { lights: 1000, ..normal.clone() }), Err(SettingsError::Lights(_))));
        let sources = IndirectSettings { sources: 1000, ..Default::default() };
        let odd = resolve(BakeSettings { indirect: sources, ..normal.clone() });
        assert_eq!(odd, Err(SettingsError::Sources(1000)));
        let toward = |target| Shot { camera: Camera::look_at(Vec3::ONE, target, 40.0), aspect: 1.0 };
        let shots = vec![toward(Vec3::ZERO), toward(Vec3::ONE)];
        assert!(resolve(BakeSettings { shots: shots[..1].to_vec(), ..normal.clone() }).is_ok());
        assert_eq!(resolve(BakeSettings { shots, ..normal.clone() }), Err(SettingsError::Shot(2)));
        let beta = resolve(BakeSettings { beta: f32::NAN, ..normal });
        assert!(matches!(beta, Err(SettingsError::Range { name: "--beta", .. })));
    }
}
