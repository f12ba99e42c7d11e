// Radiometry of local lights. Twin of core/src/lights/sample.rs.

struct LocalLight {
    position: vec3<f32>,
    // See EMISSION_*.
    emission: u32,
    // Unit direction from position to target.
    forward: vec3<f32>,
    // The light's first shadow map, for directional lights their number among those with rays; or NO_SHADOW.
    first_view: u32,
    // W/sr, W/m2 for parallel light, W/(m2 sr) for rectangles.
    intensity: vec3<f32>,
    // Shadow maps around each of its points.
    views_per_point: u32,
    // Rectangle: from the center to the middle of an edge, and to the middle of the next. Disc: two unit vectors across.
    half_width: vec3<f32>,
    // Cosines of the angles from a spot's axis to its edge and to the start of its falloff.
    cos_edge: f32,
    half_height: vec3<f32>,
    cos_full: f32,
    // Area of a rectangle in m2; for the disc of a directional light one minus the cosine from center to rim, or 0 without a disc.
    area: f32,
    // A rectangle has shadow maps at grid x grid points.
    grid: u32,
    padding: vec2<u32>,
}

const EMISSION_POINT: u32 = 0u;
const EMISSION_SPOT: u32 = 1u;
const EMISSION_DIRECTIONAL: u32 = 2u;
const EMISSION_RECTANGLE: u32 = 3u;
const NO_SHADOW: u32 = 0xffffffffu;

@group(2) @binding(1) var<storage, read> local_lights: array<LocalLight>;

// Light at a point from one direction.
struct LightSample {
    // Unit direction from the point to the light.
    direction: vec3<f32>,
    // Irradiance on a surface that faces the light, without blockers.
    irradiance: vec3<f32>,
}

// `u` in the unit square selects a point of a rectangle or a disc.
fn sample_light(light: LocalLight, point: vec3<f32>, u: vec2<f32>) -> LightSample {
    if is_disc(light) {
        return sample_disc(light, u);
    }
    if light.emission == EMISSION_DIRECTIONAL {
        return LightSample(-light.forward, light.intensity);
    }
    var toward = light.position - point;
    if light.emission == EMISSION_RECTANGLE {
        toward += light.half_width * (2.0 * u.x - 1.0) + light.half_height * (2.0 * u.y - 1.0);
    }
    let distance_sq = dot(toward, toward);
    if !(distance_sq > 1e-30) {
        return LightSample(vec3(0.0, 1.0, 0.0), vec3(0.0));
    }
    let direction = toward / sqrt(distance_sq);
    return LightSample(direction, light.intensity * (light_factor(light, direction) / distance_sq));
}

// Whether a light is a disc of directions. Twin of core/src/lights/disc.rs.
fn is_disc(light: LocalLight) -> bool {
    return light.emission == EMISSION_DIRECTIONAL && light.area > 0.0;
}

// Whether any part of a disc may be above a plane with this normal.
fn disc_may_be_above(light: LocalLight, normal: vec3<f32>) -> bool {
    return -dot(light.forward, normal) > -disc_sine(light);
}

// Sine of the angle from center to rim.
fn disc_sine(light: LocalLight) -> f32 {
    return sqrt(light.area * (2.0 - light.area));
}

fn sample_disc(light: LocalLight, u: vec2<f32>) -> LightSample {
    let direction = direction_in(-light.forward, light.half_width, light.half_height, light.area, u);
    return LightSample(direction, light.intensity * (2.0 / (2.0 - light.area)));
}

// Factor on the intensity toward a receiver in this direction.
fn light_factor(light: LocalLight, direction: vec3<f32>) -> f32 {
    let cos = -dot(direction, light.forward);
    switch light.emission {
        case EMISSION_SPOT: { return spot_factor(light, cos); }
        case EMISSION_RECTANGLE: { return light.area * max(cos, 0.0); }
        default: { return 1.0; }
    }
}

fn spot_factor(light: LocalLight, cos: f32) -> f32 {
    if !(cos >= light.cos_edge) {
        return 0.0;
    }
    if cos >= light.cos_full {
        return 1.0;
    }
    let t = (cos - light.cos_edge) / (light.cos_full - light.cos_edge);
    return t * t * (3.0 - 2.0 * t);
}
