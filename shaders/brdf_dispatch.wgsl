// Combines a scene's models into one type, and dispatches to them. A line that begins with `//=` is replaced by lines for each
// model: see render/src/device/models.rs.

// Any of the models.
struct Brdf {
    model: u32,
//= members
}

// The BRDF of a material.
fn brdf_of(material: u32, at: SurfaceAttributes) -> Brdf {
    var brdf: Brdf;
    brdf.model = materials[material].model;
    switch brdf.model {
//= makes
        default: {}
    }
    return brdf;
}

fn diffuse_brdf(reflectance: vec3<f32>) -> Brdf {
    var brdf: Brdf;
    brdf.model = MODEL_LAMBERT;
    brdf.lambert = Lambert(reflectance);
    return brdf;
}

// f_r times the cosine for a light.
fn reflection_of(brdf: Brdf, light: Light, wo: vec3<f32>) -> vec3<f32> {
    if !(wo.z > 0.0) {
        return vec3(0.0);
    }
    switch brdf.model {
//= reflects
        default: { return vec3(0.0); }
    }
}

// Widths of its lobes along tangent and bitangent, NO_LOBE for none.
fn lobes_of(brdf: Brdf) -> mat3x2<f32> {
    switch brdf.model {
//= lobes
        default: { return mat3x2(NO_LOBE, NO_LOBE, NO_LOBE); }
    }
}

// Albedo for light from the normal.
fn albedo_of(brdf: Brdf) -> vec3<f32> {
    switch brdf.model {
//= albedo
        default: { return vec3(0.0); }
    }
}

// Base color and roughness of a material, for the views that show them.
fn color_and_roughness(material: u32, at: SurfaceAttributes) -> vec4<f32> {
    switch materials[material].model {
//= shown
        default: { return vec4(0.0); }
    }
}
