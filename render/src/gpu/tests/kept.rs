//! What edits leave of a picture, as on the CPU: see [`crate::lit_scene::edits`].

use super::twin::{another, backend};
use crate::lit_scene::edits;

/// Share of samples at edges by which the rasterizer differs from rays.
const EDGES: f64 = 0.02;

#[test]
fn edits_shade_what_they_change() {
    let Some(_one) = backend() else { return };
    edits::edits_shade_what_they_change(another, EDGES);
}

#[test]
fn unfinished_pictures_go_on() {
    let Some(_one) = backend() else { return };
    edits::unfinished_pictures_go_on(another);
}

#[test]
fn unseen_changes_do_not_creep() {
    let Some(_one) = backend() else { return };
    edits::unseen_changes_do_not_creep(another);
}

#[test]
fn assigned_materials_look_as_those_of_the_mesh() {
    let Some(_one) = backend() else { return };
    edits::assigned_materials_look_as_those_of_the_mesh(another, EDGES);
}
