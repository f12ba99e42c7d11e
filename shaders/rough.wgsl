// The albedo of a point. Twin of `albedo` in render/src/shade/painter.rs.

// Without the part that rays along sharp lobes give, of the environment or of surfaces. In mirrors wider lobes have no rays.
fn rough_albedo(point: SurfacePoint, of_surfaces: bool) -> vec3<f32> {
    let albedo = albedo_of(point.brdf);
    if !has_mirrors() {
        return albedo;
    }
    let lobes = ray_lobes(point);
    var none = lobes.map;
    none.share = 0.0;
    var mirrored = window_albedo(lobes.map, none, point);
    if of_surfaces && !is_in_mirrors() {
        mirrored += window_albedo(lobes.scene, lobes.map, point);
    }
    return max(albedo - mirrored, vec3(0.0));
}
