// What all BRDFs are made of: lights of some extent, half vectors, lobes filtered by the light's spread. Twin of
// core/src/brdf. The models are in brdf/, one file each; the dispatch to them is generated for those that a scene uses.
//
// A model `Name` in `brdf/name.wgsl` has
//   struct Name                                           what of its parameters does not depend on the light;
//   fn name_of(p: NameParameters) -> Name                 from the declared parameters;
//   fn name_reflect(brdf: Name, light: Light, wo) -> vec3 f_r times the cosine;
//   fn name_lobes(brdf: Name) -> vec3                     widths of its lobes around the mirror's direction, 0 for none;
//   fn name_albedo(brdf: Name) -> vec3                    albedo for light from the normal.

const FRAC_1_PI: f32 = 0.31830987;
const MIN_ALPHA: f32 = 0.001;

// Microfacet widths along tangent and bitangent.
fn lobe_alpha(roughness: f32, anisotropy: f32) -> vec2<f32> {
    let alpha = roughness * roughness;
    let aspect = sqrt(1.0 - 0.9 * abs(anisotropy));
    let long = clamp(alpha / aspect, MIN_ALPHA, 1.0);
    let short = clamp(alpha * aspect, MIN_ALPHA, 1.0);
    return select(vec2(short, long), vec2(long, short), anisotropy >= 0.0);
}

// Half vector and the spread that the light gives it.
struct Half {
    h: vec3<f32>,
    wi_dot_h: f32,
    // (2 / kappa) J J^T as xx, xy, yy; see core/src/brdf/microfacet.rs.
    spread: vec3<f32>,
}

fn half_vector(wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32) -> Half {
    let sum = wi + wo;
    let length = sqrt(max(dot(sum, sum), 1e-12));
    let h = sum / length;
    let wi_dot_h = 0.5 * length;
    let q = wi - h * wi_dot_h;
    let scale = 0.5 * inv_kappa / max(wi_dot_h * wi_dot_h, 1e-4);
    let spread = scale * vec3(1.0 - h.x * h.x - q.x * q.x, -(h.x * h.y + q.x * q.y), 1.0 - h.y * h.y - q.y * q.y);
    return Half(h, wi_dot_h, spread);
}

// v^T M v for M given as xx, xy, yy.
fn quadratic(m: vec3<f32>, v: vec2<f32>) -> f32 {
    return m.x * v.x * v.x + 2.0 * m.y * v.x * v.y + m.z * v.y * v.y;
}

// v^T M^-1 v det M.
fn adjugate_quadratic(m: vec3<f32>, v: vec2<f32>) -> f32 {
    return m.z * v.x * v.x - 2.0 * m.y * v.x * v.y + m.x * v.y * v.y;
}

fn determinant_of(m: vec3<f32>) -> f32 {
    return m.x * m.z - m.y * m.y;
}

// A light of some extent in the local frame of a surface. Twin of core/src/brdf/lights.rs.
struct Light {
    // Unit direction to it.
    wi: vec3<f32>,
    // Inverse concentration of its directions.
    inv_kappa: f32,
    // Mean cosine to the normal of its light above the horizon.
    cosine: f32,
    // Whether `wi` is above the horizon.
    is_above: bool,
}

// f_r(wi, wo) times the cosine for directions around `wi` of an inverse concentration, 0 for one; zero below the horizon.
fn brdf_cos(brdf: Brdf, wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32) -> vec3<f32> {
    return reflection_of(brdf, Light(wi, inv_kappa, max(wi.z, 0.0), wi.z > 0.0), wo);
}

// Reflectance at normal and at grazing incidence, and diffuse albedo, of a metallic-roughness material.
struct Reflectance {
    f0: vec3<f32>,
    f90: f32,
    diffuse: vec3<f32>,
}

fn reflectance_of(base_color: vec3<f32>, metalness: f32, ior: f32, specular: f32) -> Reflectance {
    let root = (ior - 1.0) / (ior + 1.0);
    let f0 = mix(vec3(root * root * specular), base_color, metalness);
    return Reflectance(f0, specular + (1.0 - specular) * metalness, base_color * (1.0 - metalness));
}

// Schlick's Fresnel factor.
fn schlick(f0: vec3<f32>, f90: f32, wi_dot_h: f32) -> vec3<f32> {
    let c = max(1.0 - wi_dot_h, 0.0);
    let c2 = c * c;
    return f0 + (vec3(f90) - f0) * (c2 * c2 * c);
}
