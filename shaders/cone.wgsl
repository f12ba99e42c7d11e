// The part of a picture that a ray of a mirror stands for, as a cone. Twin of render/src/shade/mirrors/cone.rs.
//
// A pass declares `mirror_rays`: the direction of each ray, and how much its cone grows per meter, which is not 0 where there is a ray.
// The width where it meets a surface is among the flags of that surface, negative behind a focus.

struct RayCone {
    // Width in meters.
    width: f32,
    // Growth of the width per meter; negative behind a mirror that gathers light.
    spread: f32,
}

// Twice the variance of evenly spread numbers is the square of their range divided by this.
const OF_EVEN: f32 = 6.0;
// Most that a cone adds to a lobe: that of alpha 0.5.
const WIDEST_CONE: f32 = 0.25;

// Twice the variance of the half vectors of one reflected direction within a cone, as slopes.
fn slopes_of_cone(cone: RayCone, curvature: f32) -> f32 {
    let slope = slope_of_cone(cone, curvature);
    return min(slope * slope / OF_EVEN, WIDEST_CONE);
}

fn slope_of_cone(cone: RayCone, curvature: f32) -> f32 {
    return 0.5 * cone.spread + curvature * cone.width;
}

// Growth of the width of a cone that a mirror with a lobe of this width reflects.
fn mirrored_spread(cone: RayCone, curvature: f32, lobe: f32) -> f32 {
    let spread = 2.0 * slope_of_cone(cone, curvature);
    let by_lobe = 2.0 * lobe * sqrt(OF_EVEN * frame.of_lobe);
    return spread + select(by_lobe, -by_lobe, spread < 0.0);
}

// Mean curvature of the shading normals along the edges of a surface's triangle, per meter: positive where they spread.
fn curvature_of(corners: vec3<u32>, flags: u32) -> f32 {
    let sums = bend_along(corners.xy) + bend_along(corners.yz) + bend_along(corners.zx);
    return select(sums.x, -sums.x, (flags & FLAG_BACK) != 0u) / (sums.y + 1.1754944e-38);
}

// Turn of the normals along an edge, times its length; and the square of that.
fn bend_along(ends: vec2<u32>) -> vec2<f32> {
    let edge = vertices[ends.y].position - vertices[ends.x].position;
    return vec2(dot(vertices[ends.y].normal - vertices[ends.x].normal, edge), dot(edge, edge));
}

// The cone of the ray that meets the point of a pixel.
fn cone_at(g: vec4<u32>, pixel: vec2<u32>, position: vec3<f32>) -> RayCone {
    if !is_in_mirrors() {
        let spread = pixel_span(1.0) * frame.sample_distance;
        return RayCone(spread * distance(frame.eye, position), spread);
    }
    let width = bitcast<f32>(g.w & WIDTH_BITS);
    return RayCone(abs(width), textureLoad(mirror_rays, pixel, 0).w * select(1.0, -1.0, width < 0.0));
}
