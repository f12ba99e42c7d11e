// Deferred pass 2: barycentric weights, and the frame after bump and normal map. Twin of render/src/shade/surface.rs.

@group(2) @binding(0) var triangle_ids: texture_2d<u32>;

struct Surface {
    @location(0) geometry: vec4<u32>,
    @location(1) rotation: vec4<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Surface {
    let pixel = vec2<u32>(position.xy);
    let id = textureLoad(triangle_ids, pixel, 0).x;
    if id == 0u {
        return Surface(vec4(0u), vec4(0.0, 0.0, 0.0, 1.0));
    }
    let direction = ray_direction(pixel);
    let triangle = triangles[id - 1u];
    let corners = triangle.vertices;
    let hit = hit_triangle(id - 1u, direction);
    let smoothed = smooth_normal(corners, hit, -direction);
    let tangent = interpolated_tangent(corners, hit.barycentric);
    let handedness = vertices[corners.x].handedness * hit.side;
    let uv = interpolated_uv(corners, hit.barycentric);
    let material = triangle.material & ~TWO_SIDED;
    // A ground that catches shadows is flat and diffuse.
    let catches = id > frame.catcher;
    var bumped = smoothed;
    if !catches {
        bumped = bumped_normal(material, corners, uv, frame_around(smoothed, tangent, handedness));
    }
    // The rotation alone; the mirroring is a flag.
    let rotation = frame_around(facing(bumped, -direction), tangent, 1.0);
    var flags = select(0u, FLAG_CATCHER, catches);
    flags |= select(0u, FLAG_BACK, hit.side < 0.0);
    flags |= select(0u, FLAG_MIRRORED, handedness < 0.0);
    flags |= select(0u, FLAG_BLACK, hit.side < 0.0 && (triangle.material & TWO_SIDED) == 0u);
    let b = bitcast<vec2<u32>>(hit.barycentric.yz);
    return Surface(vec4(id, b, flags), quaternion_from_rotation(rotation));
}

// The normal after normal map and bump map.
fn bumped_normal(material: u32, corners: vec3<u32>, uv: vec2<f32>, smoothed: mat3x3<f32>) -> vec3<f32> {
    var normal = smoothed[2];
    let normal_map = materials[material].normal_map;
    if normal_map.kind != 0u {
        let s = normal_map.strength;
        let n = (2.0 * sample_slot(normal_map, uv).xyz - 1.0) * vec3(s, s * materials[material].normal_y, 1.0);
        normal = normalize_or(smoothed * n, normal);
    }
    let bump_map = materials[material].bump_map;
    let slopes = surface_slopes(corners);
    if bump_map.kind != 0u && slopes.is_regular {
        let d = height_slopes(bump_map, uv);
        // The gradient along the surface tilts the normal of the raised surface against it (Blinn 1978).
        normal = normalize_or(normal - slopes.per_u * d.x - slopes.per_v * d.y, normal);
    }
    return normal;
}

struct Slopes {
    per_u: vec3<f32>,
    per_v: vec3<f32>,
    is_regular: bool,
}

// Gradients of u and v along a triangle: the surface gradient of a function is per_u df/du + per_v df/dv.
fn surface_slopes(corners: vec3<u32>) -> Slopes {
    let p = vertices[corners.x].position;
    let e1 = vertices[corners.y].position - p;
    let e2 = vertices[corners.z].position - p;
    let d1 = vertices[corners.y].uv - vertices[corners.x].uv;
    let d2 = vertices[corners.z].uv - vertices[corners.x].uv;
    let n = cross(e1, e2);
    let area_sq = dot(n, n);
    // Gradients of the barycentric weights of the second and third corner.
    let gb = cross(e2, n) / area_sq;
    let gc = cross(n, e1) / area_sq;
    return Slopes(gb * d1.x + gc * d2.x, gb * d1.y + gc * d2.y, area_sq > 0.0);
}

// Change of height in metres per unit of u and v, by central differences over one texel.
fn height_slopes(slot: TextureSlot, uv: vec2<f32>) -> vec2<f32> {
    let step = 1.0 / max(abs(vec2(f32(slot.width), f32(slot.height)) * slot.scale), vec2(1e-6));
    return slot.strength * vec2(
        (height(slot, uv + vec2(step.x, 0.0)) - height(slot, uv - vec2(step.x, 0.0))) / (2.0 * step.x),
        (height(slot, uv + vec2(0.0, step.y)) - height(slot, uv - vec2(0.0, step.y))) / (2.0 * step.y),
    );
}

fn height(slot: TextureSlot, uv: vec2<f32>) -> f32 {
    return sample_slot(slot, uv)[slot.channel];
}
