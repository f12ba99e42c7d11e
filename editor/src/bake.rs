//! The bake: begun, followed and shown, with its panel. The driver itself is in [`lapidary_studies::jobs::bake`].

mod begin;
mod follow;
mod ground;
mod kept;
pub mod panel;
mod stale;
mod state;

pub use begin::wants_draft;
pub use stale::stale_now;
pub use state::{Asker, BakeOrder, Baking, From};
