//! Names of the bake settings' controls, and the remedies against errors in terms of controls.

use lapidary_precompute::{Setting, SettingsError};
use lapidary_render::Remedy;

/// The label of a setting's control, or its plain name if it has none.
pub fn control_name(setting: Setting) -> &'static str {
    match setting {
        Setting::Lights => "Lights",
        Setting::Beta => "Beta",
        Setting::Sigma => "Sigma",
        Setting::TotalError => "Total error",
        Setting::MaxVertices => "Max vertices",
        Setting::MaxBytes => "Byte budget",
        Setting::Shots => "Views",
        Setting::Mode => "Bake type",
        Setting::Sources => "Sources",
        Setting::SourceSigma => "Source sigma",
        Setting::Levels => "Basis levels",
        Setting::SenderLevels => "Sender levels",
        Setting::GatherRays => "Gather rays",
        Setting::Epsilon => "Epsilon",
        Setting::Compression => "Wavelet threshold",
        Setting::Functions => "Functions",
        Setting::Resume => "Resume",
        Setting::MaxCut
        | Setting::PilotClusters
        | Setting::SourceContrast
        | Setting::LargestSolidAngle
        | Setting::Viewpoint
        | Setting::CoarseRadius
        | Setting::ObjectLevels
        | Setting::SenderLevel => setting.name(),
    }
}

/// The controls that apply a remedy; the renderer is chosen when the window starts.
pub fn remedy_control(remedy: Remedy) -> &'static str {
    match remedy {
        Remedy::Cpu => "start the window with --backend cpu",
        Remedy::FewerVertices => "bake with smaller Max vertices",
        Remedy::SmallerCuts => "bake with a larger Sigma and Source sigma, or smaller Max vertices",
        Remedy::FewerFunctions => "bake with fewer Levels",
        Remedy::SmallerPicture => remedy.words(),
        Remedy::EnvironmentBake => "choose Environment as Bake type, and bake again",
        Remedy::SourceBake => "choose Bounced light as Bake type, and bake again",
    }
}

/// The error in settings, as a sentence that begins with the control.
pub fn error_text(error: &SettingsError) -> String {
    let text = error.text(control_name);
    let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
    first.to_uppercase() + rest
}
