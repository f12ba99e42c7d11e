// Mirrors: light along the rays of wider lobes, which show surfaces alone. Twin of `Mirrors::by_second_ray` in
// render/src/shade/mirrors.rs.

@group(2) @binding(0) var mirror_weights: texture_2d<f32>;
// Light of all kinds of the surfaces that the rays meet.
@group(2) @binding(1) var mirrored_value: texture_2d<f32>;
@group(2) @binding(2) var mirrored_geometry: texture_2d<u32>;

fn written_at(at: vec2<u32>) -> vec4<f32> {
    if textureLoad(mirrored_geometry, at, 0).x == 0u {
        return vec4(0.0);
    }
    let light = textureLoad(mirrored_value, at, 0).xyz;
    let share = share_up_to(frame.brightest, luminance(light));
    return vec4(light * share * textureLoad(mirror_weights, at, 0).xyz, 0.0);
}
