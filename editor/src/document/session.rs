//! Session files: a document as versioned JSON, without its pictures and its dataset, which it names by path.
//!
//! `{"lapidary_session": 2, "scene", "dataset", "materials", "added", "assigned", "environment", "lights", "components", "solution", "camera",
//! "bookmarks", "view", "bake"}`; the lights are those of a lights file.
//! Paths are relative to the file, angles in degrees. A reader takes what it can: values that cannot be are replaced
//! with a warning, keys that it does not know are kept and written back ([`Unknown`]), files that are not there are
//! listed and can be looked for ([`LoadedSession::relink`]). Only a newer version or damaged JSON is refused.

mod brdfs;
mod checks;
mod error;
mod file;
mod lenient;
mod read;
mod relink;
mod resolve;
mod write;

pub use error::SessionError;
pub use file::Session;
pub use lenient::{Unknown, read_leniently};
pub use read::{LoadedSession, load};
pub use write::save;

#[cfg(test)]
use read::MissingFile;

use file::{SessionAssignment, SessionCamera, SessionMaterial, SessionPose, SessionSlot, TextureSource};

pub(super) use read::read_json;
pub(super) use write::save_for_recovery;

/// Extension of session files.
pub const EXTENSION: &str = "lapidary";

/// Version that is written, and the newest that is read.
///
/// In version 1 `ward` was the model that is `ward-duer` now.
pub const VERSION: u64 = 2;

/// Key of the note in an autosave that says what it is of.
pub const AUTOSAVE_KEY: &str = "autosave";

/// Key of the version.
const VERSION_KEY: &str = "lapidary_session";

#[cfg(test)]
mod tests;
