//! Declaration of a reflectance model.

use super::{Brdf, FilePart, Parameter, Values};

/// A reflectance model that materials can have.
pub trait Model: Brdf + Sized {
    /// Display name.
    const LABEL: &'static str;
    /// Description and use, in one or two sentences.
    const SUMMARY: &'static str;
    /// Its parameters.
    const PARAMETERS: &'static [Parameter];
    /// Parameters that materials keep for other programs. They are never rendered and are in no other list.
    const STORED: &'static [Parameter] = &[];

    /// Creates the model from values in the order of [`Self::PARAMETERS`] and in their ranges. More values may follow.
    fn from_values(values: &Values) -> Self;

    /// [`Self::from_values`] for a model that uses a file; without the file, a placeholder.
    fn of_file(values: &Values, _file: Option<FilePart>) -> Self {
        Self::from_values(values)
    }
}
