// Direct light of local lights.
//
// A rectangle is a grid of cells. Each cell has shadow maps around its center and RECTANGLE_DETAIL squared light samples, moved by
// the picture's jitter. A sample off center reads the map where its ray passes the blockers, whose distance is estimated first
// (after Fernando 2005). So shadows are as soft as with maps at all samples.
//
// Directional lights have rays of their own, see suns_pass.wgsl.

@group(2) @binding(3) var suns_seen: texture_2d<u32>;

const RECTANGLE_DETAIL: u32 = 2u;
// Radius of the search for blockers: a cell and a half finds blockers less than three times as far from the receiver as from the
// light.
const SEARCH_RADIUS: f32 = 1.5;

// Rays to suns that meet nothing, 16 bits each; and the offset of these rays in their cells.
var<private> open_suns: vec4<u32>;
var<private> sun_shift: vec2<f32>;

fn written_at(texel: vec2<u32>) -> Sums {
    let begun = begin(texel * frame.stride);
    if !begun.has_surface {
        return without_surface(begun, vec3(0.0));
    }
    open_suns = textureLoad(suns_seen, texel, 0);
    sun_shift = shift_of_rays(picture_pixel(begun.pixel));
    var point = begun_point(begun);
    // Twin of `SurfacePoint::within_cone`.
    point.slopes += vec3(point.by_cone, 0.0, point.by_cone);
    var received = vec3(0.0);
    for (var i = 0u; i < arrayLength(&local_lights); i++) {
        received += light_from(point, local_lights[i]);
    }
    return with_sample(begun, vec4(received, 0.0), NO_WORK);
}

// Radiance toward the eye that a point reflects of a light.
fn light_from(point: SurfacePoint, light: LocalLight) -> vec3<f32> {
    var sum = vec3(0.0);
    if light.emission == EMISSION_RECTANGLE {
        for (var cell = 0u; cell < light.grid * light.grid; cell++) {
            sum += light_from_cell(point, light, cell);
        }
        return sum;
    }
    if light.emission == EMISSION_DIRECTIONAL {
        return light_from_sun(point, light);
    }
    sum = reflected(point, sample_light(light, point.position, vec2(0.5)), 0.0);
    if casts_shadow(light) && any(sum > vec3(0.0)) {
        sum *= visibility_at(point.position, point.face_normal, light, 0u);
    }
    return sum;
}

fn casts_shadow(light: LocalLight) -> bool {
    return light.first_view != NO_SHADOW;
}

// Contribution of one cell of a rectangle.
fn light_from_cell(point: SurfacePoint, light: LocalLight, cell: u32) -> vec3<f32> {
    // No light arrives behind the rectangle.
    if !(dot(point.position - light.position, light.forward) > 0.0) {
        return vec3(0.0);
    }
    let steps = light.grid * RECTANGLE_DETAIL;
    let first = vec2(cell % light.grid, cell / light.grid) * RECTANGLE_DETAIL;
    var blocker = 0.0;
    var visibility = 1.0;
    if casts_shadow(light) {
        blocker = mean_blocker(point, light, cell);
        visibility = visibility_at(point.position, point.face_normal, light, cell);
    }
    var sum = vec3(0.0);
    for (var i = 0u; i < RECTANGLE_DETAIL * RECTANGLE_DETAIL; i++) {
        let step = first + vec2(i % RECTANGLE_DETAIL, i / RECTANGLE_DETAIL);
        let u = (vec2<f32>(step) + frame.pixel_offset) / f32(steps);
        let value = reflected(point, sample_light(light, point.position, u), 0.0);
        if blocker > 0.0 && any(value > vec3(0.0)) {
            let in_cell = u * f32(light.grid) - vec2<f32>(first / RECTANGLE_DETAIL);
            let past = seen_past(point, light, cell, offset_in_cell(light, in_cell - 0.5) * blocker);
            visibility = visibility_at(past, point.face_normal, light, cell);
        }
        sum += value * visibility;
    }
    return sum / f32(steps * steps);
}

// A vector in the plane of a rectangle, in widths and heights of a cell.
fn offset_in_cell(light: LocalLight, cells: vec2<f32>) -> vec3<f32> {
    return (light.half_width * cells.x + light.half_height * cells.y) * (2.0 / f32(light.grid));
}

// Distance from blockers to the receiver over the distance from the light to them, averaged over the surrounding blockers; 0
// without any.
fn mean_blocker(point: SurfacePoint, light: LocalLight, cell: u32) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let shift = offset_in_cell(light, SEARCH_RADIUS * vec2(f32(i % 3 - 1), f32(i / 3 - 1)));
        let at = seen_past(point, light, cell, shift);
        let blocker = shadow_blocker(view_toward(light, cell, at), at, point.face_normal);
        sum += blocker;
        count += select(0.0, 1.0, blocker > 0.0);
    }
    return sum / max(count, 1.0);
}

// Point of the receiver's plane seen from the center of a cell, toward the receiver minus `shift`.
fn seen_past(point: SurfacePoint, light: LocalLight, cell: u32, shift: vec3<f32>) -> vec3<f32> {
    let middle = shadow_views[light.first_view + cell * light.views_per_point].origin;
    let away = point.position - middle;
    let ratio = dot(point.face_normal, away) / dot(point.face_normal, away - shift);
    // Beyond its horizon the plane is invisible.
    if !(ratio > 0.25 && ratio < 4.0) {
        return point.position;
    }
    return middle + (away - shift) * ratio;
}

// Reflected radiance of a sample whose directions have this inverse concentration.
fn reflected(point: SurfacePoint, sample: LightSample, inv_kappa: f32) -> vec3<f32> {
    if !(dot(sample.direction, point.smooth_normal) > 0.0) {
        return vec3(0.0);
    }
    let wi = sample.direction * point.world_from_local;
    return brdf_cos(point.brdf, wi, point.wo, inv_kappa, point.slopes) * sample.irradiance;
}

// Of directional light, what arrives along the rays that meet nothing.
fn light_from_sun(point: SurfacePoint, light: LocalLight) -> vec3<f32> {
    let open = open_rays_to(light);
    if !is_disc(light) {
        let share = f32(countOneBits(open)) / f32(RAYS_OF_SUN);
        return reflected(point, sample_light(light, point.position, vec2(0.5)), 0.0) * share;
    }
    if !(disc_may_be_above(light, point.smooth_normal) && disc_may_be_above(light, point.world_from_local[2])) {
        return vec3(0.0);
    }
    // A cap has a mean resultant of one minus half its height; 1 / kappa tends to its difference from one.
    let inv_kappa = 0.5 * light.area / f32(RAYS_OF_SUN);
    var sum = vec3(0.0);
    for (var i = 0u; i < RAYS_OF_SUN; i++) {
        if (open >> i & 1u) != 0u {
            sum += reflected(point, sample_light(light, point.position, place_of_ray(i, sun_shift)), inv_kappa);
        }
    }
    return sum / f32(RAYS_OF_SUN);
}

fn open_rays_to(light: LocalLight) -> u32 {
    if !casts_shadow(light) {
        return ALL_RAYS;
    }
    return open_suns[light.first_view / 2u] >> (16u * (light.first_view % 2u)) & ALL_RAYS;
}

fn visibility_at(position: vec3<f32>, normal: vec3<f32>, light: LocalLight, cell: u32) -> f32 {
    return shadow_visibility(view_toward(light, cell, position), position, normal);
}

// The shadow map around one point of a light that contains the receiver.
fn view_toward(light: LocalLight, cell: u32, position: vec3<f32>) -> u32 {
    let first = light.first_view + cell * light.views_per_point;
    let away = position - shadow_views[first].origin;
    var best = first;
    var largest = dot(shadow_views[first].forward, away);
    for (var i = first + 1u; i < first + light.views_per_point; i++) {
        let along = dot(shadow_views[i].forward, away);
        if along > largest {
            largest = along;
            best = i;
        }
    }
    return best;
}
