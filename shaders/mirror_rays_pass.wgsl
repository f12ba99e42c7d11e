// Mirrors, pass 1: a ray for each pixel with sharp lobes that lacks the sample, drawn from these lobes. Twin of `Mirror::ray` in
// render/src/shade/mirror.rs. A sketch writes the pixels of a lattice densely. Points that mirrors show have rays, too.

// Whether the rays are those of wider lobes, which show surfaces alone.
override IS_SECOND: bool = false;

@group(3) @binding(5) var environment_map: texture_2d<f32>;
@group(3) @binding(6) var mirrored_map: texture_2d<f32>;

struct MirrorRay {
    // Direction in world space; and how much the ray's cone grows per meter, or 0 without a ray.
    @location(0) direction: vec4<f32>,
    // Weight of the radiance along it; and the width of the cone where it begins, or 0.
    @location(1) weight: vec4<f32>,
}

const NO_RAY: MirrorRay = MirrorRay(vec4<f32>(0.0), vec4<f32>(0.0));

const LUMINANCE: vec3<f32> = vec3<f32>(0.2126, 0.7152, 0.0722);
const TAU: f32 = 6.2831855;

fn written_at(texel: vec2<u32>) -> MirrorRay {
    let begun = begin(texel * frame.stride);
    if !begun.has_surface {
        return NO_RAY;
    }
    let point = own_point(begun);
    let lobes = ray_lobes(point);
    var shift = ray_shift(picture_pixel(begun.pixel), frame.picture_sample);
    if is_in_mirrors() {
        shift = fract(shift + OF_NEXT);
    }
    var none = lobes.map;
    none.share = 0.0;
    let cone = cone_at(begun.g, begun.pixel, point.position);
    let curvature = curvature_of(point.vertices, begun.g.w);
    let is_catcher = (begun.g.w & FLAG_CATCHER) != 0u;
    if is_catcher && (IS_SECOND || is_in_mirrors()) {
        return NO_RAY;
    }
    if IS_SECOND {
        let widest = max(widest_lobe(lobes.map), widest_lobe(lobes.scene));
        let ray = drawn_ray(lobes.scene, lobes.map, point, fract(shift + OF_SECOND));
        return with_cone(ray, cone, mirrored_spread(cone, curvature, widest));
    }
    let ray = drawn_ray(lobes.map, none, point, shift);
    return with_cone(ray, cone, mirrored_spread(cone, curvature, widest_lobe(lobes.map)));
}

// See render/src/shade/mirrors.rs.
const OF_NEXT: vec2<f32> = vec2<f32>(0.618034, 0.381966);
const OF_SECOND: vec2<f32> = vec2<f32>(0.381966, 0.618034);
// A cone that is no wider would seem to be no ray.
const LEAST_CONE: f32 = 1e-12;

// A ray with the width of its cone where it begins, and its growth.
fn with_cone(ray: MirrorRay, cone: RayCone, spread: f32) -> MirrorRay {
    if ray.direction.w == 0.0 {
        return NO_RAY;
    }
    let grown = select(spread, LEAST_CONE, abs(spread) < LEAST_CONE);
    return MirrorRay(vec4(ray.direction.xyz, grown), vec4(ray.weight.xyz, max(cone.width, LEAST_CONE)));
}

// The point, of a ground that catches shadows with its own material.
fn own_point(begun: Begun) -> SurfacePoint {
    let is_catcher = (begun.g.w & FLAG_CATCHER) != 0u;
    let g = vec4(begun.g.xyz, begun.g.w & ~FLAG_CATCHER);
    var point = surface_point(g, begun.pixel, seen_along(begun.pixel));
    if is_catcher {
        point.slopes = vec3(0.0);
    }
    return point;
}

fn drawn_ray(mirror: Mirror, other: Mirror, point: SurfacePoint, shift: vec2<f32>) -> MirrorRay {
    if !(mirror.share > 0.0) {
        return NO_RAY;
    }
    let first = vec3(cos(TAU * shift.x), sin(TAU * shift.x), fract(RINGS_A_TURN * shift.x));
    let count = MIRROR_SAMPLES * mirror.count;
    var total = 0.0;
    for (var i = 0u; i < count; i += 1u) {
        let drawn = beside(window_ray(mirror, point, by_lobes(mirror, i), first), mirror, other, point);
        total += dot(drawn.weight, LUMINANCE);
    }
    var left = shift.y * total;
    for (var i = 0u; i < count; i += 1u) {
        let drawn = beside(window_ray(mirror, point, by_lobes(mirror, i), first), mirror, other, point);
        let luminance = dot(drawn.weight, LUMINANCE);
        left -= luminance;
        if luminance > 0.0 && left < 0.0 {
            return MirrorRay(vec4(drawn.direction, 1.0), vec4(drawn.weight * (total / luminance), 1.0));
        }
    }
    return NO_RAY;
}

// Lobe by lobe: evenly spread numbers then choose each lobe as often as its share says.
fn by_lobes(mirror: Mirror, index: u32) -> u32 {
    return index % MIRROR_SAMPLES * mirror.count + index / MIRROR_SAMPLES;
}
