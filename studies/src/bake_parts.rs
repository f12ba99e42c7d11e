//! The parts of a bake as one table: the options, draft and words of each. A new part is its file here and its line in the table.

mod environment;
mod meshless;
mod sources;

use clap::Args;
use lapidary_core::dataset::{BakePart, BakeReport, BakeSettings};

/// What is said of one part of a bake outside of the bake itself.
pub trait StudiedPart: Sync {
    /// How fine it became, in the line with which a bake ends; `None` if it was not baked.
    fn summary(&self, report: &BakeReport) -> Option<String>;

    /// Its lines of `info`.
    fn info(&self, report: &BakeReport, settings: &BakeSettings) -> String;

    /// Makes `draft`, the settings of [`Preset::Draft`](lapidary_precompute::Preset::Draft), those of the draft that is shown while
    /// a bake as `wanted` goes on: in nothing finer.
    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings);

    /// Whether it is baked sooner as in the draft.
    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool;

    /// Whether a scene is put on a ground without being asked to.
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

        /// Options of `bake` that set parts.
        #[derive(Args, Clone, Debug)]
        pub struct PartOptions {
            $(#[command(flatten)] $module: $options,)*
        }

        impl PartOptions {
            /// Changes what was asked for.
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
}

/// All entries, in the order in which they are baked.
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
