//! The statements of a material library.

use crate::import::budget::{Budget, OverBudget};
use glam::{Vec2, Vec3};
use lapidary_core::texture::{Channel, Wrap};
use std::collections::HashMap;

/// Illumination models with transparency: glass, and refraction.
const TRANSPARENT_MODELS: [f32; 4] = [4.0, 6.0, 7.0, 9.0];

/// The statements of one material by lower-case key; the last of repeated ones counts.
#[derive(Debug, Default)]
pub(in crate::import) struct MtlEntry {
    statements: HashMap<String, Statement>,
    /// Whether `Tr` is the opacity: the program that wrote the file says so nowhere, but names itself in a comment.
    tr_is_opacity: bool,
}

/// A statement of a material.
#[derive(Debug)]
pub(in crate::import) struct Statement {
    /// Its key as the file has it.
    pub key: String,
    pub value: String,
}

/// All materials of a library by name. Unknown lines are skipped.
///
/// # Errors
/// More materials than the budget allows.
pub(in crate::import) fn parse(text: &str, budget: &mut Budget) -> Result<HashMap<String, MtlEntry>, OverBudget> {
    let mut entries = HashMap::new();
    let mut current: Option<(String, MtlEntry)> = None;
    let mut tr_is_opacity = false;
    for line in text.lines().map(str::trim) {
        if line.is_empty() {
            continue;
        }
        if let Some(comment) = line.strip_prefix('#') {
            tr_is_opacity |= comment.to_ascii_lowercase().contains("meshlab");
            continue;
        }
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if key == "newmtl" {
            budget.take_names(1)?;
            entries
                .extend(current.replace((value.trim().to_owned(), MtlEntry { tr_is_opacity, ..Default::default() })));
        } else if let Some((_, entry)) = &mut current {
            let statement = Statement { key: key.to_owned(), value: value.trim().to_owned() };
            entry.statements.insert(key.to_ascii_lowercase(), statement);
        }
    }
    entries.extend(current);
    Ok(entries)
}

/// A texture statement: options and the file name, which may contain spaces.
#[derive(Debug, PartialEq)]
pub(in crate::import) struct MapStatement {
    pub file: String,
    pub scale: Vec2,
    pub offset: Vec2,
    pub multiplier: f32,
    pub channel: Option<Channel>,
    pub wrap: Wrap,
    /// Options that are left out.
    pub lost: Vec<String>,
}

impl MtlEntry {
    /// All statements by lower-case key.
    pub fn statements(&self) -> impl Iterator<Item = (&str, &Statement)> {
        self.statements.iter().map(|(key, statement)| (key.as_str(), statement))
    }

    /// What follows a key.
    pub fn value(&self, key: &str) -> Option<&str> {
        Some(self.statements.get(key)?.value.as_str())
    }

    /// Whether light passes: by its opacity or its illumination model.
    pub fn is_transparent(&self) -> bool {
        self.opacity() < 1.0 || self.number("illum").is_some_and(|model| TRANSPARENT_MODELS.contains(&model))
    }

    pub fn number(&self, key: &str) -> Option<f32> {
        self.value(key)?.split_whitespace().next()?.parse().ok().filter(|x: &f32| x.is_finite())
    }

    /// Three numbers, or one for all.
    pub fn color(&self, key: &str) -> Option<Vec3> {
        let numbers: Option<Vec<f32>> = self.value(key)?.split_whitespace().take(3).map(|w| w.parse().ok()).collect();
        match *numbers? {
            [r, g, b] => Some(Vec3::new(r, g, b)),
            [gray] => Some(Vec3::splat(gray)),
            _ => None,
        }
        .filter(|c| c.is_finite())
    }

    /// `d`, or else what `Tr` says: most programs write `1 - d`, and some, as MeshLab, write `d`. An opaque material of
    /// theirs would be invisible, which its illumination model contradicts.
    pub fn opacity(&self) -> f32 {
        let Some(tr) = self.number("tr").filter(|_| self.number("d").is_none()) else {
            return self.number("d").unwrap_or(1.0);
        };
        let is_transparent = self.number("illum").is_none_or(|model| TRANSPARENT_MODELS.contains(&model));
        match self.tr_is_opacity {
            true => tr,
            false if tr >= 1.0 && !is_transparent => 1.0,
            false => 1.0 - tr,
        }
    }

    pub fn map(&self, key: &str) -> Option<MapStatement> {
        parse_map(self.value(key)?)
    }
}

/// Splits a texture statement such as `-bm 0.5 -s 2 2 1 my wood.png`.
fn parse_map(statement: &str) -> Option<MapStatement> {
    let mut map = MapStatement {
        file: String::new(),
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
        multiplier: 1.0,
        channel: None,
        wrap: Wrap::Repeat,
        lost: Vec::new(),
    };
    let mut rest = statement.trim();
    while let Some(option) = rest.strip_prefix('-') {
        let (name, after) = option.split_once(char::is_whitespace)?;
        rest = after.trim_start();
        if map.take(name, &mut rest)? {
            map.lost.push(name.to_owned());
        }
    }
    map.file = rest.trim().to_owned();
    (!map.file.is_empty()).then_some(map)
}

impl MapStatement {
    /// Takes an option with what follows it. Returns whether it is left out and shows; `None` without its numbers.
    fn take(&mut self, name: &str, rest: &mut &str) -> Option<bool> {
        match name {
            "s" | "o" | "t" | "mm" => {
                let numbers = take_numbers(rest);
                let pair = Vec2::new(*numbers.first()?, numbers.get(1).copied().unwrap_or(f32::from(name == "s")));
                match name {
                    "s" => self.scale = pair,
                    "o" => self.offset = pair,
                    "t" => return Some(numbers.iter().any(|number| *number != 0.0)),
                    _ => return Some(pair != Vec2::Y),
                }
            }
            "bm" => self.multiplier = *take_numbers(rest).first()?,
            "boost" => return Some(take_numbers(rest).first()? != &0.0),
            "imfchan" => {
                self.channel = channel(take_word(rest));
                return Some(self.channel.is_none());
            }
            // One word each.
            "blendu" | "blendv" => return Some(take_word(rest) == "off"),
            "clamp" => self.wrap = if take_word(rest) == "on" { Wrap::Clamp } else { Wrap::Repeat },
            "cc" => return Some(take_word(rest) == "on"),
            _ => {
                take_word(rest);
                return Some(true);
            }
        }
        Some(false)
    }
}

fn channel(word: &str) -> Option<Channel> {
    match word {
        "r" => Some(Channel::R),
        "g" => Some(Channel::G),
        "b" => Some(Channel::B),
        "m" => Some(Channel::A),
        _ => None,
    }
}

fn take_word<'a>(rest: &mut &'a str) -> &'a str {
    let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    *rest = after.trim_start();
    word
}

/// Up to three numbers; the last word is the file's name and stays even if it is a number.
fn take_numbers(rest: &mut &str) -> Vec<f32> {
    let mut numbers = Vec::new();
    while numbers.len() < 3 {
        let Some((word, after)) = rest.split_once(char::is_whitespace) else { break };
        let Ok(number) = word.parse::<f32>() else { break };
        numbers.push(if number.is_finite() { number } else { 0.0 });
        *rest = after.trim_start();
    }
    numbers
}

/// The statements of one material.
#[cfg(test)]
pub(super) fn entry(text: &str) -> MtlEntry {
    parse(&format!("newmtl m\n{text}"), &mut Budget::new(None)).unwrap().remove("m").unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_options_and_names_with_spaces_are_told_apart() {
        let map = parse_map("-s 2 3 1 -bm 0.5 -clamp on -o 0.25 my old\\wood 2.png").unwrap();
        assert_eq!((map.scale, map.offset), (Vec2::new(2.0, 3.0), Vec2::new(0.25, 0.0)));
        assert_eq!((map.multiplier, map.file.as_str(), map.wrap), (0.5, "my old\\wood 2.png", Wrap::Clamp));
        assert_eq!(parse_map("-clamp off a.png").unwrap().wrap, Wrap::Repeat);
        assert_eq!(parse_map("-bm 2 7").unwrap().file, "7");
        assert_eq!(parse_map("-bm 0.5"), None);
        assert_eq!(parse_map("-s"), None);
    }

    #[test]
    fn opacity_is_read_as_its_program_meant_it() {
        let opacity = |text: &str| entry(text).opacity();
        assert_eq!([opacity(""), opacity("d 0.25\nTr 1"), opacity("Tr 0.25\nillum 2")], [1.0, 0.25, 0.75]);
        // As MeshLab writes an opaque material. Glass of other programs stays transparent.
        assert_eq!([opacity("Tr 1.0\nillum 2"), opacity("Tr 1\nillum 2\nd 1"), opacity("Tr 1\nd x")], [1.0, 1.0, 0.0]);
        assert_eq!([opacity("Tr 1\nillum 4"), opacity("Tr 1"), opacity("Tr 0\nillum 2")], [0.0, 0.0, 1.0]);
        let by_meshlab = "#\n# Wavefront material file\n# Converted by Meshlab Group\n#\nnewmtl m\nTr 0.25\nillum 2\n";
        let opacity = |text: &str| parse(text, &mut Budget::new(None)).unwrap()["m"].opacity();
        assert_eq!([opacity(by_meshlab), opacity(&by_meshlab.replace("Meshlab", "Blender"))], [0.25, 0.75]);
    }
}
