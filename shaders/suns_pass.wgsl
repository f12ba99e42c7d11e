// Which rays to the suns meet nothing: 16 for each sun, at the points of a pass over local lights that lack the sample. Twin of
// `DirectShader::shares` in render/src/shade/direct.rs.

fn written_at(texel: vec2<u32>) -> vec4<u32> {
    let begun = begin(texel * frame.stride);
    if !begun.has_surface {
        return vec4(0u);
    }
    let direction = seen_along(begun.pixel);
    let start = ray_start(begun.g, -direction, suns.largest_offset);
    let normal = smooth_normal(triangles[begun.g.x - 1u].vertices, hit_of(begun.g), -direction);
    let pixel = picture_pixel(begun.pixel);
    let shift = shift_of_rays(pixel);
    var open = vec4(0u);
    for (var i = 0u; i < suns.count; i++) {
        // What no part of the sun is above receives none of it.
        if min(dot(suns.suns[i].axis, start.normal), dot(suns.suns[i].axis, normal)) > -suns.suns[i].sine {
            open[i / 2u] |= open_rays(suns.suns[i], start.origin, normal, shift, pixel) << (16u * (i % 2u));
        }
    }
    return open;
}
