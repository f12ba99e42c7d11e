//! Values that the shaders share with this side by name.

pub const MOST_PARAMETERS: usize = 32;
/// Directional lights that cast shadows.
pub const MOST_SUNS: usize = 8;
/// Areas that a kernel writes at a time, and sides of its groups in texels.
pub const MOST_AREAS: usize = 256;
pub const TILE_SIDE: u32 = 8;
/// Levels that a meshless basis may have.
pub const MOST_BASIS_LEVELS: usize = lapidary_core::meshless::MOST_LEVELS;
/// In place of a measured BRDF that is not there.
pub const NO_TABLE: u32 = u32::MAX;
pub const BACKGROUND_MAP: u32 = 0;
pub const BACKGROUND_FLAT: u32 = 1;
pub const TWO_SIDED: u32 = 1 << 31;
/// Most directions that a cut may be selected from on the device.
pub const MOST_DIRECTIONS: usize = 2048;
/// A vertex that moved, among those that get cuts.
pub const MOVED: u32 = 1 << 31;
/// What leaves send: the light of the last bounce, what they emit, or all that a picture shows of them.
pub const SENDS_LAST: u32 = 0;
pub const SENDS_EMISSION: u32 = 1;
pub const SENDS_ALL: u32 = 2;
/// States of a vertex whose light is made on the device.
pub const VERTEX_IS_OPEN: u32 = 1;
pub const VERTEX_IS_MOVED: u32 = 2;
pub const VERTEX_HAS_NEW_CUT: u32 = 4;
/// Planes of the texture of `posed.wgsl`.
pub const POSED_PLANES: u32 = 3;
pub const POSED_GROWTH: u32 = 0;
pub const POSED_BOUNCE: u32 = 1;
pub const POSED_UNCOVERED: u32 = 2;
pub const READS_SECOND_UVS: u32 = 1;
pub const READS_VERTEX_COLORS: u32 = 2;
pub const FIELD_NONE: u32 = 0;
pub const FIELD_ENVIRONMENT: u32 = 1;
pub const FIELD_SOURCES: u32 = 2;
pub const NO_MIRRORS: u32 = 0;
pub const MIRRORS_READ_MAP: u32 = 1;
pub const MIRRORS_HAVE_RAYS: u32 = 2;
pub const SEEN_WITH_MIRRORS: u32 = 1;
pub const SEEN_IN_MIRRORS: u32 = 2;
pub const EMISSION_POINT: u32 = 0;
pub const EMISSION_SPOT: u32 = 1;
pub const EMISSION_DIRECTIONAL: u32 = 2;
pub const EMISSION_RECTANGLE: u32 = 3;
/// First layer of a light that shines through everything.
pub const NO_SHADOW: u32 = u32::MAX;
/// Texels of a shadow map from a receiver to the farthest one that is read.
pub const KERNEL_RADIUS: u32 = 2;
pub const KIND_LINEAR: u32 = 1;
pub const KIND_SRGB: u32 = 2;
pub const KIND_FLOAT: u32 = 3;
pub const KIND_PROCEDURAL: u32 = 4;
/// Words in one row of the texture pool: within WebGPU's default limits.
pub const POOL_WIDTH_LOG2: u32 = 13;
