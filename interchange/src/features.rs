//! The features of each format: read, approximated or left out. The guide's table is made of them, and the importers take
//! from them which extensions and statements they know, and what they say of those that are left out.

mod list;

pub(crate) use list::{PLY_OTHERS, gltf};

use crate::{materialx::Surface, names::listed};
use lapidary_core::brdf::BrdfModel;
use std::collections::HashSet;

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// glTF 2.0 and GLB.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// The material libraries of OBJ.
    Mtl,
    /// Stanford PLY.
    Ply,
    /// MaterialX documents.
    MaterialX,
    /// This program's material files.
    Material,
    /// Pictures of all formats.
    Picture,
}

impl Format {
    /// All formats, in the order of the table.
    pub const ALL: [Self; 7] =
        [Self::Gltf, Self::Obj, Self::Mtl, Self::Ply, Self::MaterialX, Self::Material, Self::Picture];

    /// Its name in the table.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Gltf => "glTF, GLB",
            Self::Obj => "OBJ",
            Self::Mtl => "MTL",
            Self::Ply => "PLY",
            Self::MaterialX => "MaterialX",
            Self::Material => "Material files (JSON)",
            Self::Picture => "Pictures",
        }
    }
}

/// What becomes of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// It is shown as its format defines it.
    Read,
    /// It is shown in this other way.
    Approximated(&'static str),
    /// It is not shown; the text tells what happens instead, or what to do.
    LeftOut(&'static str),
    /// It is not shown, and nothing is lost for this reason. Nothing is said of it on import.
    Unneeded(&'static str),
}

/// A feature of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feature {
    /// Its format.
    pub format: Format,
    /// Its words in files, separated by blanks: names of extensions, statements or inputs. It may have none.
    pub keys: &'static str,
    /// What it is, in the plural.
    pub name: &'static str,
    /// What becomes of it.
    pub support: Support,
}

impl Feature {
    /// Whether it has this word, in any case of its letters.
    fn has(&self, key: &str) -> bool {
        self.keys.split_whitespace().any(|own| own.eq_ignore_ascii_case(key))
    }

    /// The words on things that have the feature, such as "have clear coats, which are left out; ...". `None` if nothing
    /// is lost.
    pub(crate) fn lost(&self) -> Option<String> {
        match self.support {
            Support::Read | Support::Unneeded(_) => None,
            Support::Approximated(how) => Some(format!("have {}, {how}", self.name)),
            Support::LeftOut(remedy) => Some(format!("have {}, which are left out; {remedy}", self.name)),
        }
    }

    /// The warning that things of these names have the feature; empty if there are none.
    pub(crate) fn warning(&self, things: &str, names: &[String]) -> Option<String> {
        let lost = self.lost().filter(|_| !names.is_empty())?;
        Some(format!("the {things} {} {lost}", listed(names)))
    }
}

/// All features, by format.
pub fn all() -> impl Iterator<Item = Feature> {
    list::ALL.iter().flat_map(|features| features.iter().copied()).chain(of_surfaces())
}

/// The feature of a format with this word.
pub(crate) fn of(format: Format, key: &str) -> Option<Feature> {
    list::ALL.iter().flat_map(|features| features.iter()).find(|f| f.format == format && f.has(key)).copied()
}

/// Whether a word of a format is read, at least approximately.
pub(crate) fn is_read(format: Format, key: &str) -> bool {
    of(format, key).is_some_and(|f| matches!(f.support, Support::Read | Support::Approximated(_)))
}

/// The inputs of MaterialX surfaces that are stored or lost.
fn of_surfaces() -> impl Iterator<Item = Feature> {
    const STORED: Support = Support::LeftOut("kept, and written back to MaterialX");
    let of = |keys, name, support| Feature { format: Format::MaterialX, keys, name, support };
    let stored = BrdfModel::OpenPbr.stored_parameters().iter();
    let stored = stored.map(move |p| of(p.name, "inputs of OpenPBR that are stored and not rendered", STORED));
    let lost = Surface::ALL.into_iter().flat_map(Surface::lost);
    stored.chain(lost.map(move |lost| of(lost.input, lost.what, Support::LeftOut("a message names it"))))
}

/// The table of all features for the guide, in Markdown.
pub fn table() -> String {
    let mut text = String::new();
    for format in Format::ALL {
        text += &format!("\n**{}**\n\n| feature | support | how, or what to do |\n|---|---|---|\n", format.label());
        text.extend(rows(format).iter().map(row));
    }
    text
}

/// A feature, and the words of all of its name.
type Row = (Feature, Vec<&'static str>);

fn rows(format: Format) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for feature in all().filter(|feature| feature.format == format) {
        let is_same = |(other, _): &&mut Row| (other.name, other.support) == (feature.name, feature.support);
        match rows.iter_mut().find(is_same) {
            Some((_, keys)) => keys.extend(feature.keys.split_whitespace()),
            None => rows.push((feature, feature.keys.split_whitespace().collect())),
        }
    }
    for (_, keys) in &mut rows {
        let mut known = HashSet::new();
        keys.retain(|key| known.insert(*key));
    }
    rows
}

fn row((feature, keys): &Row) -> String {
    let mut name: String = feature.name.into();
    name[..1].make_ascii_uppercase();
    let keys: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
    let keys = if keys.is_empty() { String::new() } else { format!(": {}", keys.join(", ")) };
    let (support, how) = match feature.support {
        Support::Read => ("read", ""),
        Support::Approximated(how) => ("approximated", how),
        Support::LeftOut(remedy) => ("left out", remedy),
        Support::Unneeded(why) => ("not needed", why),
    };
    format!("| {name}{keys} | {support} | {how} |\n")
}

#[cfg(test)]
mod tests;
