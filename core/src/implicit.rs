//! Global illumination of moving scenes by implicit visibility.
//!
//! The method is from Dong, Kautz, Theobalt and Seidel, *Interactive Global Illumination Using Implicit Visibility* (Pacific
//! Graphics 2007), cited here as "implicit visibility". Surface elements in quadtrees see each other in bins of directions. Each
//! bin keeps the nearest, so no ray is cast. Everything is computed anew in each frame, so objects may move and deform.
//!
//! * [`Bins`]: the nodes seen by leaves, by a walk per leaf; layers of objects are merged by taking the nearer node
//! * [`Views`]: the nodes in the bins, with holes closed
//! * [`Drag`]: bins while one object moves
//! * [`LeafLight`]: light of the sky and of emitters, bounce by bounce
//! * [`VertexWeights`]: values of leaves at the vertices of a mesh
//! * [`bins`], [`links`] and [`refine`]: the link structure of the paper, the oracle of the walk; [`all_pairs`]: their reference
//!
//! The trees are [`crate::implicit::disc_forest::DiscForest`], over surfels by [`crate::implicit::forest::SurfelForest`].

pub mod all_pairs;
pub mod bins;
mod direct;
pub mod disc_forest;
mod drag;
pub mod forest;
mod gather;
mod layout;
pub mod links;
pub mod refine;
mod room;
mod vertices;
mod views;

pub use direct::{Bins, CONSTANTS, DistanceCodes, EMPTY, WHOLE_CONSTANTS, node_of};
pub use drag::Drag;
pub use gather::{LeafLight, Lighting, Sky};
pub use layout::BinLayout;
pub use room::room_of_grids;
pub use vertices::{Receiver, VertexWeights};
pub use views::Views;

#[cfg(test)]
mod tests;
