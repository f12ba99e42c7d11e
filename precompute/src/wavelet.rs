//! Wavelet transport between quads, computed once for a scene (wavelet paper, section 4).

mod form_factor;
mod oracle;
mod refine;

pub use refine::{TransportSettings, direct_transport};
