//! Coarsens cuts until they fit into a texture, and cuts over the environment until they fit into the byte budget.

use crate::{
    bake::settings::ResolvedBake,
    observer::{Event, Observer},
    setting::Setting,
    warning::Warning,
};
use lapidary_core::cut::{
    SourceCriterion,
    packed::{NODES_PER_TEXEL, TEXEL_BYTES, TEXTURE_WIDTH},
    prune, prune_sources,
};
use rayon::prelude::*;

/// Capacity of a texture in bytes.
pub const TEXTURE_BYTES: u64 = (TEXTURE_WIDTH * TEXTURE_WIDTH * TEXEL_BYTES) as u64;

/// Coarsens the vertices' cuts over the environment to the byte budget and to a texture. Returns them with their final
/// sigma.
pub fn fit_environment(
    cuts: Vec<Vec<u16>>,
    height: u32,
    settings: &ResolvedBake,
    observer: &dyn Observer,
) -> (Vec<Vec<u16>>, f32) {
    let (asked, least) = (settings.criterion.sigma, settings.criterion.sigma.max(0.25));
    let budget = settings.max_bytes.unwrap_or(u64::MAX).min(TEXTURE_BYTES);
    let (cuts, factor) = fit(cuts, budget, |factor, cut| prune(height, factor * least, cut));
    let sigma = factor.map_or(asked, |factor| factor * least);
    if factor.is_some() && budget == TEXTURE_BYTES {
        let message = Warning::Coarsened { leaves: "environment", bound: Setting::Sigma, asked, fitted: sigma };
        observer.event(Event::Warning { message });
    }
    (cuts, sigma)
}

/// Coarsens the vertices' cuts over the surface sources to at most `most` bytes. Returns the factor by which their
/// bounds were raised.
pub fn fit_sources(
    cuts: Vec<Vec<u16>>,
    height: u32,
    asked: SourceCriterion,
    most: u64,
    observer: &dyn Observer,
) -> (Vec<Vec<u16>>, Option<f32>) {
    let (cuts, factor) = fit(cuts, most, |factor, cut| prune_sources(height, asked.coarser(factor), cut));
    if let Some(factor) = factor {
        let (bound, fitted) = (Setting::SourceSigma, asked.coarser(factor).sigma);
        let message = Warning::Coarsened { leaves: "surface sources", bound, asked: asked.sigma, fitted };
        observer.event(Event::Warning { message });
    }
    (cuts, factor)
}

/// Coarsens all cuts by a common factor, the smallest of a geometric series with which they take at most `most` bytes.
/// `None` if they fit already.
fn fit(
    cuts: Vec<Vec<u16>>,
    most: u64,
    coarsened: impl Fn(f32, &[u16]) -> Vec<u16> + Sync,
) -> (Vec<Vec<u16>>, Option<f32>) {
    const STEP: f32 = 1.05;
    const LARGEST: f32 = 1e4;
    if bytes(&cuts) <= most {
        return (cuts, None);
    }
    let mut factor = STEP;
    loop {
        let fitted: Vec<_> = cuts.par_iter().map(|cut| coarsened(factor, cut)).collect();
        if bytes(&fitted) <= most || factor > LARGEST {
            return (fitted, Some(factor));
        }
        factor *= STEP;
    }
}

/// Size in whole texels.
fn bytes(cuts: &[Vec<u16>]) -> u64 {
    cuts.iter().map(|c| (c.len().div_ceil(NODES_PER_TEXEL) * TEXEL_BYTES) as u64).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bake::remarks::Remarks, observer::Silent};
    use lapidary_core::cut::{packed::VALUE_MAX, solid_angle_code};

    /// Nodes that alternate between visible and hidden, which any sigma below a half keeps.
    fn alternating(height: u32, seen: u16) -> Vec<u16> {
        (0..1_u16 << height).map(|i| ((height as u16) << 12) | ((i & 1) * seen)).collect()
    }

    #[test]
    fn cuts_are_coarsened_no_more_than_what_they_are_to_fit_into_asks() {
        let cuts = vec![alternating(6, VALUE_MAX); 10];
        let by_sigma = |factor: f32, cut: &[u16]| prune(6, 0.3 * factor, cut);
        assert_eq!(fit(cuts.clone(), bytes(&cuts), by_sigma), (cuts.clone(), None));
        let (fitted, factor) = fit(cuts.clone(), bytes(&cuts) - 1, by_sigma);
        assert!(bytes(&fitted) < bytes(&cuts));
        let factor = factor.expect("they did not fit");
        assert_eq!(by_sigma(factor / 1.05, &cuts[0]), cuts[0], "negative control: a step less");
        let (whole, _) = fit(cuts, 0, by_sigma);
        assert!(whole.iter().all(|c| c.len() == 1), "nothing fits into nothing, and the search ends");
    }

    #[test]
    fn sources_that_do_not_fit_are_coarsened_and_remarked() {
        let remarks = Remarks::before(&Silent);
        let criterion = SourceCriterion::default();
        let cuts = vec![alternating(6, solid_angle_code(1e-2)); 10];
        let whole = bytes(&cuts);
        assert_eq!(fit_sources(cuts.clone(), 6, criterion, whole, &remarks), (cuts.clone(), None));
        assert!(remarks.warnings().is_empty(), "negative control");
        let (fitted, factor) = fit_sources(cuts, 6, criterion, whole / 2, &remarks);
        assert!((1..=whole / 2).contains(&bytes(&fitted)) && factor.is_some_and(|f| f > 1.0));
        let said = remarks.warnings().concat();
        assert!(said.contains("to a source sigma of ") && said.contains(" instead of 2;"), "{said}");
    }
}
