//! What two requests differ in, and so what must be done again.

use super::RenderRequest;
use lapidary_render::Baked;

/// The least that must be done again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Changes {
    /// Nothing.
    Nothing,
    /// The picture is displayed again.
    Post,
    /// The picture is rendered again, after whatever is out of date of
    /// - the scene,
    /// - the appearance: the light that the sources send on,
    /// - the environment: its cut, and its light on the sources,
    /// - the local lights: theirs on the sources,
    /// - the solution of bounced light: what the sources receive beyond the first bounce.
    ///
    /// The components in the picture redo nothing before it.
    Picture,
}

/// What `new` changes in a renderer that was last asked for `old`.
pub fn changes(old: Option<&RenderRequest>, new: &RenderRequest) -> Changes {
    let Some(old) = old else { return Changes::Picture };
    let same_picture = same_dataset(old.baked.as_ref(), new.baked.as_ref())
        && old.appearance_revision == new.appearance_revision
        && old.look.same_but_for_surfaces(&new.look);
    match (same_picture, old.look.post == new.look.post) {
        (false, _) => Changes::Picture,
        (true, false) => Changes::Post,
        (true, true) => Changes::Nothing,
    }
}

/// Whether both are one dataset, or none.
pub fn same_dataset(a: Option<&Baked>, b: Option<&Baked>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.is_same(b),
        (a, b) => a.is_none() && b.is_none(),
    }
}
