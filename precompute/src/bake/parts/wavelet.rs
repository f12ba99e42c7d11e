//! The part of wavelet transport.

use super::{PartBake, Put, within};
use crate::{
    bake::{clock::Clock, phases::bounces::Bouncing},
    errors::{BakeError, SettingsError},
    observer::{Event, Observer, Phase},
    setting::Setting,
    warning::Warning,
    wavelet::wavelet_transport,
};
use lapidary_core::{
    dataset::{BakeSettings, Dataset, WaveletReport},
    scene::Scene,
    wavelet::{WaveletTransport, reflecting::ReflectingPatch},
};
use std::sync::Arc;

/// The quads of a scene, or what a share of the bake made of them.
pub enum Quads {
    /// Those of the scene as imported; none unless wavelet transport is baked.
    Found(Vec<ReflectingPatch>),
    /// The whole transport.
    Known(Arc<WaveletTransport>, WaveletReport),
}

impl Quads {
    /// The quads of a scene before it is tessellated, for these settings.
    ///
    /// # Errors
    /// A triangle that is no half of a quad.
    pub fn of_scene(scene: &Scene, settings: &BakeSettings, observer: &dyn Observer) -> Result<Self, BakeError> {
        if !settings.mode.wavelet() {
            return Ok(Self::Found(Vec::new()));
        }
        let patches = ReflectingPatch::of_scene(scene)?;
        let is_used = |material: u32| patches.iter().any(|reflecting| reflecting.patch.material == material);
        let materials = (0..).zip(&scene.materials).filter(|(index, _)| is_used(*index)).map(|(_, material)| material);
        if let Some(material) = materials.into_iter().find(|material| material.maps.iter().next().is_some()) {
            observer.event(Event::Warning { message: Warning::PlainQuads { material: material.name.clone() } });
        }
        Ok(Self::Found(patches))
    }

    /// The transport that a share has, if it has any.
    pub fn of_share(share: &Dataset) -> Self {
        let known = share.wavelet.clone().zip(share.report.wavelet.clone());
        known.map_or(Self::Found(Vec::new()), |(transport, report)| Self::Known(transport, report))
    }
}

/// Glossy bounces between quads.
pub struct WaveletBake;

impl PartBake for WaveletBake {
    fn draft(&self, settings: &mut BakeSettings) {
        settings.wavelet.compression = 1e-3;
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        within(&[(Setting::Compression, f64::from(settings.wavelet.compression), 1e-6, 1.0)])
    }

    /// Unknown before the quads are known: that of the maze of 59. A glossy floor needs three times as much.
    fn memory(&self, _vertices: u64, _settings: &BakeSettings, _threads: usize) -> u64 {
        540_000_000
    }

    fn size(&self) -> Option<Setting> {
        Some(Setting::Compression)
    }

    fn bake(&self, bouncing: &Bouncing, clock: &mut Clock) -> Result<Put, BakeError> {
        let (geometry, observer) = (bouncing.geometry, clock.observer);
        let (transport, report) = match bouncing.quads {
            Quads::Known(transport, report) => (transport.clone(), report.clone()),
            Quads::Found(patches) => {
                let (patches, settings) = (patches.clone(), &bouncing.settings.wavelet);
                let pairs = (patches.len() * patches.len()) as u64;
                let (transport, report) = clock.time(Phase::Wavelet, pairs, "pairs of quads", || {
                    wavelet_transport(&geometry.scene, patches, &geometry.intersector, settings, observer)
                })?;
                (transport.into(), report)
            }
        };
        Ok(Box::new(|dataset| (dataset.wavelet, dataset.report.wavelet) = (Some(transport), Some(report))))
    }
}
