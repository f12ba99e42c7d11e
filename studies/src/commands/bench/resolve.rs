//! `lapidary bench FILE.cuts --resolve OBJECT`: times until bounced light is solved, and solved anew after an object moved.

use super::{
    JsonArgs,
    drag::{dragged, object_named},
};
use crate::{
    args::ViewedScene,
    bounces::resolve::{Resolve, measured},
};
use anyhow::Result;

/// Moves an object by half its width and back, `moves` times in all. Prints the figures.
///
/// # Errors
/// A missing object, or a dataset without bases of objects.
pub fn run(viewed: &ViewedScene, object: &str, moves: u32, json: &JsonArgs) -> Result<()> {
    let baked = &viewed.baked;
    let index = object_named(&baked.dataset.scene, object)?;
    let look = viewed.look()?;
    let there = dragged(&baked.dataset.scene, index, &look, 1).pop().expect("a drag has a last step").poses;
    let figures = measured(baked, &look, object, &there, moves)?;
    json.tell(&figures, || text(&figures))
}

fn text(figures: &Resolve) -> String {
    let Resolve { object, functions, bounces, table_bytes, moves, rays, rays_traced_again: again, .. } = figures;
    let Resolve { whole_milliseconds: whole, whole_first_bounce_milliseconds: whole_first, .. } = figures;
    let Resolve { after_a_move_milliseconds: after, first_bounce_milliseconds: first, .. } = figures;
    format!(
        "{functions} functions, {bounces} bounces, rays {:.0} MB: all in {whole:.0} ms, the first bounce in {whole_first:.0} ms\n\
         \"{object}\" moved {moves} times: all anew in {after:.0} ms, the first bounce in {first:.0} ms; \
         {again} of {rays} rays traced again ({:.1} %)\n",
        *table_bytes as f64 / 1e6,
        100.0 * *again as f64 / (*rays).max(1) as f64
    )
}
