//! The bases of objects.

use super::StudiedPart;
use clap::{Args, builder::RangedU64ValueParser};
use lapidary_core::{
    dataset::{BakeReport, BakeSettings, ObjectBasesReport, ObjectBasesSettings},
    meshless::RadiositySettings,
};

/// The part of the bases of objects.
pub struct ObjectBases;

/// Options of the bases of objects.
#[derive(Args, Clone, Debug)]
pub struct ObjectBasesOptions {
    /// Functions of all objects together, for light solved anew after a move, 1 to 10000000 [default: from the preset: 150000,
    /// draft 30000]
    #[arg(long, value_name = "N")]
    functions: Option<u32>,
    /// Levels of the objects' functions, 1 to 8 [default: from the preset: 6, draft 5]
    #[arg(long, value_name = "L")]
    object_levels: Option<usize>,
    /// Level of the objects' functions that sends light, from 1 [default: 4]
    #[arg(long, value_name = "L", value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    sender_level: Option<usize>,
}

impl ObjectBasesOptions {
    /// Applies the options to `settings`.
    pub fn apply(&self, settings: &mut BakeSettings) {
        let s = &mut settings.object_bases;
        s.functions = self.functions.unwrap_or(s.functions);
        s.levels = self.object_levels.unwrap_or(s.levels);
        s.sender_level =
            self.sender_level.map(|level| level - 1).unwrap_or(s.sender_level.min(s.levels.saturating_sub(1)));
    }
}

impl StudiedPart for ObjectBases {
    fn summary(&self, report: &BakeReport) -> Option<String> {
        report.object_bases.as_ref().map(|r| format!("{} functions of objects", r.functions.iter().sum::<usize>()))
    }

    fn info(&self, report: &BakeReport, settings: &BakeSettings) -> String {
        report.object_bases.as_ref().map_or(String::new(), |r| info_text(r, settings.object_bases))
    }

    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings) {
        let wanted = wanted.object_bases;
        let levels = wanted.levels.min(4);
        draft.object_bases = ObjectBasesSettings {
            functions: wanted.functions.min(10_000),
            levels,
            sender_level: wanted.sender_level.min(levels.saturating_sub(1)),
        };
    }

    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool {
        draft.object_bases.functions < wanted.object_bases.functions
    }

    /// The functions would spread over the whole ground and be coarse on the objects.
    fn suits_a_ground(&self) -> bool {
        false
    }
}

fn info_text(r: &ObjectBasesReport, settings: ObjectBasesSettings) -> String {
    let functions = r.functions.iter().sum::<usize>();
    format!(
        "radiosity  {functions} functions of {} objects on {} levels, level {} sends; {:.1} MB, and up to {:.0} MB of rays while it solves\n",
        r.objects,
        r.functions.len(),
        settings.sender_level + 1,
        r.bytes_points as f64 / 1e6,
        RadiositySettings::DEFAULT.bytes_of_rays(functions as u64) as f64 / 1e6
    )
}
