//! The part of wavelet transport.

use super::{PartBake, Put, within};
use crate::{
    bake::{clock::Clock, phases::bounces::Bouncing},
    errors::{BakeError, SettingsError},
    observer::Phase,
    setting::Setting,
    wavelet::wavelet_transport,
};
use lapidary_core::dataset::BakeSettings;

/// Glossy bounces between quads.
pub struct WaveletBake;

impl PartBake for WaveletBake {
    fn draft(&self, settings: &mut BakeSettings) {
        settings.wavelet.compression = 1e-3;
    }

    fn check(&self, settings: &BakeSettings) -> Result<(), SettingsError> {
        within(&[(Setting::Compression, f64::from(settings.wavelet.compression), 0.0, 1.0)])
    }

    /// Unknown before the quads are known; a maze of 59 needs 60 MB.
    fn memory(&self, _vertices: u64, _settings: &BakeSettings, _threads: usize) -> u64 {
        200_000_000
    }

    fn size(&self) -> Option<Setting> {
        Some(Setting::Compression)
    }

    fn bake(&self, bouncing: &Bouncing, clock: &mut Clock) -> Result<Put, BakeError> {
        let (patches, observer) = (bouncing.patches.to_vec(), clock.observer);
        let pairs = (patches.len() * patches.len()) as u64;
        let geometry = bouncing.geometry;
        let (transport, report) = clock.time(Phase::Wavelet, pairs, "pairs of quads", || {
            wavelet_transport(&geometry.scene, patches, &geometry.intersector, &bouncing.settings.wavelet, observer)
        })?;
        Ok(Box::new(|dataset| (dataset.wavelet, dataset.report.wavelet) = (Some(transport.into()), Some(report))))
    }
}
