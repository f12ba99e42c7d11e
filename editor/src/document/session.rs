//! Session files: a document as versioned JSON, without its pictures and its dataset, which it names by path.
//!
//! `{"lapidary_session": 2, "scene", "dataset", "materials", "added", "assigned", "poses", "handling", "environment", "lights",
//! "components", "solution", "camera", "bookmarks", "looks", "view", "bake"}`; the lights are those of a lights file, and each of
//! the looks has a name and what it keeps: the keys of materials ("materials", "added", "assigned"), those of light
//! ("environment", "lights", "components", "solution"), "camera" and "view". Paths are relative to the file, angles in degrees.
//! Reading is lenient: invalid values are replaced with a warning, unknown keys are kept and written back
//! ([`Unknown`]), missing files are listed and can be searched for ([`LoadedSession::relink`]). Only a newer version or damaged
//! JSON is refused.

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
pub use file::{Session, SessionLight, SessionLook};
pub use lenient::{Unknown, read_leniently};
pub use read::{LoadedSession, load};
pub use write::save;

#[cfg(test)]
use read::MissingFile;

use file::{
    SessionAssignment, SessionCamera, SessionHandling, SessionMaterial, SessionMaterials, SessionPose, SessionSlot,
    TextureSource,
};

pub(super) use read::read_json;
pub(super) use write::save_for_recovery;

/// Extension of session files.
pub const EXTENSION: &str = "lapidary";

/// Written version, and the newest that is read.
///
/// In version 1, `ward` was today's `ward-duer`.
pub const VERSION: u64 = 2;

/// Key of an autosave's note about its document.
pub const AUTOSAVE_KEY: &str = "autosave";

/// Key of the version.
const VERSION_KEY: &str = "lapidary_session";

#[cfg(test)]
mod tests;
