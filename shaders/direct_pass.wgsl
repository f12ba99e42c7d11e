// Direct light of local lights.
//
// A rectangle is a grid of cells. Each cell has shadow maps around its center and RECTANGLE_DETAIL squared light samples, moved by
// the picture's jitter. A sample off center reads the map where its ray passes the blockers, whose distance is estimated first
// (after Fernando 2005). So shadows are as soft as with maps at all samples.
//
// A disc of directions has DISC_STEPS squared samples and one shadow map from its center. A sample off center reads the map where
// its ray passes the blockers.

const RECTANGLE_DETAIL: u32 = 2u;
// As on the CPU.
const DISC_STEPS: u32 = 4u;
// Steps to each side in the search for blockers of a disc.
const DISC_SEARCH: i32 = 2;
// Radius of the search for blockers: a cell and a half finds blockers less than three times as far from the receiver as from the
// light.
const SEARCH_RADIUS: f32 = 1.5;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Sums {
    let begun = begin(vec2<u32>(position.xy) * frame.stride);
    if !begun.has_surface {
        return without_surface(begun, vec3(0.0));
    }
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
    if is_disc(light) {
        return light_from_disc(point, light);
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

fn light_from_disc(point: SurfacePoint, light: LocalLight) -> vec3<f32> {
    if !(disc_may_be_above(light, point.smooth_normal) && disc_may_be_above(light, point.world_from_local[2])) {
        return vec3(0.0);
    }
    let samples = DISC_STEPS * DISC_STEPS;
    // A cap has a mean resultant of one minus half its height; 1 / kappa tends to its difference from one.
    let inv_kappa = 0.5 * light.area / f32(samples);
    var gap = 0.0;
    var visibility = 1.0;
    if casts_shadow(light) {
        gap = mean_gap(point, light);
        visibility = visibility_at(point.position, point.face_normal, light, 0u);
    }
    var sum = vec3(0.0);
    for (var i = 0u; i < samples; i++) {
        let u = (vec2<f32>(vec2(i % DISC_STEPS, i / DISC_STEPS)) + frame.pixel_offset) / f32(DISC_STEPS);
        let sample = sample_light(light, point.position, u);
        let value = reflected(point, sample, inv_kappa);
        if gap > 0.0 && any(value > vec3(0.0)) {
            let at = passing(point, light, (sample.direction + light.forward) * gap);
            visibility = visibility_at(at, point.face_normal, light, 0u);
        }
        sum += value * visibility;
    }
    return sum / f32(samples);
}

// Mean distance in meters along parallel light from surrounding blockers to the receiver; 0 without any. Blockers lie in the cone
// of the disc, up to where it leaves the scene.
fn mean_gap(point: SurfacePoint, light: LocalLight) -> f32 {
    let view = shadow_views[light.first_view];
    let way = dot(view.forward, point.position - view.origin);
    let radius = way * disc_sine(light) / f32(DISC_SEARCH);
    var sum = 0.0;
    var count = 0.0;
    for (var y = -DISC_SEARCH; y <= DISC_SEARCH; y++) {
        for (var x = -DISC_SEARCH; x <= DISC_SEARCH; x++) {
            let shift = (light.half_width * f32(x) + light.half_height * f32(y)) * radius;
            let gap = shadow_gap(light.first_view, passing(point, light, shift), point.face_normal);
            sum += gap;
            count += select(0.0, 1.0, gap > 0.0);
        }
    }
    return sum / max(count, 1.0);
}

// The point of the receiver's plane hit by parallel light that passes the receiver at distance `shift`.
fn passing(point: SurfacePoint, light: LocalLight, shift: vec3<f32>) -> vec3<f32> {
    let n = point.face_normal;
    let along = dot(n, shift) / dot(n, light.forward);
    let at = point.position + shift - light.forward * along;
    // In grazing light the surface's plane reaches farther than the surface.
    return select(point.position, at, abs(along) < 4.0 * length(shift));
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
