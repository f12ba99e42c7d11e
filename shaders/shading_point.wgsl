// A point to shade, from the output of the deferred passes: the first inputs of the shading passes.

@group(3) @binding(0) var geometry: texture_2d<u32>;
@group(3) @binding(1) var rotation: texture_2d<f32>;
// See parameters_pass.wgsl.
@group(3) @binding(2) var color_roughness: texture_2d<f32>;
// The sums of the current part of the light.
@group(3) @binding(3) var previous_value: texture_2d<f32>;
@group(3) @binding(4) var previous_work: texture_2d<u32>;
// Directions along which mirrors see their points, and the growth of the rays' cones.
@group(3) @binding(7) var mirror_rays: texture_2d<f32>;

fn previous_sums(pixel: vec2<u32>) -> Sums {
    return Sums(textureLoad(previous_value, pixel, 0), textureLoad(previous_work, pixel, 0));
}

// Whether a pixel lacks the sample that is rendered. Others stay as they are.
fn lacks_sample(sums: Sums) -> bool {
    return sample_count(sums.work) == frame.sample;
}

// A pixel of a pass that adds a sample to the sums of a part of the light.
struct Begun {
    pixel: vec2<u32>,
    sums: Sums,
    // The visible surface, see geometry.wgsl.
    g: vec4<u32>,
    // Whether it already has the sample: its sums stay unchanged.
    is_done: bool,
    // Whether there is a surface to shade.
    has_surface: bool,
}

// Begins the current sample.
fn begin(pixel: vec2<u32>) -> Begun {
    let sums = previous_sums(pixel);
    if !lacks_sample(sums) {
        return Begun(pixel, sums, vec4(0u), true, false);
    }
    let g = textureLoad(geometry, pixel, 0);
    return Begun(pixel, sums, g, false, is_surface(g));
}

// Ends a pixel without a surface to shade; adds a value if the sample is missing.
fn without_surface(begun: Begun, value: vec3<f32>) -> Sums {
    if begun.is_done {
        return begun.sums;
    }
    return with_sample(begun, vec4(value, 0.0), NO_WORK);
}

fn begun_point(begun: Begun) -> SurfacePoint {
    return surface_point(begun.g, begun.pixel, seen_along(begun.pixel));
}

// Merged nodes and BRDF evaluations of passes that do not count them.
const NO_WORK: vec2<u32> = vec2<u32>(0u, 0u);

// The sums with one more sample. For a ground in a picture with an alpha channel, all four numbers hold its transmitted share of
// light.
fn with_sample(begun: Begun, value: vec4<f32>, work: vec2<u32>) -> Sums {
    let covered = select(0u, 1u, begun.g.x != 0u);
    let surface = select(0u, 1u, begun.has_surface);
    let counts = vec2(1u | (surface << 16u), covered | (surface << 16u));
    var added = value;
    if frame.lets_light_through != 0u && (begun.g.w & FLAG_CATCHER) != 0u {
        added = vec4(dot(value.xyz, frame.share_weights));
    }
    return Sums(begun.sums.value + added, begun.sums.work + vec4(work, counts));
}

// Whether there is a surface to shade.
fn is_surface(g: vec4<u32>) -> bool {
    return g.x != 0u && (g.w & FLAG_BLACK) == 0u;
}

// Twin of SurfacePoint in render/src/shade/surface.rs.
struct SurfacePoint {
    vertices: vec3<u32>,
    weights: vec3<f32>,
    position: vec3<f32>,
    // Normal of the triangle, on the visible side.
    face_normal: vec3<f32>,
    // Interpolated normal before bump and normal map; the surface receives no light from below it.
    smooth_normal: vec3<f32>,
    // Whether a map bends the shading normal away from it.
    is_bent: bool,
    world_from_local: mat3x3<f32>,
    wo: vec3<f32>,
    brdf: Brdf,
    // Emitted radiance.
    emission: vec3<f32>,
    // Twice the covariance of the slopes within the sample in the local frame: xx, xy, yy.
    slopes: vec3<f32>,
    // The same along each axis by the cone of a mirror's ray. It blurs the map and lamps, and makes no lobe less sharp.
    by_cone: f32,
}

fn surface_point(g: vec4<u32>, pixel: vec2<u32>, direction: vec3<f32>) -> SurfacePoint {
    let triangle = triangles[g.x - 1u];
    let corners = triangle.vertices;
    let hit = hit_of(g);
    let a = vertices[corners.x].position;
    let across = cross(vertices[corners.y].position - a, vertices[corners.z].position - a);
    let local = world_from_local(textureLoad(rotation, pixel, 0), g.w);
    let smoothed = smooth_normal(corners, hit, -direction);
    let position = interpolated_position(corners, hit.barycentric);
    var slopes = vec3(0.0);
    var by_cone = 0.0;
    var brdf: Brdf;
    var emission = vec3(0.0);
    if (g.w & FLAG_CATCHER) != 0u {
        brdf = diffuse_brdf(textureLoad(color_roughness, pixel, 0).xyz);
    } else {
        let material = triangle.material & ~TWO_SIDED;
        let attributes = attributes_at(corners, hit.barycentric, materials[material].reads);
        brdf = brdf_of(material, attributes);
        if HAS_EMISSION {
            emission = material_emission(material, attributes);
        }
        slopes = select(textureLoad(color_roughness, pixel, 0).xyz, vec3(0.0), shows_color());
        if is_in_mirrors() {
            by_cone = slopes_of_cone(cone_at(g, pixel, position), curvature_of(corners, g.w));
        }
    }
    return SurfacePoint(
        corners,
        valid_weights(corners, hit.barycentric),
        position,
        normalize_or(across * hit.side, -direction),
        smoothed,
        (g.w & FLAG_BENT) != 0u,
        local,
        -direction * local,
        brdf,
        emission,
        slopes,
        by_cone,
    );
}
