//! Cards round divisions, roots and logarithms as they like, within some units in the last place: shaders whose results are off as much
//! show the same pictures. The software adapter rounds correctly, so without these tests it would not find what a card would. Left out
//! are `length`, `normalize` and `pow`, and the absolute error of logarithms near 1.
//!
//! `LAPIDARY_INEXACT=more` or `less` runs the other tests of the GPU with such shaders.

use super::{
    textures::look_of_all_maps,
    twin::{Rig, agrees, difference, scene, view},
};
use crate::{BrdfSampling, ViewMode, gpu::ShaderSource};
use glam::Vec2;
use naga::{
    Expression, Function, Handle, MathFunction, Module, ScalarKind,
    valid::{Capabilities, FunctionInfo, ValidationFlags, Validator},
};

/// Relative error of what is off: twice the spacing of floats above 1.
const OFF: f32 = 1.0 / (1 << 22) as f32;

/// The shaders that the environment asks for.
pub fn source() -> ShaderSource {
    match std::env::var("LAPIDARY_INEXACT").as_deref() {
        Ok("more") => ShaderSource::Changed(more),
        Ok("less") => ShaderSource::Changed(less),
        Ok(other) => panic!("LAPIDARY_INEXACT is {other}; give more or less"),
        Err(_) => ShaderSource::Embedded,
    }
}

/// What becomes of a program's text.
type Change = fn(&str) -> String;

/// All results somewhat larger.
fn more(text: &str) -> String {
    off_by(text, 1.0 + OFF)
}

/// All results somewhat smaller.
fn less(text: &str) -> String {
    off_by(text, 1.0 - OFF)
}

/// A program whose quotients, roots and logarithms of floats are multiplied by a factor.
fn off_by(text: &str, factor: f32) -> String {
    let module = naga::front::wgsl::parse_str(text).expect("a program that parses");
    let validated = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).expect("a valid one");
    let functions = module.functions.iter().map(|(handle, function)| (function, &validated[handle]));
    let entries = module.entry_points.iter().enumerate();
    let entries = entries.map(|(i, entry)| (&entry.function, validated.get_entry_point(i)));
    let mut inserted: Vec<(usize, String)> = Vec::new();
    for (function, info) in functions.chain(entries) {
        for (handle, expression) in function.expressions.iter().filter(|(handle, _)| is_float(&module, info, *handle)) {
            inserted.extend(changes(text, function, handle, expression, factor));
        }
    }
    inserted.sort();
    inserted.dedup();
    let mut changed = text.to_owned();
    inserted.iter().rev().for_each(|(place, what)| changed.insert_str(*place, what));
    changed
}

fn is_float(module: &Module, info: &FunctionInfo, handle: Handle<Expression>) -> bool {
    info[handle].ty.inner_with(&module.types).scalar_kind() == Some(ScalarKind::Float)
}

/// What is inserted at places of the text for an expression.
fn changes(
    text: &str,
    function: &Function,
    handle: Handle<Expression>,
    expression: &Expression,
    factor: f32,
) -> Vec<(usize, String)> {
    let Some(range) = function.expressions.get_span(handle).to_range() else { return Vec::new() };
    match *expression {
        // The dividend is multiplied: both operators bind from the left.
        Expression::Binary { op: naga::BinaryOperator::Divide, .. } => outside_parentheses(&text[range.clone()], b'/')
            .map(|slash| (range.start + slash, format!("* {factor:?} ")))
            .into_iter()
            .collect(),
        // Its place is that of the function's name.
        Expression::Math {
            fun: MathFunction::Sqrt | MathFunction::InverseSqrt | MathFunction::Log2 | MathFunction::Log,
            ..
        } => {
            let end = range.end + closing(&text[range.end..]);
            vec![(range.start, format!("({factor:?} * ")), (end, ")".into())]
        }
        _ => Vec::new(),
    }
}

/// Depth in parentheses and brackets at each byte of a text, and the byte.
fn depths(text: &str) -> impl Iterator<Item = (usize, i32, u8)> {
    text.bytes().enumerate().scan(0, |depth, (place, byte)| {
        *depth += i32::from(matches!(byte, b'(' | b'[')) - i32::from(matches!(byte, b')' | b']'));
        Some((place, *depth, byte))
    })
}

/// The last place of an operator that is in no parentheses.
fn outside_parentheses(text: &str, operator: u8) -> Option<usize> {
    let found = depths(text).filter(|(_, depth, byte)| *depth == 0 && *byte == operator).last();
    Some(found?.0)
}

/// The place behind the parenthesis that closes the first one.
fn closing(text: &str) -> usize {
    let closes = |(_, depth, byte): &(usize, i32, u8)| *depth == 0 && *byte == b')';
    depths(text).find(closes).expect("parentheses in pairs").0 + 1
}

#[test]
fn quotients_roots_and_logarithms_of_floats_are_off() {
    let text = "fn f(a: f32, n: u32) -> f32 {\n    return sqrt(a) / (a + 1.0) + log2(a / 2.0) * f32(n / 2u);\n}\n";
    let expected = "fn f(a: f32, n: u32) -> f32 {\n    return (1.5 * sqrt(a)) * 1.5 / (a + 1.0) + \
                    (1.5 * log2(a * 1.5 / 2.0)) * f32(n / 2u);\n}\n";
    assert_eq!(off_by(text, 1.5), expected);
}

/// A map's level as it was before it was bounded.
fn less_without_a_bound(text: &str) -> String {
    let bounded = "max(log2(max(width, long / count) / TEXELS_PER_WIDTH), 0.0)";
    less(&text.replace(bounded, "log2(max(width, long / count) / TEXELS_PER_WIDTH)"))
}

/// Scale of maps with several texels in a pixel along u, and a part of one along v: quotients of widths are 1.
const MANY_ALONG_ONE_AXIS: Vec2 = Vec2::new(0.9, 0.05);

#[test]
fn filtered_maps_are_as_on_the_cpu_where_results_are_not_rounded_correctly() {
    let changes: [(Change, bool); 3] = [(more, true), (less, true), (less_without_a_bound, false)];
    for (change, is_bounded) in changes {
        let Some(mut rig) = Rig::with(&ShaderSource::Changed(change), scene(), 64) else { return };
        let dataset = rig.renderer.dataset().clone();
        rig.look(look_of_all_maps(&dataset, MANY_ALONG_ONE_AXIS));
        for mode in [ViewMode::Shaded, ViewMode::Normals, ViewMode::Albedo] {
            let [gpu, cpu] = rig.both(&view(mode), BrdfSampling::Refine);
            let found = difference(&gpu, &cpu);
            assert_eq!(agrees(&gpu, &cpu), is_bounded, "{mode:?} {found:?}, the last is the negative control");
        }
    }
}
