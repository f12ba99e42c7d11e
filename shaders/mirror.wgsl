// Sharp lobes read the environment's map itself. Twin of render/src/shade/mirror.rs, which describes the method, and of
// core/src/environment/pyramid.rs. A pass declares `mirrored_map`, an atlas of all levels. Texture levels would not do: software
// adapters read one level for neighboring pixels.

const SHARP: f32 = 3.0;
const SOFT: f32 = 5.0;
const WINDOW: f32 = 6.0;
const OF_LOBE: f32 = 3.0;
const OF_CONE: f32 = 24.0;
const MIRROR_SAMPLES: u32 = 8u;
const FILLED: f32 = 2.5;
const CORRELATED_LOW: f32 = 0.1;
const CORRELATED_HIGH: f32 = 0.3;
// Cosine and sine of the golden section of a full turn.
const GOLDEN_COS: f32 = -0.7373688;
const GOLDEN_SIN: f32 = -0.67549026;
const RINGS_A_TURN: f32 = 64.0;
// Where the samples of a lobe begin on its disc: cosine and sine of the first angle, and the place in rings of equal area.
const MIDDLE: vec3<f32> = vec3<f32>(1.0, 0.0, 0.5);

// The sharp lobes of one pixel.
struct Mirror {
    // Share of the window's light that is replaced; 0 for none.
    share: f32,
    // Widths of the sampled lobes, the first `count`: the sharp ones, and one that fills the window.
    lobes: mat4x2<f32>,
    count: u32,
    // Inverse squares of the window's half-axes, in slopes of half vectors.
    axes: vec2<f32>,
    // Largest angle in radians from the mirror direction to the window's rim.
    reach: f32,
}

// 1 below `low`, 0 above `high`, smooth between.
fn falling(x: f32, low: f32, high: f32) -> f32 {
    let t = clamp((high - x) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Mirror for the lobes of a point.
fn mirror_at_point(point: SurfacePoint) -> Mirror {
    return mirror_among(point, sqrt(frame.leaf_solid_angle / PI));
}

// The same among light samples of a radius in radians; among sources, which are wider, with a radius of 0.
fn mirror_among(point: SurfacePoint, sample_radius: f32) -> Mirror {
    let lobes = lobes_of(point.brdf);
    let slopes = point.slopes;
    let wo = point.wo;
    let least = vec2(MIN_ALPHA);
    var mirror = Mirror(0.0, mat4x2(least, least, least, least), 0u, vec2(0.0), 0.0);
    var widest = vec2(0.0);
    for (var i = 0u; i < 3u; i += 1u) {
        let lobe = sqrt(lobes[i] * lobes[i] + slopes.xz);
        let narrow = min(lobe.x, lobe.y);
        var sharpness = falling(narrow, SCENE_SHARP, SCENE_SOFT);
        if sample_radius > 0.0 {
            sharpness = falling(narrow / sample_radius, SHARP, SOFT);
        }
        sharpness *= falling(abs(slopes.y) / max(lobe.x * lobe.y, 1e-12), CORRELATED_LOW, CORRELATED_HIGH);
        if any(lobes[i] != NO_LOBE) && sharpness > 0.0 {
            mirror.lobes[mirror.count] = max(lobe, least);
            mirror.count += 1u;
            mirror.share = max(mirror.share, sharpness);
            widest = max(widest, lobe);
        }
    }
    let added = sample_radius / max(wo.z, 0.1);
    let half_axes = sqrt(OF_LOBE * OF_LOBE * widest * widest + WINDOW * WINDOW * 0.125 * added * added);
    mirror.lobes[mirror.count] = min(half_axes / FILLED, vec2(1.0));
    mirror.count += 1u;
    mirror.reach = 2.0 * atan(max(half_axes.x, half_axes.y));
    mirror.axes = 1.0 / (half_axes * half_axes);
    if !(wo.z > 0.0) {
        mirror.share = 0.0;
    }
    return mirror;
}

// The lobes of a point that have rays where mirrors show the scene. Twin of `RayLobes` in render/src/shade/mirror/rays.rs.
struct RayLobes {
    // Those that are sharp among light samples.
    map: Mirror,
    // Those that are sharp among sources; a share of 0 if all are of the first.
    scene: Mirror,
}

const SCENE_SHARP: f32 = 0.15;
const SCENE_SOFT: f32 = 0.25;

fn ray_lobes(point: SurfacePoint) -> RayLobes {
    var both = RayLobes(mirror_at_point(point), mirror_among(point, 0.0));
    if both.map.share >= 1.0 && both.map.count == both.scene.count {
        both.scene.share = 0.0;
    }
    return both;
}

// Width of the widest sharp lobe. Twin of `Mirror::width`.
fn widest_lobe(mirror: Mirror) -> f32 {
    var widest = 0.0;
    if !(mirror.share > 0.0) {
        return widest;
    }
    for (var i = 0u; i + 1u < mirror.count; i += 1u) {
        widest = max(widest, max(mirror.lobes[i].x, mirror.lobes[i].y));
    }
    return widest;
}

// Share of the light of surfaces from a local direction that a window gives.
fn window_share(mirror: Mirror, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    if !(mirror.share > 0.0) {
        return 0.0;
    }
    return mirror.share * mirror_window(mirror, wi, wo);
}

// Window weight of a local direction: 1 around the mirror direction, 0 outside.
fn mirror_window(mirror: Mirror, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let half = wi + wo;
    let distance = dot(half.xy * half.xy, mirror.axes) / max(half.z * half.z, 1e-6);
    let t = clamp((1.0 - distance) * (4.0 / 3.0), 0.0, 1.0);
    return t * t * (3.0 - t - t);
}

// Spread of a light for widening lobes: zero except well inside the window. A widened lobe has bright tails, which would add light
// outside the window.
fn mirror_spread(mirror: Mirror, window: f32, inv_kappa: f32) -> f32 {
    let squared = window * window;
    let fourth = squared * squared;
    return inv_kappa * (1.0 - (1.0 - fourth * fourth) * mirror.share);
}

// Whether a cone of `radius` reaches into the window, from the cosine of its angle to the mirror direction.
fn reaches_window(mirror: Mirror, to_mirrored: f32, radius: f32) -> bool {
    let angle = min(mirror.reach + radius, PI);
    let sq = angle * angle;
    // Taylor's polynomial of degree 6 lies below the cosine.
    return to_mirrored > 1.0 - sq * (0.5 - sq * (1.0 / 24.0 - sq * (1.0 / 720.0)));
}

// Unoccluded light of the window.
fn unshadowed_window(mirror: Mirror, point: SurfacePoint) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var i = 0u; i < MIRROR_SAMPLES * mirror.count; i += 1u) {
        let ray = window_ray(mirror, point, i, MIDDLE);
        if any(ray.weight > vec3(0.0)) {
            sum += ray.weight * patch_radiance(ray.direction, ray.solid_angle + OF_CONE * point.by_cone);
        }
    }
    return sum;
}

// The part of the albedo that belongs to a window and not to another. Twin of `Fan::total`.
fn window_albedo(mirror: Mirror, other: Mirror, point: SurfacePoint) -> vec3<f32> {
    if !(mirror.share > 0.0) {
        return vec3(0.0);
    }
    var sum = vec3(0.0);
    for (var i = 0u; i < MIRROR_SAMPLES * mirror.count; i += 1u) {
        sum += beside(window_ray(mirror, point, i, MIDDLE), mirror, other, point).weight;
    }
    return sum;
}

// A direction with what a window's share leaves beside another.
fn beside(ray: WindowRay, mirror: Mirror, other: Mirror, point: SurfacePoint) -> WindowRay {
    let wi = ray.direction * point.world_from_local;
    let window = mirror_window(mirror, wi, point.wo);
    let left = max(mirror.share * window - window_share(other, wi, point.wo), 0.0);
    return WindowRay(ray.direction, ray.weight * (left / max(window, 1e-20)), ray.solid_angle);
}

// A direction of the window in world space, with BRDF times cosine, window and solid angle; zero below the horizons.
struct WindowRay {
    direction: vec3<f32>,
    weight: vec3<f32>,
    solid_angle: f32,
}

// One of the window's sampled directions.
fn window_ray(mirror: Mirror, point: SurfacePoint, index: u32, first: vec3<f32>) -> WindowRay {
    let wo = point.wo;
    let step = index / mirror.count;
    var turn = first.xy;
    for (var i = 0u; i < step; i += 1u) {
        turn = vec2(turn.x * GOLDEN_COS - turn.y * GOLDEN_SIN, turn.x * GOLDEN_SIN + turn.y * GOLDEN_COS);
    }
    let disc = sqrt((f32(step) + first.z) / f32(MIRROR_SAMPLES)) * turn;
    let half = ggx_visible_normal(mirror.lobes[index % mirror.count], wo, disc);
    let wi = 2.0 * dot(wo, half) * half - wo;
    let direction = point.world_from_local * wi;
    if !(wi.z > 0.0 && dot(direction, point.smooth_normal) > 0.0) {
        return WindowRay(direction, vec3(0.0), 0.0);
    }
    var density = 0.0;
    for (var k = 0u; k < mirror.count; k += 1u) {
        density += ggx_density(mirror.lobes[k], wi, wo);
    }
    let solid_angle = 1.0 / (f32(MIRROR_SAMPLES) * max(density, 1e-6));
    let reflected = reflection_of(point.brdf, Light(wi, 0.0, point.slopes, wi.z, true), wo);
    return WindowRay(direction, reflected * (mirror_window(mirror, wi, wo) * solid_angle), solid_angle);
}

// Mean radiance of the map over a patch of about this solid angle around a world direction.
fn patch_radiance(direction: vec3<f32>, solid_angle: f32) -> vec3<f32> {
    let size = vec2(textureDimensions(mirrored_map).x, frame.mirrored_height);
    let texels = sqrt(solid_angle) * f32(size.y) / PI;
    let last = firstLeadingBit(min(size.x, size.y));
    let fine = min(firstLeadingBit(u32(max(texels, 1.0))), last);
    let rest = clamp(texels / f32(1u << fine) - 1.0, 0.0, 1.0);
    let uv = uv_from_direction(to_environment(direction));
    let finer = level_radiance(uv, size, fine);
    let coarser = level_radiance(uv, size, min(fine + 1u, last));
    return mix(finer, coarser, rest) * frame.environment_intensity;
}

fn level_radiance(uv: vec2<f32>, finest: vec2<u32>, level: u32) -> vec3<f32> {
    let size = vec2<i32>(finest >> vec2(level));
    var place = vec2(0);
    if level > 0u {
        place = vec2<i32>(vec2(finest.x - (finest.x >> (level - 1u)), finest.y));
    }
    let p = uv * vec2<f32>(size) - 0.5;
    let base = floor(p);
    let f = p - base;
    let x0 = (i32(base.x) + size.x) % size.x;
    let x1 = (x0 + 1) % size.x;
    let y0 = max(i32(base.y), 0);
    let y1 = min(i32(base.y) + 1, size.y - 1);
    let top = mix(mirrored_texel(place + vec2(x0, y0)), mirrored_texel(place + vec2(x1, y0)), f.x);
    let bottom = mix(mirrored_texel(place + vec2(x0, y1)), mirrored_texel(place + vec2(x1, y1)), f.x);
    return mix(top, bottom, f.y);
}

fn mirrored_texel(place: vec2<i32>) -> vec3<f32> {
    return textureLoad(mirrored_map, place, 0).xyz;
}

// A point's light with the window's light replaced.
fn sharpened(mirror: Mirror, reflected: vec3<f32>, seen: vec3<f32>, all: vec3<f32>, unshadowed: vec3<f32>) -> vec3<f32> {
    let shares = select(vec3(0.0), min(seen / max(all, vec3(1e-38)), vec3(1.0)), all > vec3(0.0));
    return reflected + (shares * unshadowed - seen) * mirror.share;
}

// A visible normal of a GGX lobe, from a point of the unit disc. Twin of core/src/brdf/ggx_lobe.rs, like the code below.
fn ggx_visible_normal(alpha: vec2<f32>, wo: vec3<f32>, disc: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3(alpha * wo.xy, wo.z));
    var t1 = vec3(-stretched.y, stretched.x, 0.0);
    if stretched.z < 0.9999 {
        t1 = normalize(t1);
    } else {
        let a = -1.0 / (1.0 + stretched.z);
        t1 = vec3(1.0 + stretched.x * stretched.x * a, stretched.x * stretched.y * a, -stretched.x);
    }
    let t2 = cross(stretched, t1);
    let s = 0.5 * (1.0 + stretched.z);
    let p1 = disc.x;
    let p2 = (1.0 - s) * sqrt(max(1.0 - p1 * p1, 0.0)) + s * disc.y;
    let n = t1 * p1 + t2 * p2 + stretched * sqrt(max(1.0 - p1 * p1 - p2 * p2, 0.0));
    return normalize(vec3(alpha * n.xy, max(n.z, 1e-6)));
}

// Density of the light direction when half vectors are visible normals.
fn ggx_density(alpha: vec2<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let h = normalize(wi + wo);
    let squared = alpha * alpha;
    let e = dot(h.xy * h.xy, 1.0 / squared) + h.z * h.z;
    let d = FRAC_1_PI / (alpha.x * alpha.y * e * e);
    let root = sqrt(wo.z * wo.z + dot(squared, wo.xy * wo.xy));
    return select(0.0, d / (2.0 * (wo.z + root)), h.z > 0.0);
}
