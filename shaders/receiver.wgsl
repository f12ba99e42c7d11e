// How a surface receives lights with an extent: the mean of their clamped cosine in closed form. Twin of core/src/brdf/lights.rs
// and of ReceiverX8 in render/src/shade/surface.rs.

// Mean of a von Mises-Fisher lobe's component along its axis, and mean square of one across it.
fn lobe_moments(inv_kappa: f32) -> vec2<f32> {
    let s = inv_kappa;
    let guess = (1.0 + s) / (1.0 + 2.0 * s + 3.0 * s * s);
    let guess_sq = guess * guess;
    let residual = s * guess * (3.0 - guess_sq) - 1.0 + guess_sq;
    let resultant = guess - residual / (3.0 * s * (1.0 - guess_sq) + 2.0 * guess);
    return vec2(resultant, resultant * s);
}

// Mean and half width of the cosines to a normal that has `cosine` to the lobe's axis.
fn cosines(moments: vec2<f32>, cosine: f32) -> vec2<f32> {
    let mean = moments.x * cosine;
    let mean_sq = cosine * cosine * (1.0 - 2.0 * moments.y) + (1.0 - cosine * cosine) * moments.y;
    return vec2(mean, sqrt(3.0 * max(mean_sq - mean * mean, 0.0)));
}

fn mean_above_horizon(c: vec2<f32>) -> f32 {
    return 0.5 * min(max(c.x + c.y, 0.0), 2.0 * c.y) + max(c.x - c.y, 0.0);
}

fn share_above_horizon(c: vec2<f32>) -> f32 {
    return clamp((c.x + c.y) / max(2.0 * c.y, 1e-6), 0.0, 1.0);
}

// Whether any material has a map that bends shading normals.
override BENT: bool = true;

// A light as received by the surface, above the horizons of both normals.
fn received_light(point: SurfacePoint, direction: vec3<f32>, wi: vec3<f32>, inv_kappa: f32) -> Light {
    let moments = lobe_moments(inv_kappa);
    let shading = cosines(moments, wi.z);
    var light = Light(wi, inv_kappa, point.slopes, mean_above_horizon(shading), wi.z > 0.0);
    if BENT && point.is_bent {
        let to_smooth = dot(direction, point.smooth_normal);
        let seen = share_above_horizon(cosines(moments, to_smooth));
        let share = min(share_above_horizon(shading) / max(seen, 1e-6), 1.0);
        light.cosine = select(0.0, light.cosine * share, seen > 0.0);
        light.is_above = light.is_above && to_smooth > 0.0;
    }
    return light;
}
