//! Coarsens cuts to fit a texture, and cuts over the environment to fit the byte budget.

use super::point_cuts::{PointCuts, texel_bytes};
use crate::{
    bake::settings::ResolvedBake,
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    setting::Setting,
    warning::Warning,
};
use lapidary_core::cut::{
    SourceCriterion,
    packed::{TEXEL_BYTES, TEXTURE_WIDTH},
    prune, prune_sources,
};
use rayon::prelude::*;

/// Capacity of a texture in bytes.
pub const TEXTURE_BYTES: u64 = (TEXTURE_WIDTH * TEXTURE_WIDTH * TEXEL_BYTES) as u64;

/// Factor on the error bounds with which cuts fit; `None` if they fit without.
pub type Factor = Option<f32>;

/// The factor with which the vertices' cuts over the environment fit the byte budget and a texture, and the final sigma.
///
/// # Errors
/// Cuts that can no longer be read, or [`BakeError::Cancelled`].
pub fn fit_environment(
    cuts: &PointCuts,
    settings: &ResolvedBake,
    observer: &dyn Observer,
) -> Result<(Factor, f32), BakeError> {
    let asked = settings.criterion.sigma;
    let budget = settings.max_bytes.unwrap_or(u64::MAX).min(TEXTURE_BYTES);
    let height = cuts.height();
    let factor = fit(cuts, budget, |factor, cut| coarser_environment(height, asked, factor, cut), observer)?;
    let sigma = factor.map_or(asked, |factor| factor * least_sigma(asked));
    if factor.is_some() && budget == TEXTURE_BYTES {
        let message = Warning::Coarsened { leaves: "environment", bound: Setting::Sigma, asked, fitted: sigma };
        observer.event(Event::Warning { message });
    }
    Ok((factor, sigma))
}

/// A cut over the environment with its bound raised by a factor.
pub fn coarser_environment(height: u32, asked: f32, factor: f32, cut: &[u16]) -> Vec<u16> {
    prune(height, factor * least_sigma(asked), cut)
}

/// Least sigma to raise: zero would stay zero.
fn least_sigma(asked: f32) -> f32 {
    asked.max(0.25)
}

/// The factor with which the vertices' cuts over the surface sources take at most `most` bytes.
///
/// # Errors
/// Cuts that can no longer be read, or [`BakeError::Cancelled`].
pub fn fit_sources(
    cuts: &PointCuts,
    asked: SourceCriterion,
    most: u64,
    observer: &dyn Observer,
) -> Result<Factor, BakeError> {
    let height = cuts.height();
    let factor = fit(cuts, most, |factor, cut| prune_sources(height, asked.coarser(factor), cut), observer)?;
    if let Some(factor) = factor {
        let (bound, fitted) = (Setting::SourceSigma, asked.coarser(factor).sigma);
        let message = Warning::Coarsened { leaves: "surface sources", bound, asked: asked.sigma, fitted };
        observer.event(Event::Warning { message });
    }
    Ok(factor)
}

/// The smallest factor of a geometric series with which all cuts take at most `most` bytes. `None` if they fit already.
fn fit(
    cuts: &PointCuts,
    most: u64,
    coarsened: impl Fn(f32, &[u16]) -> Vec<u16> + Sync,
    observer: &dyn Observer,
) -> Result<Factor, BakeError> {
    const STEP: f32 = 1.05;
    const LARGEST: i32 = 190; // a factor of ten thousand
    if cuts.bytes() <= most {
        return Ok(None);
    }
    let fits = |steps: i32| {
        let mut bytes = 0;
        cuts.each_chunk(|chunk| {
            cancelled(observer)?;
            bytes += chunk.par_iter().map(|cut| texel_bytes(coarsened(STEP.powi(steps), cut).len())).sum::<u64>();
            Ok(())
        })?;
        Ok::<bool, BakeError>(bytes <= most)
    };
    // Coarser cuts are never longer. Each round reads all chunks, so rounds must be few.
    let (mut too_few, mut enough) = (0, LARGEST);
    while enough - too_few > 1 {
        let middle = (too_few + enough) / 2;
        match fits(middle)? {
            true => enough = middle,
            false => too_few = middle,
        }
    }
    Ok(Some(STEP.powi(enough)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bake::{checkpoint::Chunk, remarks::Remarks},
        observer::Silent,
    };
    use lapidary_core::cut::{packed::VALUE_MAX, solid_angle_code};

    /// Nodes alternating between visible and hidden, which any sigma below a half keeps.
    fn alternating(height: u32, seen: u16) -> Vec<u16> {
        (0..1_u16 << height).map(|i| ((height as u16) << 12) | ((i & 1) * seen)).collect()
    }

    /// Ten equal cuts in two chunks.
    fn ten(cut: &[u16], height: u32) -> PointCuts<'static> {
        let mut cuts = PointCuts::new(height);
        for count in [3, 7] {
            let mut chunk = Chunk::default();
            (0..count).for_each(|_| chunk.push(cut, 0.0, 0));
            cuts.push(chunk);
        }
        cuts
    }

    #[test]
    fn cuts_are_coarsened_no_more_than_what_they_are_to_fit_into_asks() {
        let cut = alternating(6, VALUE_MAX);
        let cuts = ten(&cut, 6);
        let by_sigma = |factor: f32, cut: &[u16]| prune(6, 0.3 * factor, cut);
        let whole = cuts.bytes();
        assert_eq!((whole, fit(&cuts, whole, by_sigma, &Silent).unwrap()), (10 * 2 * 64, None));
        let factor = fit(&cuts, whole - 1, by_sigma, &Silent).unwrap().expect("they did not fit");
        assert!(by_sigma(factor, &cut).len() < cut.len());
        assert_eq!(by_sigma(factor / 1.05, &cut), cut, "negative control: one step less");
        let factor = fit(&cuts, 0, by_sigma, &Silent).unwrap().expect("nothing fits into nothing, and the search ends");
        assert_eq!(by_sigma(factor, &cut).len(), 1);
    }

    #[test]
    fn sources_that_do_not_fit_are_coarsened_and_remarked() {
        let remarks = Remarks::before(&Silent);
        let criterion = SourceCriterion::default();
        let cut = alternating(6, solid_angle_code(1e-2));
        let cuts = ten(&cut, 6);
        let whole = cuts.bytes();
        assert_eq!(fit_sources(&cuts, criterion, whole, &remarks).unwrap(), None);
        assert!(remarks.warnings().is_empty(), "negative control");
        let factor = fit_sources(&cuts, criterion, whole / 2, &remarks).unwrap().expect("they do not fit");
        assert!(factor > 1.0 && prune_sources(6, criterion.coarser(factor), &cut).len() <= cut.len() / 2);
        let said = remarks.warnings().concat();
        assert!(said.contains("to a source sigma of ") && said.contains(" instead of 2;"), "{said}");
    }
}
