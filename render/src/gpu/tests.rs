//! Shaders against naga, layouts against shaders, and the GPU against the CPU on the same buffers.

mod bindings;
mod bounce;
mod compiling;
mod direct;
mod emission;
mod ground;
mod inexact;
mod kept;
mod meshless;
mod mirrors;
mod opacity;
mod paths;
mod posed;
mod reflection;
mod sketch;
mod textures;
mod turned;
mod twin;
mod wavelet;
