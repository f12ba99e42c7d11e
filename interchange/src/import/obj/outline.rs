//! First pass over the text of an OBJ file: counts and names, and everything that `tobj` reads wrongly or not at all.

use crate::{
    features::{self, Feature, Format, Support},
    import::{
        budget::{Budget, OverBudget},
        files::Trouble,
        repair::Smoothing,
    },
};
use glam::{DVec3, Vec3};
use lapidary_core::color::linear_from_srgb;
use std::{collections::HashSet, fmt::Write, iter::repeat_n, str::SplitWhitespace};

/// Largest component of colors from 0 to 1, with some room for rounding. Files with a larger one have colors from 0 to 255.
const MOST_FRACTION: f32 = 1.01;

/// Results of the pass, and the text in the form for `tobj`.
#[derive(Default)]
pub(super) struct Outline {
    /// Of the same line numbers. Lines and points are left out, and colors of vertices until [`Self::paint`]: `tobj` wants them on
    /// all or none.
    pub text: String,
    /// Names in the order of first use; `tobj` refers to them by index.
    pub materials: Names,
    pub libraries: Names,
    pub positions: u64,
    uvs: u64,
    normals: u64,
    corners: u64,
    pub triangles: u64,
    /// Faces with a surface, as `tobj` returns them.
    faces: u64,
    /// Colors of the first positions as in the file; the others are white.
    colors: Vec<Option<Vec3>>,
    /// Elements without a surface.
    lines: u64,
    points: u64,
    /// What its statements have that is left out, each once.
    lost: Vec<Feature>,
    /// The smoothing from a face on; empty without `s` statements.
    smoothing: Vec<(u64, FaceSmoothing)>,
}

/// The value of an `s` statement.
#[derive(Clone, Copy)]
enum FaceSmoothing {
    Off,
    Group(u32),
}

impl Outline {
    /// Joins continued lines, drops comments after numbers, and collects what the second pass needs.
    ///
    /// # Errors
    /// Faces without corners, and more names than the budget allows.
    pub fn new(file: &str, budget: &mut Budget) -> Result<Self, Trouble> {
        let mut outline = Self { text: String::with_capacity(file.len() + 64), ..Default::default() };
        let (mut continued, mut joined) = (String::new(), 0);
        for (index, line) in file.lines().enumerate() {
            let statement = match line.strip_suffix('\\') {
                Some(start) => {
                    continued.push_str(start);
                    continued.push(' ');
                    joined += 1;
                    continue;
                }
                None if joined == 0 => line,
                None => {
                    continued.push_str(line);
                    &continued
                }
            };
            outline.push_line(statement, budget).map_err(|trouble| at_line(trouble, index + 1))?;
            outline.text.extend(repeat_n('\n', 1 + std::mem::take(&mut joined)));
            continued.clear();
        }
        outline.push_line(&continued, budget).map_err(|trouble| at_line(trouble, file.lines().count()))?;
        Ok(outline)
    }

    /// Estimated number of vertices. Each distinct combination of a corner makes one; most programs write half as many
    /// more as there are positions, at seams and hard edges.
    pub fn vertices(&self) -> u64 {
        if self.normals == 0 && self.smoothing.iter().any(|(_, smoothing)| matches!(smoothing, FaceSmoothing::Off)) {
            return self.corners;
        }
        let most = self.positions.max(self.uvs).max(self.normals);
        (most + most / 2).min(self.corners)
    }

    fn push_line(&mut self, line: &str, budget: &mut Budget) -> Result<(), Trouble> {
        let trimmed = line.trim();
        let (key, value) = trimmed.split_once(char::is_whitespace).unwrap_or((trimmed, ""));
        let numbers = || value.split('#').next().unwrap_or_default().trim_end();
        match key {
            "v" => {
                let position = without_color(numbers());
                if let Some(color) = color(&numbers()[position.len()..]) {
                    self.colors.resize(self.positions as usize, None);
                    self.colors.push(Some(color));
                }
                self.positions += 1;
                self.push_statement(key, position);
            }
            "vt" => {
                self.uvs += 1;
                self.push_statement(key, numbers());
            }
            "vn" => {
                self.normals += 1;
                self.push_statement(key, numbers());
            }
            "f" => self.push_face(numbers())?,
            "l" => self.lines += 1,
            "p" => self.points += numbers().split_whitespace().count() as u64,
            "s" => self.push_smoothing(numbers()),
            "usemtl" if value.trim().is_empty() => {}
            "usemtl" => {
                self.push_statement(key, value.trim());
                self.materials.add(value.trim(), budget)?;
            }
            "mtllib" => self.libraries.add(value.trim(), budget)?,
            _ => {
                self.note(key);
                self.text.push_str(trimmed);
            }
        }
        Ok(())
    }

    /// Notes a statement that is left out.
    fn note(&mut self, key: &str) {
        if key.is_empty() || key.starts_with('#') {
            return;
        }
        let lost = features::of(Format::Obj, key).filter(|feature| matches!(feature.support, Support::LeftOut(_)));
        if let Some(feature) = lost.filter(|feature| !self.lost.contains(feature)) {
            self.lost.push(feature);
        }
    }

    fn push_statement(&mut self, key: &str, value: &str) {
        self.text.push_str(key);
        self.text.push(' ');
        self.text.push_str(value);
    }

    fn push_face(&mut self, corners: &str) -> Result<(), Trouble> {
        let count = corners.split_whitespace().count() as u64;
        match count {
            0 => return Err("a face has no corners".into()),
            1 => self.points += 1,
            2 => self.lines += 1,
            _ => {
                self.faces += 1;
                self.corners += count;
                self.triangles += count - 2;
                self.push_statement("f", corners);
            }
        }
        Ok(())
    }

    fn push_smoothing(&mut self, value: &str) {
        let Some(smoothing) = smoothing(value) else { return };
        match self.smoothing.last_mut() {
            Some((first, last)) if *first == self.faces => *last = smoothing,
            _ => self.smoothing.push((self.faces, smoothing)),
        }
    }

    /// The smoothing of each face; `None` without `s` statements. Before the first one it is left to the angle.
    pub fn smoothing(&self) -> Option<impl FnMut() -> Smoothing> {
        let (mut face, mut next) = (0u64, 0);
        (!self.smoothing.is_empty()).then_some(move || {
            while self.smoothing.get(next).is_some_and(|(first, _)| *first <= face) {
                next += 1;
            }
            let of_face = next.checked_sub(1).map_or(Smoothing::ByAngle, |last| match self.smoothing[last].1 {
                FaceSmoothing::Off => Smoothing::Flat(face as u32),
                FaceSmoothing::Group(group) => Smoothing::Group(group),
            });
            face += 1;
            of_face
        })
    }

    /// Warns of elements that were left out.
    pub fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.lost.iter().filter_map(Feature::lost).map(|lost| format!("parts of the file {lost}")));
        if self.lines + self.points > 0 {
            warnings.push(format!(
                "{} lines and {} points have no surface and were left out; give them a thickness in the modelling program \
                 to see them",
                self.lines, self.points
            ));
        }
    }

    /// Largest length of the text after [`Self::paint`].
    pub fn bytes_of_colors(&self) -> u64 {
        if self.colors.is_empty() { 0 } else { self.text.len() as u64 + 125 * self.positions }
    }

    /// Writes a color after each position of the text, if any has one. Damaged positions stay.
    pub fn paint(&mut self) {
        if self.colors.is_empty() {
            return;
        }
        let colors = std::mem::take(&mut self.colors);
        let most = colors.iter().flatten().fold(0.0, |most: f32, color| most.max(color.max_element()));
        let white = if most > MOST_FRACTION { 255.0 } else { 1.0 };
        let mut colors = colors.into_iter();
        self.replace_positions(|text, position, _| {
            let color = colors.next().flatten().map(|color| (color / white).map(linear_from_srgb));
            let Vec3 { x, y, z } = color.unwrap_or(Vec3::ONE);
            write!(text, "v {:e} {:e} {:e} {x:e} {y:e} {z:e}", position.x, position.y, position.z)
        });
    }

    /// Largest length of the text after [`Self::subtract`]: a number in double precision takes up to 25 bytes.
    pub fn bytes_of_subtraction(&self) -> u64 {
        self.text.len() as u64 + 75 * self.positions
    }

    /// Subtracts `offset` from the positions in the text, in double precision. Damaged ones stay.
    pub fn subtract(&mut self, offset: DVec3) {
        self.replace_positions(|text, position, color| {
            let DVec3 { x, y, z } = position - offset;
            write!(text, "v {x:e} {y:e} {z:e}{color}")
        });
    }

    /// Writes the statement of each position anew, from the position and the color after it. Damaged ones stay.
    fn replace_positions(&mut self, mut write: impl FnMut(&mut String, DVec3, &str) -> std::fmt::Result) {
        let mut text = String::with_capacity(self.text.len());
        for line in self.text.lines() {
            let numbers = line.strip_prefix("v ").unwrap_or_default();
            let place = without_color(numbers);
            match position(place.split_whitespace()) {
                Some(position) => write(&mut text, position, &numbers[place.len()..]).expect("a string takes all"),
                None => text.push_str(line),
            }
            text.push('\n');
        }
        self.text = text;
    }
}

fn at_line(trouble: Trouble, line: usize) -> Trouble {
    match trouble {
        Trouble::Reason(reason) => format!("{reason} at line {line}").into(),
        other => other,
    }
}

/// The first three of five or more numbers: the others are colors. A fourth of four divides the position.
fn without_color(numbers: &str) -> &str {
    let mut words = numbers.split_whitespace();
    let third = words.nth(2);
    match (third, words.nth(1)) {
        (Some(third), Some(_)) => &numbers[..third.as_ptr() as usize + third.len() - numbers.as_ptr() as usize],
        _ => numbers,
    }
}

/// The color of three sRGB numbers; more may follow.
fn color(numbers: &str) -> Option<Vec3> {
    let mut words = numbers.split_whitespace().map(|word| word.parse::<f32>().ok().filter(|number| number.is_finite()));
    let mut number = || words.next().flatten();
    Some(Vec3::new(number()?, number()?, number()?))
}

fn position(mut words: SplitWhitespace) -> Option<DVec3> {
    let mut number = || words.next().map(|word| word.parse::<f64>().ok());
    let position = DVec3::new(number()??, number()??, number()??);
    match number() {
        None => Some(position),
        Some(w) => w.filter(|w| *w != 0.0).map(|w| position / w),
    }
}

/// The value of a statement; `None` if it has none. A name in place of a number is a group, too.
fn smoothing(value: &str) -> Option<FaceSmoothing> {
    match value.split_whitespace().next()? {
        "off" | "0" => Some(FaceSmoothing::Off),
        group => Some(FaceSmoothing::Group(group.parse().unwrap_or(1))),
    }
}

/// Unique names.
#[derive(Default)]
pub(super) struct Names {
    pub in_order: Vec<String>,
    known: HashSet<String>,
}

impl Names {
    fn add(&mut self, name: &str, budget: &mut Budget) -> Result<(), OverBudget> {
        if !self.known.contains(name) {
            budget.take_names(1)?;
            self.known.insert(name.to_owned());
            self.in_order.push(name.to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_dropped_and_weights_stay() {
        for (given, kept) in [
            ("1 2 3", "1 2 3"),
            ("1 2 3 0.5", "1 2 3 0.5"),
            ("1  2 3 1 0 0", "1  2 3"),
            ("1 2 3 1 0", "1 2 3"),
            ("1 2 3 1 0 0 1", "1 2 3"),
            ("1 2", "1 2"),
            ("", ""),
        ] {
            assert_eq!(without_color(given), kept);
        }
        let of = |numbers: &str| position(numbers.split_whitespace());
        assert_eq!(of("2 4 6 2"), Some(DVec3::new(1.0, 2.0, 3.0)));
        assert_eq!([of("1 2"), of("1 2 x"), of("1 2 3 0"), of("1 2 3 x")], [None; 4]);
    }
}
