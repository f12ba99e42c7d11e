// Mirrors, last pass: what the rays show becomes a sample of the light that mirrors show. Twin of `Mirrors::shown` in
// render/src/shade/mirrors.rs. What mirrors show of points in mirrors is a part of the light of those.

@group(2) @binding(0) var mirror_weights: texture_2d<f32>;
// Light of all kinds of the surfaces that the rays meet.
@group(2) @binding(1) var mirrored_value: texture_2d<f32>;
@group(2) @binding(2) var mirrored_geometry: texture_2d<u32>;
// The first part of the light with the current sample.
@group(2) @binding(3) var environment_value: texture_2d<f32>;
@group(2) @binding(4) var environment_work: texture_2d<u32>;
// Light along the rays of wider lobes.
@group(2) @binding(5) var second_value: texture_2d<f32>;

@group(3) @binding(5) var environment_map: texture_2d<f32>;
@group(3) @binding(6) var mirrored_map: texture_2d<f32>;

fn written_at(at: vec2<u32>) -> Sums {
    let begun = begin(at * frame.stride);
    if !begun.has_surface {
        return without_surface(begun, vec3(0.0));
    }
    let weight = textureLoad(mirror_weights, at, 0);
    let is_catcher = (begun.g.w & FLAG_CATCHER) != 0u;
    if is_catcher {
        if weight.w == 0.0 || textureLoad(mirrored_geometry, at, 0).x == 0u {
            return with_sample(begun, vec4(0.0), NO_WORK);
        }
        let shown = textureLoad(mirrored_value, at, 0).xyz * weight.xyz;
        return over_ground(begun, shown, hidden_light(at, weight.xyz));
    }
    let point = begun_point(begun);
    let lobes = ray_lobes(point);
    let width = vec2(u32(max(widest_lobe(lobes.map), widest_lobe(lobes.scene)) * WIDTH_SCALE), 0u);
    var shown = textureLoad(second_value, at, 0).xyz;
    if weight.w != 0.0 && textureLoad(mirrored_geometry, at, 0).x == 0u {
        shown += light_of_map(lobes.map, point);
    } else if weight.w != 0.0 {
        shown += textureLoad(mirrored_value, at, 0).xyz * weight.xyz;
    }
    return with_sample(begun, vec4(shown, 0.0), width);
}

// Light of a ground that catches shadows that a reflection hides: of the environment, which is most.
fn hidden_light(at: vec2<u32>, weight: vec3<f32>) -> vec3<f32> {
    let samples = sample_count(textureLoad(environment_work, at, 0));
    return min(weight, vec3(1.0)) * textureLoad(environment_value, at, 0).xyz / f32(max(samples, 1u));
}

// A reflection in a ground that catches shadows. Twin of `Mirrors::over_ground`.
fn over_ground(begun: Begun, reflected: vec3<f32>, hidden: vec3<f32>) -> Sums {
    var sums = with_sample(begun, vec4(0.0), NO_WORK);
    if frame.lets_light_through == 0u {
        sums.value += vec4(reflected - hidden, 0.0);
        return sums;
    }
    // The sums have the light that comes through in all numbers: that of the ground is there already.
    let share = dot(hidden, vec3(1.0 / 3.0));
    sums.value += vec4(reflected - share, -share);
    return sums;
}

// Twin of `Mirror::of_map`.
fn light_of_map(mirror: Mirror, point: SurfacePoint) -> vec3<f32> {
    if frame.mirrored_height == 0u {
        return vec3(0.0);
    }
    return unshadowed_window(mirror, point) * mirror.share;
}
