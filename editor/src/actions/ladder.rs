//! Requests about the ladder of cut sizes.

use lapidary_studies::ladder::Cuts;

/// A request about the ladder of cut sizes.
#[derive(Clone, Debug)]
pub enum LadderAction {
    /// Try sizes of the illumination cut on the picture, against a reference.
    Start,
    /// What pictures merge from now on.
    UseCuts(Cuts),
}
