//! What a reflectance model declares.

use super::{Brdf, FilePart, Parameter, Values};

/// A reflectance model that materials can have.
pub trait Model: Brdf + Sized {
    /// Name for people.
    const LABEL: &'static str;
    /// What it is good for, in one or two sentences.
    const SUMMARY: &'static str;
    /// Its parameters.
    const PARAMETERS: &'static [Parameter];
    /// What its materials keep for other programs. Nothing is rendered of it, so that it is in no other list.
    const STORED: &'static [Parameter] = &[];

    /// With values in the order of [`Self::PARAMETERS`] and in their ranges. Others may follow them.
    fn from_values(values: &Values) -> Self;

    /// The same, of a model that a file has a part in; without the file what shows that it is not there.
    fn of_file(values: &Values, _file: Option<FilePart>) -> Self {
        Self::from_values(values)
    }
}
