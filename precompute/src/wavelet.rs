//! Wavelet transport between quads, computed once for a scene (wavelet paper, section 4).

mod form_factor;
mod oracle;
mod refine;

pub(crate) use refine::direct_transport_between;
pub use refine::{TransportSettings, direct_transport};

use crate::{errors::BakeError, observer::Observer};
use lapidary_core::{
    dataset::{WaveletReport, WaveletSettings},
    offset,
    ray::Intersector,
    scene::Scene,
    wavelet::{WaveletTransport, patch::Patch, reflecting::ReflectingPatch, series::GlobalTransport},
};

/// Transport of one bounce and of all between patches of a scene. Hidden objects take no part.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn wavelet_transport(
    scene: &Scene,
    patches: Vec<ReflectingPatch>,
    rays: &Intersector,
    settings: &WaveletSettings,
    observer: &dyn Observer,
) -> Result<(WaveletTransport, WaveletReport), BakeError> {
    let offset = offset::TRANSPORT * scene.mesh.bounds().diagonal();
    let settings = TransportSettings::compressed(settings.compression);
    let is_shown = |patch: &Patch| !scene.hidden.contains_key(&patch.object);
    let (basis, direct) = direct_transport(&patches, &is_shown, rays, offset, &settings, observer)?;
    let series = GlobalTransport::of_while(&direct, settings.compression, &|| !observer.cancelled());
    let GlobalTransport { operator: global, coefficients: powers } = series.ok_or(BakeError::Cancelled)?;
    let report = WaveletReport {
        patches: patches.len(),
        functions: basis.functions().len(),
        direct: direct.len(),
        global: global.len(),
        powers,
        bytes: direct.bytes() + global.bytes(),
    };
    Ok((WaveletTransport { patches, basis, direct, global }, report))
}

#[cfg(test)]
mod tests;
