//! The parts of a bake in one table, with options, draft settings and texts. A new part is a file here and a line in the table.

mod environment;
mod meshless;
mod object_bases;
mod sources;
mod wavelet;

use clap::Args;
use lapidary_core::dataset::{BakePart, BakeReport, BakeSettings};

/// Options and texts of one part of a bake.
pub trait StudiedPart: Sync {
    /// Result in the last line of a bake; `None` if not baked.
    fn summary(&self, report: &BakeReport) -> Option<String>;

    /// Lines in `info`.
    fn info(&self, report: &BakeReport, settings: &BakeSettings) -> String;

    /// Adjusts `draft`, from [`Preset::Draft`](lapidary_precompute::Preset::Draft), for the draft shown while `wanted` bakes. The
    /// draft must not be finer than `wanted` in any setting.
    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings);

    /// Whether the draft settings bake faster.
    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool;

    /// Whether a scene gets a ground by default.
    fn suits_a_ground(&self) -> bool {
        true
    }
}

macro_rules! bake_parts {
    ($($part:ident: $module:ident, $entry:expr, $options:ty;)*) => {
        /// The entry of a part.
        pub fn of(part: BakePart) -> &'static dyn StudiedPart {
            match part { $(BakePart::$part => &$entry,)* }
        }

        /// Options of `bake` for the parts.
        #[derive(Args, Clone, Debug)]
        pub struct PartOptions {
            $(#[command(flatten)] $module: $options,)*
        }

        impl PartOptions {
            /// Applies the options to `settings`.
            pub fn apply(&self, settings: &mut BakeSettings) {
                $(self.$module.apply(settings);)*
            }
        }
    };
}

bake_parts! {
    Environment: environment, environment::Environment, environment::EnvironmentOptions;
    Sources: sources, sources::Sources, sources::SourceOptions;
    Meshless: meshless, meshless::Meshless, meshless::MeshlessOptions;
    ObjectBases: object_bases, object_bases::ObjectBases, object_bases::ObjectBasesOptions;
    Wavelet: wavelet, wavelet::Wavelet, wavelet::WaveletOptions;
}

/// All parts in bake order.
pub fn all() -> impl Iterator<Item = &'static dyn StudiedPart> {
    BakePart::ALL.iter().map(|part| of(*part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::{BakeParts, IndirectReport};

    #[test]
    fn the_summary_tells_only_what_was_baked() {
        let parts = |report: &BakeReport| all().filter_map(|part| part.summary(report)).collect::<Vec<_>>();
        let environment = BakeReport { mean_cut: 170.0, ..Default::default() };
        assert_eq!(parts(&environment), ["170 nodes a cut, visibility RMS 0.000"]);
        let sources = IndirectReport { sources: 512, mean_cut: 87.0, relative_error: 0.05, ..Default::default() };
        let bounces = BakeReport { mode: BakeParts::INDIRECT, indirect: Some(sources), ..environment };
        assert_eq!(parts(&bounces), ["512 sources, 87 nodes a cut, error 5.0 %"]);
    }
}
