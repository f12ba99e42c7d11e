//! The meshless basis and its transport operator.

use super::StudiedPart;
use clap::Args;
use lapidary_core::dataset::{BakeReport, BakeSettings, MeshlessReport, MeshlessSettings};

/// The meshless part.
pub struct Meshless;

/// Options of the meshless part.
#[derive(Args, Clone, Debug)]
pub struct MeshlessOptions {
    /// Levels of the meshless basis, 1 to 8 [default: from the preset]
    #[arg(long, value_name = "L")]
    levels: Option<usize>,
    /// First levels of the meshless basis that send light [default: from the preset: 4, draft 3]
    #[arg(long, value_name = "L")]
    sender_levels: Option<usize>,
    /// Distance between the coarsest points of the meshless basis in meters, at least 1/10000 of the scene's diagonal [default:
    /// about 300 points]
    #[arg(long, value_name = "R")]
    coarse_radius: Option<f32>,
    /// Gather rays per point of the meshless basis, 16 to 65536 [default: from the preset]
    #[arg(long, value_name = "N")]
    gather_rays: Option<usize>,
    /// Smallest link between functions of the meshless basis to keep, as a share of the light of a sender of reflectance 0.38; 0 to
    /// 1, smaller is finer [default: 0.025]
    #[arg(long, value_name = "E")]
    epsilon: Option<f32>,
}

impl MeshlessOptions {
    /// Applies the options to `settings`.
    pub fn apply(&self, settings: &mut BakeSettings) {
        let s = &mut settings.meshless;
        s.levels = self.levels.unwrap_or(s.levels);
        s.sender_levels = self.sender_levels.unwrap_or(s.sender_levels.min(s.levels));
        s.coarse_radius = self.coarse_radius.or(s.coarse_radius);
        s.rays = self.gather_rays.unwrap_or(s.rays);
        s.epsilon = self.epsilon.unwrap_or(s.epsilon);
    }
}

impl StudiedPart for Meshless {
    fn summary(&self, report: &BakeReport) -> Option<String> {
        report.meshless.as_ref().map(|r| format!("{} basis functions", r.functions.iter().sum::<usize>()))
    }

    fn info(&self, report: &BakeReport, _settings: &BakeSettings) -> String {
        report.meshless.as_ref().map_or(String::new(), info_text)
    }

    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings) {
        let wanted = wanted.meshless;
        draft.meshless = MeshlessSettings {
            levels: wanted.levels.min(3),
            sender_levels: wanted.sender_levels.min(3),
            coarse_radius: wanted.coarse_radius,
            rays: wanted.rays.min(128),
            epsilon: wanted.epsilon.max(MeshlessSettings::default().epsilon),
        };
    }

    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool {
        let (few, many) = (draft.meshless, wanted.meshless);
        few.levels < many.levels || few.rays < many.rays
    }

    /// The basis would spread over the whole ground and be coarse on the objects.
    fn suits_a_ground(&self) -> bool {
        false
    }
}

fn info_text(r: &MeshlessReport) -> String {
    format!(
        "meshless   {} functions on {} levels, {} of them send\n\
         links      {}, {:.3} % of the possible ones, {:.1} MB with points\n",
        r.functions.iter().sum::<usize>(),
        r.functions.len(),
        r.senders,
        r.links,
        100.0 * r.share,
        (r.bytes_links + r.bytes_points) as f64 / 1e6
    )
}
