//! The parameters that a user's BRDF declares, in comments:
//!
//! ```text
//! // @parameter name | Label | number | 10 | 1..500 | unit | What it does.
//! // @parameter tint | Tint | color | 0.8 0.8 0.8 | 0..1 | | What it does.
//! ```

use super::WrittenError;
use crate::brdf::{BrdfModel, MOST_NUMBERS, Parameter, SurfaceParameters, Value};
use glam::Vec3;
use std::sync::{LazyLock, Mutex};

/// Start of a line that declares a parameter.
const MARK: &str = "// @parameter";
/// Largest number of parameters: the room in shaders.
const MOST: usize = 32;

/// All parameter lists read so far, once each. Panels, sweeps and shaders refer to them for good. The leak is bounded
/// by the number of different heads, not of reads.
static KNOWN: LazyLock<Mutex<Vec<&'static [Parameter]>>> = LazyLock::new(Mutex::default);

/// Declarations of all files read so far, newest first.
pub fn all_declared() -> Vec<&'static Parameter> {
    let known = KNOWN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    known.iter().rev().copied().flatten().collect()
}

/// The list in the comments of a text, followed by the parameters of all materials.
///
/// # Errors
/// A line that is invalid or repeats a declaration.
pub fn parameters(text: &str) -> Result<&'static [Parameter], WrittenError> {
    let mut list: Vec<Line> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let Some(rest) = line.trim_start().strip_prefix(MARK) else { continue };
        let failed = |reason: String| WrittenError::at(text, index + 1, reason);
        let line = Line::read(rest).map_err(failed)?;
        check_name(&line, &list).map_err(failed)?;
        list.push(line);
    }
    let numbers: usize = list.iter().map(|line| if line.is_color() { 3 } else { 1 }).sum();
    let refused = |reason: String| Err(WrittenError::whole(reason));
    if list.is_empty() {
        return refused(format!(
            "it declares no parameter; write a line \"{MARK} name | Label | number | 1 | 0..1 | | Help.\""
        ));
    }
    let all = list.len() + SurfaceParameters::LIST.len();
    let numbers = numbers + SurfaceParameters::NUMBERS;
    if all > MOST || numbers > MOST_NUMBERS {
        return refused(format!(
            "it has {} parameters, with those of all materials {all} of {numbers} numbers, more than {MOST} of \
             {MOST_NUMBERS}; use fewer",
            list.len()
        ));
    }
    let mut known = KNOWN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let is_same = |known: &[Parameter]| known.len() == all && list.iter().zip(known).all(|(line, p)| line.says(p));
    if let Some(same) = known.iter().find(|known| is_same(known)) {
        return Ok(same);
    }
    let kept: Vec<Parameter> = list.iter().map(Line::kept).chain(SurfaceParameters::LIST.iter().copied()).collect();
    let kept: &'static [Parameter] = Box::leak(kept.into_boxed_slice());
    known.push(kept);
    Ok(kept)
}

/// A line that declares a parameter.
struct Line<'a> {
    name: &'a str,
    label: &'a str,
    unit: &'a str,
    help: String,
    default: Value,
    range: [f32; 2],
}

impl<'a> Line<'a> {
    fn is_color(&self) -> bool {
        matches!(self.default, Value::Color(_))
    }

    /// Whether the line declares exactly `p`.
    fn says(&self, p: &Parameter) -> bool {
        (self.name, self.label, self.unit, self.help.as_str()) == (p.name, p.label, p.unit, p.help)
            && (self.default, self.range) == (p.default, p.range)
    }

    /// The declaration, leaked.
    fn kept(&self) -> Parameter {
        let leaked = |text: &str| -> &'static str { Box::leak(text.to_owned().into_boxed_str()) };
        let number = Parameter::number(leaked(self.label), self.range, 0.0, leaked(&self.help));
        Parameter { default: self.default, unit: leaked(self.unit), ..number }.named(leaked(self.name))
    }

    /// Parses the fields behind the mark.
    fn read(rest: &'a str) -> Result<Self, String> {
        let fields: Vec<&str> = rest.split('|').map(str::trim).collect();
        let &[name, label, kind, default, range, unit, help] = &fields[..] else {
            return Err(format!(
                "a parameter has 7 fields (name | Label | kind | default | range | unit | help), not {}",
                fields.len()
            ));
        };
        let number = |text: &str| match text.trim().parse::<f32>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(format!("\"{text}\" is not a number")),
        };
        let (low, high) =
            range.split_once("..").ok_or(format!("the range \"{range}\" is not two numbers with .. between"))?;
        let range = [number(low)?, number(high)?];
        if !(range[0] < range[1]) || range.iter().any(|x| x.abs() > 1e6) {
            return Err("the range must go from a lower to a higher number within -1e6 to 1e6".into());
        }
        let numbers = default.split_whitespace().map(number).collect::<Result<Vec<_>, _>>()?;
        let default = match (kind, &numbers[..]) {
            ("number", &[x]) => Value::Number(x),
            ("color", &[x, y, z]) => Value::Color(Vec3::new(x, y, z)),
            ("number" | "color", _) => return Err("a number has one default, a color three".into()),
            _ => return Err(format!("the kind is number or color, not \"{kind}\"")),
        };
        if numbers.iter().any(|x| !(range[0]..=range[1]).contains(x)) {
            return Err(format!("the default is not in the range {} to {}", range[0], range[1]));
        }
        let help = if help.is_empty() { format!("{label}.") } else { help.to_owned() };
        Ok(Self { name, label, unit, help, default, range })
    }
}

/// The name is valid in WGSL and in files, and means the same as elsewhere.
fn check_name(line: &Line, before: &[Line]) -> Result<(), String> {
    let name = line.name;
    let is_lower = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) || !name.chars().all(is_lower) || name.contains("__") {
        return Err(format!("\"{name}\" is not a name; use lower-case letters, digits and _"));
    }
    if before.iter().any(|p| p.name == name) {
        return Err(format!("the parameter {name} is declared twice"));
    }
    if ["normal", "bump"].contains(&name) {
        return Err(format!("{name} is the name of a map; choose another"));
    }
    if SurfaceParameters::LIST.iter().any(|p| p.name == name) {
        return Err(format!("all materials have {name} already; choose another name"));
    }
    let Some(known) = BrdfModel::declared_by_models(name) else { return Ok(()) };
    let [low, high] = known.range;
    if known.is_color() != line.is_color() || line.range[0] < low || line.range[1] > high {
        let kind = if known.is_color() { "color" } else { "number" };
        return Err(format!(
            "{name} is a {kind} from {low} to {high} in other models; keep to that, or choose another name"
        ));
    }
    Ok(())
}

/// The structure of the parameters in WGSL. It is one line behind the text, so line numbers stay.
pub fn structure(list: &[Parameter]) -> String {
    let member = |p: &Parameter| format!(" {}: {},", p.name, if p.is_color() { "vec3<f32>" } else { "f32" });
    format!("\nstruct Parameters {{{} }}\n", list.iter().map(member).collect::<String>())
}
