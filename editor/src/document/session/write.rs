//! Writing of a session file.

use super::{AUTOSAVE_KEY, Session, SessionError, Unknown, VERSION, VERSION_KEY};
use crate::document::{
    Document,
    relative::{absolute, folder_of, relative_to},
};
use lapidary_core::output::write_atomically;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Writes `document` as a session, with the unknown keys of its original file.
///
/// # Errors
/// Errors of the file system; an existing file is kept then.
pub fn save(document: &Document, kept: &Unknown, path: &Path) -> Result<(), SessionError> {
    let folder = folder_of(path);
    write(value(document, kept, |path| relative_to(path, &folder)), path)
}

/// Writes `document` with absolute paths, and `note` about it.
///
/// # Errors
/// As [`save`].
pub fn save_for_recovery(document: &Document, kept: &Unknown, note: Value, path: &Path) -> Result<(), SessionError> {
    let in_text = |path: &Path| absolute(path).to_string_lossy().into_owned().into();
    let mut session = value(document, kept, in_text);
    session[AUTOSAVE_KEY] = note;
    write(session, path)
}

fn write(session: Value, path: &Path) -> Result<(), SessionError> {
    let text = format!("{session:#}\n");
    write_atomically(path, text.as_bytes()).map_err(|source| SessionError::Io {
        action: "write",
        path: path.into(),
        source,
    })
}

fn value(document: &Document, kept: &Unknown, text_of: impl Fn(&Path) -> PathBuf) -> Value {
    let mut session = Session::of(document);
    session.visit_paths(&mut |_, path| *path = text_of(path));
    let mut value = serde_json::to_value(session).expect("paths were made text");
    if let Value::Object(object) = &mut value {
        object.values_mut().for_each(shorten);
        object.insert(VERSION_KEY.into(), VERSION.into());
        kept.merge_into(object);
    }
    value
}

/// Writes 0.8 and not 0.800000011920929: the shortest text that is read as the same single-precision number.
fn shorten(value: &mut Value) {
    match value {
        Value::Object(object) => object.values_mut().for_each(shorten),
        Value::Array(array) => array.iter_mut().for_each(shorten),
        Value::Number(number) if number.is_f64() => {
            let Some(wide) = number.as_f64() else { return };
            let narrow = wide as f32;
            if f64::from(narrow) == wide
                && let Ok(short) = narrow.to_string().parse::<f64>()
            {
                *value = short.into();
            }
        }
        _ => {}
    }
}
