// Direct light of local lights, added to what the samples before have added up to; the merge adds to that.
//
// A rectangle is a grid of cells, each with shadow maps around its middle and RECTANGLE_DETAIL squared samples of light,
// which the jitter of the picture moves.

@group(3) @binding(0) var geometry: texture_2d<u32>;
@group(3) @binding(1) var rotation: texture_2d<f32>;
@group(3) @binding(2) var color_roughness: texture_2d<f32>;
@group(3) @binding(3) var others: texture_2d<f32>;
@group(3) @binding(4) var previous_sum: texture_2d<f32>;

const RECTANGLE_DETAIL: u32 = 2u;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let sum = textureLoad(previous_sum, pixel, 0);
    let g = textureLoad(geometry, pixel, 0);
    if g.x == 0u || (g.w & FLAG_BLACK) != 0u {
        return sum;
    }
    let point = receiving_point(g, pixel, ray_direction(pixel));
    var received = vec3(0.0);
    for (var i = 0u; i < arrayLength(&local_lights); i++) {
        received += light_from(point, local_lights[i]);
    }
    return sum + vec4(received, 0.0);
}

struct ReceivingPoint {
    position: vec3<f32>,
    // Of the triangle, on the side that is seen.
    face_normal: vec3<f32>,
    // Interpolated, before bump and normal map: no light from below it is received.
    smooth_normal: vec3<f32>,
    world_from_local: mat3x3<f32>,
    wo: vec3<f32>,
    brdf: Brdf,
}

fn receiving_point(g: vec4<u32>, pixel: vec2<u32>, direction: vec3<f32>) -> ReceivingPoint {
    let corners = triangles[g.x - 1u].vertices;
    let bc = bitcast<vec2<f32>>(g.yz);
    let hit = Hit(vec3(1.0 - bc.x - bc.y, bc), select(1.0, -1.0, (g.w & FLAG_BACK) != 0u));
    let a = vertices[corners.x].position;
    let b = vertices[corners.y].position;
    let c = vertices[corners.z].position;
    let local = world_from_local(textureLoad(rotation, pixel, 0), g.w);
    let p = textureLoad(color_roughness, pixel, 0);
    let q = textureLoad(others, pixel, 0);
    return ReceivingPoint(
        a * hit.barycentric.x + b * hit.barycentric.y + c * hit.barycentric.z,
        normalize_or(cross(b - a, c - a) * hit.side, -direction),
        smooth_normal(corners, hit, -direction),
        local,
        -direction * local,
        brdf_from_parameters(g.w & MODEL_MASK, p, q),
    );
}

// What a point reflects of a light toward the eye.
fn light_from(point: ReceivingPoint, light: LocalLight) -> vec3<f32> {
    if light.emission != EMISSION_RECTANGLE {
        return unblocked(point, light, reflected(point, sample_light(light, point.position, vec2(0.5))), 0u);
    }
    var sum = vec3(0.0);
    for (var cell = 0u; cell < light.grid * light.grid; cell++) {
        sum += unblocked(point, light, reflected_of_cell(point, light, cell), cell);
    }
    return sum;
}

// Share of a cell of a rectangle, if nothing is between.
fn reflected_of_cell(point: ReceivingPoint, light: LocalLight, cell: u32) -> vec3<f32> {
    let steps = light.grid * RECTANGLE_DETAIL;
    let first = vec2(cell % light.grid, cell / light.grid) * RECTANGLE_DETAIL;
    var sum = vec3(0.0);
    for (var i = 0u; i < RECTANGLE_DETAIL * RECTANGLE_DETAIL; i++) {
        let step = first + vec2(i % RECTANGLE_DETAIL, i / RECTANGLE_DETAIL);
        let u = (vec2<f32>(step) + frame.pixel_offset) / f32(steps);
        sum += reflected(point, sample_light(light, point.position, u));
    }
    return sum / f32(steps * steps);
}

fn reflected(point: ReceivingPoint, sample: LightSample) -> vec3<f32> {
    if !(dot(sample.direction, point.smooth_normal) > 0.0) {
        return vec3(0.0);
    }
    return brdf_cos(point.brdf, sample.direction * point.world_from_local, point.wo, 0.0) * sample.irradiance;
}

// `value` as far as the shadow maps of a cell let it pass; they are not asked where there is no light.
fn unblocked(point: ReceivingPoint, light: LocalLight, value: vec3<f32>, cell: u32) -> vec3<f32> {
    if light.first_view == NO_SHADOW || !any(value > vec3(0.0)) {
        return value;
    }
    let view = view_toward(light, cell, point.position);
    return value * shadow_visibility(view, point.position, point.face_normal);
}

// The shadow map, of those around one point of a light, that looks at a receiver.
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
