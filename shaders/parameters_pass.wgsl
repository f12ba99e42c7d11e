// Deferred pass 3: base color and roughness for the views that show them; for other views the spread of the slopes within the
// sample. For a ground that catches shadows, its reflectance.

@group(2) @binding(0) var geometry: texture_2d<u32>;
@group(2) @binding(1) var environment_map: texture_2d<f32>;
// Directions along which mirrors see their points.
@group(2) @binding(2) var mirror_rays: texture_2d<f32>;

fn written_at(pixel: vec2<u32>) -> vec4<f32> {
    let g = textureLoad(geometry, pixel, 0);
    if g.x == 0u {
        return vec4(0.0);
    }
    if (g.w & FLAG_CATCHER) != 0u {
        return vec4(caught_radiance(seen_along(pixel)) * frame.caught_per_radiance, 1.0);
    }
    let triangle = triangles[g.x - 1u];
    let material = triangle.material & ~TWO_SIDED;
    let hit = hit_of(g);
    if shows_color() {
        let reads = materials[material].reads;
        return color_and_roughness(material, attributes_at(triangle.vertices, hit.barycentric, reads));
    }
    let has_bumps = materials[material].normal_map.kind != 0u || materials[material].bump_map.kind != 0u;
    if !has_bumps {
        return vec4(0.0);
    }
    return vec4(spread_at(triangle.vertices, hit, material, -seen_along(pixel)), 0.0);
}

// Twice the covariance of the slopes in the local frame.
fn spread_at(corners: vec3<u32>, hit: Hit, material: u32, wo: vec3<f32>) -> vec3<f32> {
    let smoothed = smooth_normal(corners, hit, wo);
    let tangent = interpolated_tangent(corners, hit.barycentric);
    let handedness = vertices[corners.x].handedness * hit.side;
    let bumped = bumped_normal(material, corners, hit.barycentric, frame_around(smoothed, tangent, handedness));
    return slope_spread(bumped, frame_around(facing(bumped.normal, wo), tangent, handedness));
}
