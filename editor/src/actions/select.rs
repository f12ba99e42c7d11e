//! Requests about the selection.

use lapidary_core::parts::Part;

/// A request about the selection.
#[derive(Clone, Debug)]
pub enum SelectAction {
    /// Select an object alone, or nothing.
    Object(Option<u32>),
    /// Add an object to the selection, or take it away.
    Toggle(u32),
    /// Select a material, or nothing.
    Material(Option<usize>),
    /// Select a part of an object.
    Part(Part),
}
