// Uniforms of every pass: camera, picture and switches.

struct FrameUniforms {
    clip_from_world: mat4x4<f32>,
    // Right, up and backward axes of the camera.
    world_from_view: mat3x3<f32>,
    eye: vec3<f32>,
    tan_half_fov: f32,
    // Position of the sample in its pixel from the top left.
    pixel_offset: vec2<f32>,
    size: vec2<u32>,
    background_color: vec3<f32>,
    background: u32,
    // Sine and cosine of the environment's rotation.
    environment_turn: vec2<f32>,
    environment_intensity: f32,
    leaf_solid_angle: f32,
    tree_height: u32,
    view_mode: u32,
    wireframe: u32,
    source_tree_height: u32,
    // Number of the current sample; for points that mirrors show, of the part of their light.
    sample: u32,
    // First triangle of a ground that catches shadows; a number above all triangles without such a ground.
    catcher: u32,
    // Pixels per texel of the shading passes, in columns and rows: 1, or the stride of a lattice.
    stride: vec2<u32>,
    // What the ground catches: the map or uniform radiance.
    caught_color: vec3<f32>,
    caught: u32,
    // The ground's reflectance for a radiance of 1 behind it.
    caught_per_radiance: vec3<f32>,
    // Whether the picture has an alpha channel, for which the ground stores its transmitted share.
    lets_light_through: u32,
    // Channel weights in that share.
    share_weights: vec3<f32>,
    // Height of the finest level of the map for sharp lobes; 0 for none.
    mirrored_height: u32,
    // Whether surface emission is shown.
    shows_emission: u32,
    // Spacing of a pixel's samples, in pixels; 0 for lookups in maps at points.
    sample_distance: f32,
    // What the points to shade are, see SEEN_*.
    seen: u32,
    // Most light of a surface that rays of wider lobes show, as a luminance.
    brightest: f32,
    // Number of the picture's sample.
    picture_sample: u32,
    // Share of a lobe for which a sample's ray stands.
    of_lobe: f32,
    // Pixels of the picture per pixel of points that mirrors show.
    picture_stride: vec2<u32>,
    // Where the optical axis meets the picture, in pixels.
    center: vec2<f32>,
    padding: vec2<u32>,
}

// Points whose mirrors show the scene along rays; those of others show the environment's map.
const SEEN_WITH_MIRRORS: u32 = 1u;
// Points that mirrors show; others are what the camera sees.
const SEEN_IN_MIRRORS: u32 = 2u;

fn is_in_mirrors() -> bool {
    return (frame.seen & SEEN_IN_MIRRORS) != 0u;
}

// The picture's pixel of a point.
fn picture_pixel(pixel: vec2<u32>) -> vec2<u32> {
    return select(pixel, pixel * frame.picture_stride, is_in_mirrors());
}

fn has_mirrors() -> bool {
    return (frame.seen & SEEN_WITH_MIRRORS) != 0u;
}

const BACKGROUND_MAP: u32 = 0u;
const BACKGROUND_FLAT: u32 = 1u;

const VIEW_SHADED: u32 = 0u;
const VIEW_NORMALS: u32 = 1u;
const VIEW_ALBEDO: u32 = 2u;
const VIEW_ROUGHNESS: u32 = 3u;
const VIEW_VISIBILITY_CUT: u32 = 4u;
const VIEW_MERGED_CUT: u32 = 5u;
const VIEW_BRDF_EVALUATIONS: u32 = 6u;
const VIEW_BASIS_LEVEL: u32 = 7u;
const VIEW_BASIS_FUNCTION: u32 = 8u;
const VIEW_BASIS_COEFFICIENTS: u32 = 9u;
const VIEW_GLOSS: u32 = 10u;

// Whether the view shows surface colors and roughness.
fn shows_color() -> bool {
    return frame.view_mode == VIEW_ALBEDO || frame.view_mode == VIEW_ROUGHNESS;
}

@group(0) @binding(0) var<uniform> frame: FrameUniforms;
