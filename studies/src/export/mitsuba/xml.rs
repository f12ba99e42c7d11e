//! Elements of Mitsuba's scene format, as text. No value contains characters that XML needs escaped.

use glam::{Mat4, Vec3};
use std::fmt::Display;

/// A whole file around its elements.
pub fn document(elements: &str) -> String {
    format!("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<scene version=\"3.0.0\">\n{elements}</scene>\n")
}

/// A plugin of class `class` with its properties; `more` are further attributes.
pub fn plugin(class: &str, kind: &str, more: &str, properties: &str) -> String {
    format!("<{class} type=\"{kind}\"{more}>\n{properties}</{class}>\n")
}

/// A property with one value.
pub fn value(kind: &str, name: &str, value: impl Display) -> String {
    format!("  <{kind} name=\"{name}\" value=\"{value}\"/>\n")
}

/// Three numbers: a color (`rgb`), a `point` or a `vector`.
pub fn triple(kind: &str, name: &str, Vec3 { x, y, z }: Vec3) -> String {
    value(kind, name, format_args!("{x}, {y}, {z}"))
}

/// The property `to_world`, by a matrix.
pub fn to_world(matrix: Mat4) -> String {
    let rows: Vec<String> = matrix.transpose().to_cols_array().iter().map(f32::to_string).collect();
    format!("  <transform name=\"to_world\"><matrix value=\"{}\"/></transform>\n", rows.join(" "))
}

/// The property `to_world` for an object that looks along its +Z, from `origin` at `target`.
pub fn look_at(origin: Vec3, target: Vec3, up: Vec3) -> String {
    let point = |Vec3 { x, y, z }: Vec3| format!("{x}, {y}, {z}");
    let (origin, target, up) = (point(origin), point(target), point(up));
    format!(
        "  <transform name=\"to_world\"><lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/></transform>\n"
    )
}

/// A reference to an object by its id.
pub fn reference(id: &str) -> String {
    format!("  <ref id=\"{id}\"/>\n")
}
