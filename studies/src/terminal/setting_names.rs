//! Command-line names of bake settings, and options that remedy errors.

use lapidary_precompute::{BakeError, CheckpointError, PointsError, Setting, SettingsError};
use lapidary_render::{BackendError, ExplainError, NoCuts, Remedy, SplitError};
use std::error::Error;

/// The option that sets it, or its plain name without one.
pub fn option_name(setting: Setting) -> &'static str {
    match setting {
        Setting::Lights => "--lights",
        Setting::Beta => "--beta",
        Setting::Sigma => "--sigma",
        Setting::MaxCut => "--max-cut",
        Setting::TotalError => "--total-error",
        Setting::PilotClusters => "--pilot-clusters",
        Setting::MaxVertices => "--max-vertices",
        Setting::MaxBytes => "--max-bytes",
        Setting::Shots => "--shot",
        Setting::Mode => "--mode",
        Setting::Sources => "--sources",
        Setting::SourceSigma => "--source-sigma",
        Setting::SourceContrast | Setting::LargestSolidAngle => setting.name(),
        Setting::Viewpoint => "--viewpoint x,y,z",
        Setting::Levels => "--levels",
        Setting::SenderLevels => "--sender-levels",
        Setting::CoarseRadius => "--coarse-radius",
        Setting::GatherRays => "--gather-rays",
        Setting::Epsilon => "--epsilon",
        Setting::Functions => "--functions",
        Setting::ObjectLevels => "--object-levels",
        Setting::SenderLevel => "--sender-level",
        Setting::Compression => "--tau",
        Setting::Resume => "--resume",
    }
}

/// The options that apply a remedy.
pub fn remedy_option(remedy: Remedy) -> &'static str {
    match remedy {
        Remedy::Cpu => "use --backend cpu",
        Remedy::FewerVertices => "bake with a smaller --max-vertices",
        Remedy::SmallerCuts => "bake with a larger --sigma and --source-sigma, or a smaller --max-vertices",
        Remedy::FewerFunctions => "bake with fewer --levels",
        Remedy::SmallerPicture => "lower --size",
        Remedy::EnvironmentBake => "bake it with --mode environment, cuts or all",
        Remedy::SourceBake => "bake it with --mode indirect, cuts or all",
    }
}

/// An error with helpful options.
pub fn with_options(error: &(dyn Error + 'static)) -> String {
    let bake = error.downcast_ref().map(|e: &BakeError| e.text(option_name));
    let settings = || error.downcast_ref().map(|e: &SettingsError| e.text(option_name));
    let points = || error.downcast_ref().map(|e: &PointsError| e.text(option_name));
    let checkpoint = || error.downcast_ref().map(|e: &CheckpointError| e.text(option_name));
    let backend = || error.downcast_ref().map(|e: &BackendError| e.text(remedy_option));
    let cuts = || no_cuts(error).map(|e| e.text(remedy_option));
    let told = bake.or_else(settings).or_else(points).or_else(checkpoint).or_else(backend).or_else(cuts);
    told.unwrap_or_else(|| error.to_string())
}

/// The missing cuts, if that is the error.
fn no_cuts(error: &(dyn Error + 'static)) -> Option<NoCuts> {
    let explained = match error.downcast_ref() {
        Some(ExplainError::NoCuts(cuts)) => Some(*cuts),
        _ => None,
    };
    let split = match error.downcast_ref() {
        Some(SplitError::NoCuts(cuts)) => Some(*cuts),
        _ => None,
    };
    explained.or(split).or(error.downcast_ref().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_tells_the_option_to_change() {
        let error = SettingsError::Range { setting: Setting::Beta, value: 2.0, low: 0.0, high: 1.0 };
        assert_eq!(with_options(&error), "--beta is 2, but must lie between 0 and 1");
        assert_eq!(error.to_string(), "beta is 2, but must lie between 0 and 1");
        let told = with_options(&BakeError::from(error));
        assert!(told.starts_with("--beta"), "{told}");
        assert!(with_options(&PointsError::NoViewpoint).ends_with("(--viewpoint x,y,z)"));
        assert!(with_options(&BakeError::Cancelled).contains("--resume"));
        let lost = BackendError::Driver("out of memory".into());
        assert!(with_options(&lost).ends_with("or use --backend cpu") && !lost.to_string().contains("--"), "{lost}");
        for error in [
            with_options(&NoCuts::Sources),
            with_options(&ExplainError::NoCuts(NoCuts::Sources)),
            with_options(&SplitError::NoCuts(NoCuts::Sources)),
        ] {
            assert_eq!(error, "the dataset has no surface sources; bake it with --mode indirect, cuts or all");
        }
    }
}
