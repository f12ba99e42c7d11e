// The direction along which the point of a pixel is seen. A pass declares `mirror_rays`, the directions along which mirrors see theirs.

fn seen_along(pixel: vec2<u32>) -> vec3<f32> {
    if is_in_mirrors() {
        return textureLoad(mirror_rays, pixel, 0).xyz;
    }
    return ray(pixel).direction;
}
