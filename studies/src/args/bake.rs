//! Choices with names, as options.

use clap::ValueEnum;
use lapidary_core::light_tree::TreeKind;
use lapidary_precompute::Preset;

/// Clustering metric of the light tree, as an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TreeOption {
    /// Direction alone (Eq. 10 of the paper).
    Geometric,
    /// Pilot visibility alone (Eq. 11).
    DataDriven,
    /// Both, weighted by --beta (Eq. 12).
    Mixed,
}

impl From<TreeOption> for TreeKind {
    fn from(option: TreeOption) -> Self {
        match option {
            TreeOption::Geometric => Self::Geometric,
            TreeOption::DataDriven => Self::DataDriven,
            TreeOption::Mixed => Self::Mixed,
        }
    }
}

/// Preset, as an option.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PresetOption {
    /// 8,192 lights and surface sources, up to 30,000 vertices, a meshless basis of 4 levels: seconds for the
    /// environment alone.
    Draft,
    /// 32,768 lights and surface sources, sigma 2, up to 100,000 vertices, a meshless basis of 6 levels.
    #[default]
    Normal,
    /// Sigma 1.5 for the environment and up to 300,000 vertices, the rest as normal.
    High,
}

impl From<PresetOption> for Preset {
    fn from(option: PresetOption) -> Self {
        match option {
            PresetOption::Draft => Self::Draft,
            PresetOption::Normal => Self::Normal,
            PresetOption::High => Self::High,
        }
    }
}
