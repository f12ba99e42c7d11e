//! The mathematics and the data of Lapidary: scenes, BRDFs, light trees, cuts and the `.cuts` dataset.
//!
//! The method is from Cheslack-Postava, Wang, Akerlund and Pellacini, *Fast, Realistic Lighting and Material Design
//! using Nonlinear Cut Approximation* (SIGGRAPH Asia 2008), cited as "the paper" throughout. This crate is independent
//! of GPU, window and formats of other programs, which are in `interchange`. `precompute` and `render` both build on it
//! and are independent of each other.
//!
//! # Conventions
//!
//! * Right-handed coordinates, Y up, meters. Radians inside, degrees at every interface.
//! * Scene-linear Rec. 709 RGB in `f32`; environment texels are radiance (W m⁻² sr⁻¹, arbitrary scale).
//! * Transforms are named `world_from_object`. Directions point away from the surface: `wi` to the
//!   light, `wo` to the eye.
//! * Latitude-longitude maps: the center of the image is +Z, its left quarter +X, its top +Y.
//!   A rotation is counter-clockwise seen from +Y and turns the environment, not the camera.
//! * A BRDF value never holds the cosine unless its name says so (`brdf_cos`).
//! * Everything random is seeded from (scene, vertex or pixel), never from time or thread.
//!
//! # Modules
//!
//! The scene:
//! * [`mesh`]: triangles; [`scene`]: a mesh with materials, cameras and lights; [`bounds`]: axis-aligned boxes
//! * [`camera`]: view and projection; [`shot`]: the pictures that a bake is for
//! * [`material`]: parameters and maps; [`texture`]: images of the maps
//! * [`lights`]: local lights and their file; [`environment`]: distant light, maps and skies
//! * [`animation`]: clips, skins and morph targets from files, which pose a baked scene
//! * [`image`]: linear RGB pictures
//!
//! The papers:
//! * [`brdf`]: eight directions at a time, and the lobe filtered by the spread of a node
//! * [`light_tree`]: the tree over the samples of distant light (Eq. 10 to 12), and the radiance of its nodes
//! * [`cut`]: merging (3.2), selection for visibility and for solid angles (Eq. 5), illumination cuts, 16-bit packing
//! * [`sources`]: surface samples as lights (4.1), their tree, its radiance, and sources near a receiver
//! * [`transport`]: one bounce of light, and the series over bounces
//! * [`meshless`]: the meshless hierarchical basis and its light transport
//! * [`implicit`]: light of moving scenes by implicit visibility
//! * [`wavelet`]: wavelet radiance transport between quads
//! * [`surfel`]: points of any kind of surface; [`mesh_surface`]: those of a mesh; [`ray`]: visibility
//! * [`dataset`]: the `.cuts` file, with the settings and the report of its bake
//!
//! Tools: [`sphere`] (directions), [`simd`] (eight vectors at a time), [`sparse`] (matrices of weights), [`color`]
//! (luminance, sRGB), [`input`] (safe reading of files), [`output`] (checked and atomic writing), [`lock`] (one writer
//! at a time), [`memory`] (free memory).

pub mod animation;
pub mod bounds;
pub mod brdf;
pub mod camera;
pub mod color;
pub mod cut;
pub mod dataset;
pub mod environment;
pub mod gather_table;
pub mod ground;
pub mod image;
pub mod implicit;
pub mod input;
pub mod light_tree;
pub mod lights;
pub mod lock;
pub mod material;
pub mod memory;
pub mod mesh;
pub mod mesh_surface;
pub mod meshless;
pub mod names;
pub mod offset;
pub mod opacity;
pub mod output;
pub mod parts;
pub mod ray;
pub mod scene;
pub mod shot;
pub mod simd;
pub mod sources;
pub mod sparse;
pub mod sphere;
pub mod surfel;
#[cfg(any(test, feature = "test-scenes"))]
pub mod test_files;
#[cfg(any(test, feature = "test-scenes"))]
pub mod test_scenes;
pub mod texture;
pub mod threads;
pub mod transport;
pub mod wavelet;
