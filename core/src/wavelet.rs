//! Wavelet radiance transport (Kontkanen, Turquin, Holzschuch and Sillion, *Wavelet Radiance Transport for Interactive
//! Indirect Lighting*, EGSR 2006), cited as "the wavelet paper".
//!
//! Incident radiance lies on quads ([`patch`]). A point of a quad and a direction of its hemisphere are each a point of a
//! unit square, so radiance is a function of two squares. Its basis is the product of Haar wavelets of both ([`square`],
//! 4.1). Light transport is a sparse matrix between such functions ([`operator`], 4.2 and 4.3), and all bounces are the
//! Neumann series of that matrix ([`series`], 4.4).

pub mod haar;
pub mod operator;
pub mod patch;
pub mod series;
pub mod square;
