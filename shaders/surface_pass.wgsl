// Deferred pass 2: barycentric weights, and the frame after bump and normal map. Twin of render/src/shade/surface.rs.

@group(2) @binding(0) var triangle_ids: texture_2d<u32>;

fn written_at(pixel: vec2<u32>) -> Surface {
    let id = textureLoad(triangle_ids, pixel, 0).x;
    if id == 0u {
        return NO_SURFACE;
    }
    let direction = ray(pixel).direction;
    return surface_seen(id, hit_triangle(id - 1u, direction), direction);
}
