// What deferred passes write of a surface: barycentric weights, and the frame after bump and normal map. Twin of
// render/src/shade/surface.rs.

struct Surface {
    @location(0) geometry: vec4<u32>,
    @location(1) rotation: vec4<f32>,
}

const NO_SURFACE: Surface = Surface(vec4<u32>(0u), vec4<f32>(0.0, 0.0, 0.0, 1.0));

// The surface at a hit of the triangle with this number plus one, seen along a direction.
fn surface_seen(id: u32, hit: Hit, direction: vec3<f32>) -> Surface {
    let triangle = triangles[id - 1u];
    let corners = triangle.vertices;
    let smoothed = smooth_normal(corners, hit, -direction);
    let tangent = interpolated_tangent(corners, hit.barycentric);
    let handedness = vertices[corners.x].handedness * hit.side;
    let material = triangle.material & ~TWO_SIDED;
    // A ground that catches shadows is flat and diffuse.
    let catches = id > frame.catcher;
    var bumped = smoothed;
    if !catches {
        bumped = bumped_normal(material, corners, hit.barycentric, frame_around(smoothed, tangent, handedness)).normal;
    }
    // The rotation alone; the mirroring is a flag.
    let rotation = frame_around(facing(bumped, -direction), tangent, 1.0);
    var flags = select(0u, FLAG_CATCHER, catches);
    flags |= select(0u, FLAG_BACK, hit.side < 0.0);
    flags |= select(0u, FLAG_BENT, any(bumped != smoothed));
    flags |= select(0u, FLAG_MIRRORED, handedness < 0.0);
    flags |= select(0u, FLAG_BLACK, hit.side < 0.0 && (triangle.material & TWO_SIDED) == 0u);
    let b = bitcast<vec2<u32>>(hit.barycentric.yz);
    return Surface(vec4(id, b, flags), quaternion_from_rotation(rotation));
}
