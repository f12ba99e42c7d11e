//! What of a material library is not rendered, by statement and material.

use super::statements::MtlEntry;
use crate::{
    features::{self, Feature, Format, Support},
    names::listed,
};
use std::collections::BTreeMap;

const NUMBERS: [&str; 11] = ["ni", "pr", "ns", "pm", "aniso", "anisor", "d", "tr", "pc", "pcr", "ps"];
const COLORS: [&str; 3] = ["kd", "ks", "ke"];
const COLOR_MAPS: [&str; 2] = ["map_kd", "map_ke"];
const NUMBER_MAPS: [&str; 7] = ["map_pr", "map_pm", "map_ks", "map_d", "map_pc", "map_pcr", "map_ps"];
const RELIEFS: [&str; 4] = ["norm", "map_kn", "bump", "map_bump"];

/// Largest number of kinds of statements in the report.
const MOST_KINDS: usize = 20;

/// Statements and options that are left out, and their materials.
#[derive(Default)]
pub(super) struct Lost {
    invisible: Vec<String>,
    metals: Vec<String>,
    by_kind: BTreeMap<String, Vec<String>>,
}

impl Lost {
    /// Notes what of a material is not rendered.
    pub fn inspect(&mut self, material: &str, entry: &MtlEntry) {
        if entry.opacity() <= 0.0 {
            self.invisible.push(material.to_owned());
        }
        if super::is_metal_by_highlight(entry) {
            self.metals.push(material.to_owned());
        }
        let mut statements: Vec<_> = entry.statements().collect();
        statements.sort_by_key(|(key, _)| *key);
        for (key, statement) in statements {
            let name = &statement.key;
            if let Some(text) = lost(entry, key, name) {
                self.note(text, material);
            }
            for option in lost_options(entry, key) {
                self.note(format!("the option -{option} of {name}, which is left out"), material);
            }
        }
        if has_colored_highlight(entry) {
            self.note("a highlight (Ks) with a hue, which is left out".into(), material);
        }
    }

    fn note(&mut self, text: String, material: &str) {
        self.by_kind.entry(text).or_default().push(material.to_owned());
    }

    pub fn warn(&self, warnings: &mut Vec<String>) {
        if !self.invisible.is_empty() {
            warnings.push(format!(
                "the materials {} stop no light and are not seen; if their file means the opposite, raise their opacity",
                listed(&self.invisible)
            ));
        }
        if !self.metals.is_empty() {
            warnings.push(format!(
                "the materials {} are metals, since their highlights (Ks) outshine their colors (Kd); write \"Pm 0\" where one \
                 is none",
                listed(&self.metals)
            ));
        }
        let kinds = self.by_kind.iter().take(MOST_KINDS);
        warnings.extend(kinds.map(|(text, names)| format!("the materials {} have {text}", listed(names))));
        if self.by_kind.len() > MOST_KINDS {
            warnings.push(format!(
                "{} more kinds of statements of materials are left out",
                self.by_kind.len() - MOST_KINDS
            ));
        }
    }
}

/// A statement that is left out, in words.
fn lost(entry: &MtlEntry, key: &str, name: &str) -> Option<String> {
    let feature = features::of(Format::Mtl, key);
    let is_map = COLOR_MAPS.iter().chain(&NUMBER_MAPS).chain(&RELIEFS).any(|map| *map == key);
    let is_readable = match key {
        "map_ka" if entry.value(key) == entry.value("map_kd") => return None,
        "tf" if !entry.is_transparent() || entry.color(key) == Some(glam::Vec3::ONE) => return None,
        "ni" if entry.number(key).is_some_and(|ni| !(1.0..=4.0).contains(&ni)) => {
            return Some(format!("the statement {name} out of 1 to 4, which is left out"));
        }
        "map_kn" | "map_bump" if is_second(entry, key) => {
            return Some(format!("the statement {name} beside another one, which is left out"));
        }
        _ if features::of(Format::Mtl, key).is_some_and(|feature| feature.lost().is_none() || key == "illum")
            && !is_map
            && !NUMBERS.contains(&key)
            && !COLORS.contains(&key) =>
        {
            true
        }
        _ if NUMBERS.contains(&key) => entry.number(key).is_some(),
        _ if COLORS.contains(&key) => entry.color(key).is_some(),
        _ if is_map => entry.map(key).is_some(),
        _ => feature.is_some_and(|feature| !matches!(feature.support, Support::LeftOut(_))),
    };
    if is_readable {
        return None;
    }
    if is_map || NUMBERS.contains(&key) || COLORS.contains(&key) {
        return Some(format!("the statement {name} in a form that is not read, which is left out"));
    }
    Some(match feature {
        Some(Feature { name: meaning, support: Support::LeftOut(remedy), .. }) => {
            format!("the statement {name} ({meaning}), which is left out; {remedy}")
        }
        _ => format!("the statement {name}, which is left out"),
    })
}

/// Whether another key names another picture for the same map: that one counts.
fn is_second(entry: &MtlEntry, key: &str) -> bool {
    let first = entry.map(if key == "map_kn" { "norm" } else { "bump" });
    first.is_some_and(|first| entry.map(key).is_none_or(|map| map.file != first.file))
}

/// The options of a map that are left out.
fn lost_options(entry: &MtlEntry, key: &str) -> Vec<String> {
    let is_color = COLOR_MAPS.contains(&key);
    let is_relief = RELIEFS.contains(&key);
    let Some(map) = entry.map(key).filter(|_| is_color || is_relief || NUMBER_MAPS.contains(&key)) else {
        return Vec::new();
    };
    let channel = (is_color && map.channel.is_some()).then(|| "imfchan".to_owned());
    let multiplier = (!is_relief && map.multiplier != 1.0).then(|| "bm".to_owned());
    map.lost.into_iter().chain(channel).chain(multiplier).collect()
}

/// Whether a dielectric has a highlight of another color than white: its hue is lost.
fn has_colored_highlight(entry: &MtlEntry) -> bool {
    let Some(highlight) = entry.color("ks") else { return false };
    let is_colored = highlight.max_element() - highlight.min_element() > 0.05 * highlight.max_element();
    let is_metal = super::parameters(entry).metalness > 0.5;
    is_colored && !is_metal
}
