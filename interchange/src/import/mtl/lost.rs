//! Lines of a material library that are not shown: by the table of features, and unknown ones.

use super::MtlEntry;
use crate::{
    features::{self, Feature, Format, Support},
    names::listed,
};
use std::collections::{BTreeMap, BTreeSet};

/// Longest word of an unknown line that a warning names.
const LONGEST_KEY: usize = 20;

/// Unsupported features of materials, by material.
#[derive(Default)]
pub(super) struct Ignored {
    /// Materials that stop no light.
    pub invisible: Vec<String>,
    /// By the name of the feature.
    left_out: BTreeMap<&'static str, (Feature, Vec<String>)>,
    /// First words of lines that are in no format.
    unknown: BTreeSet<String>,
}

impl Ignored {
    /// Notes what of a material is left out.
    pub fn note(&mut self, material: &str, entry: &MtlEntry) {
        for key in entry.statements.keys().filter(|key| !entry.is_default(key)) {
            match features::of(Format::Mtl, key) {
                Some(feature) if matches!(feature.support, Support::LeftOut(_)) => {
                    let (_, materials) = self.left_out.entry(feature.name).or_insert((feature, Vec::new()));
                    if materials.last().is_none_or(|last| last != material) {
                        materials.push(material.to_owned());
                    }
                }
                Some(_) => {}
                None if is_word(key) => _ = self.unknown.insert(key.clone()),
                None => {}
            }
        }
    }

    /// Warns of what was noted, but for invisible materials.
    pub fn warn(self, warnings: &mut Vec<String>) {
        warnings.extend(self.left_out.values().filter_map(|(feature, names)| feature.warning("materials", names)));
        if !self.unknown.is_empty() {
            let unknown: Vec<String> = self.unknown.into_iter().collect();
            warnings
                .push(format!("the lines {} of material libraries are not known and were left out", listed(&unknown)));
        }
    }
}

fn is_word(key: &str) -> bool {
    key.len() <= LONGEST_KEY && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') && !key.is_empty()
}
