// Building blocks of BRDFs: lights with an extent, half vectors, lobes filtered by the light's spread, Fresnel factors, and
// albedos. Twin of core/src/brdf. The models are in brdf/, one file each; the dispatch to a scene's models is generated.
//
// A model `Name` in `brdf/name.wgsl` has
//   struct Name                                     what of its parameters does not depend on the light;
//   fn name_of(p: NameParameters) -> Name           from the declared parameters;
//   fn name_reflect(brdf: Name, light: Light, wo)   f_r times the cosine;
//   fn name_lobes(brdf: Name) -> mat3x2<f32>        widths of its lobes around the mirror's direction along tangent and
//                                                   bitangent, NO_LOBE for none;
//   fn name_albedo(brdf: Name) -> vec3<f32>         albedo for light from the normal.

const FRAC_1_PI: f32 = 0.31830987;
const MIN_ALPHA: f32 = 0.001;
const NO_LOBE: vec2<f32> = vec2<f32>(0.0);
// Albedo of a material whose BRDF is missing. Twin of core/src/brdf/merl.rs.
const MISSING_ALBEDO: vec3<f32> = vec3<f32>(0.8, 0.0, 0.8);

// Microfacet widths along tangent and bitangent. Twin of core/src/brdf/microfacet.rs, like the code below.
fn lobe_alpha(roughness: f32, anisotropy: f32) -> vec2<f32> {
    let alpha = roughness * roughness;
    let aspect = sqrt(1.0 - 0.9 * abs(anisotropy));
    let long = clamp(alpha / aspect, MIN_ALPHA, 1.0);
    let short = clamp(alpha * aspect, MIN_ALPHA, 1.0);
    return select(vec2(short, long), vec2(long, short), anisotropy >= 0.0);
}

// Squared widths in projected slope space. An alpha of one has infinite slope width; 0.9999 is indistinguishable from it.
fn slope_sq(alpha: vec2<f32>) -> vec2<f32> {
    let sq = min(alpha * alpha, vec2(0.9998));
    return sq / (1.0 - sq);
}

// Half vector, and its spread by light and surface.
struct Half {
    h: vec3<f32>,
    wi_dot_h: f32,
    // (2 / kappa) J J^T and the slopes of the surface as xx, xy, yy.
    spread: vec3<f32>,
}

fn half_vector(light: Light, wo: vec3<f32>) -> Half {
    let sum = light.wi + wo;
    let length_sq = max(dot(sum, sum), 1e-12);
    let inv_length_sq = 1.0 / length_sq;
    let length = sqrt(length_sq);
    let h = sum * (length * inv_length_sq);
    let q = 0.5 * (light.wi.xy - wo.xy);
    // 1 / (2 a^2) for the cosine a to the half vector, where a^2 is at least 1e-4.
    let scale = light.inv_kappa * min(2.0 * inv_length_sq, 5e3);
    let spread = scale * vec3(1.0 - h.x * h.x - q.x * q.x, -(h.x * h.y + q.x * q.y), 1.0 - h.y * h.y - q.y * q.y);
    return Half(h, 0.5 * length, spread + light.slopes);
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

// A light with an extent in a surface's local frame. Twin of core/src/brdf/lights.rs.
struct Light {
    // Unit direction to the light.
    wi: vec3<f32>,
    // Inverse concentration of its directions.
    inv_kappa: f32,
    // Twice the covariance of the surface's slopes within the sample: xx, xy, yy.
    slopes: vec3<f32>,
    // Mean cosine to the normal over its light above the horizon.
    cosine: f32,
    // Whether `wi` is above the horizon.
    is_above: bool,
}

// f_r(wi, wo) times the cosine for a lobe of directions around `wi` with this inverse concentration, or one direction if 0; zero
// below the horizon.
fn brdf_cos(brdf: Brdf, wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32, slopes: vec3<f32>) -> vec3<f32> {
    return reflection_of(brdf, Light(wi, inv_kappa, slopes, max(wi.z, 0.0), wi.z > 0.0), wo);
}

// A GGX lobe without its Fresnel factor: D G / (4 cos_i cos_o) times the cosine. Twin of core/src/brdf/ggx_lobe.rs.
fn ggx_lobe(slopes: vec2<f32>, half: Half, light: Light, wo: vec3<f32>) -> f32 {
    let a = half.spread + vec3(slopes.x, 0.0, slopes.y);
    let det_a = determinant_of(a);
    let scale = 1.0 / (1.0 + a.x + a.z + det_a);
    let m = vec3(a.x + det_a, a.y, a.z + det_a) * scale;
    let det = max(det_a * scale, 1e-14);
    // The squared distance of the half vector from the normal in widths, times the determinant.
    let distance = adjugate_quadratic(m, half.h.xy) + det * half.h.z * half.h.z;
    let cos_i = max(light.wi.z, 0.0);
    let cos_o = max(wo.z, 1e-4);
    let root_o = sqrt(cos_o * cos_o + quadratic(m, wo.xy));
    let root_i = sqrt(cos_i * cos_i + quadratic(m, light.wi.xy));
    let shadowing = max(cos_i * root_o + cos_o * root_i, 1e-9);
    let value = 0.5 * FRAC_1_PI * det * sqrt(det) * cos_i / (distance * distance * shadowing);
    return select(0.0, value, light.is_above);
}

// A lobe of normally distributed slopes, filtered. Twin of core/src/brdf/gaussian_lobe.rs.
struct GaussianLobe {
    // Squared widths as xx, xy, yy.
    alpha_sq: vec3<f32>,
    // The density of half vectors times the fourth power of their cosines.
    density: f32,
    cos_h_sq: f32,
}

fn gaussian_lobe(alpha: vec2<f32>, half: Half) -> GaussianLobe {
    let m = half.spread + vec3(alpha.x * alpha.x, 0.0, alpha.y * alpha.y);
    let det = max(determinant_of(m), 1e-14);
    let cos_h_sq = max(half.h.z * half.h.z, 1e-4);
    let exponent = adjugate_quadratic(m, half.h.xy) / (det * cos_h_sq);
    return GaussianLobe(m, exp(-exponent) * FRAC_1_PI / sqrt(det), cos_h_sq);
}

// A lobe of powers of the half vector's cosine, filtered. Twin of core/src/brdf/phong_lobe.rs.
struct PhongLobe {
    // The cosine to the exponent in the direction of the half vector.
    power: f32,
    // sqrt((nu + 1) (nv + 1)).
    two_exponents: f32,
    // The geometric mean of both exponents.
    exponent: f32,
}

fn phong_lobe(slopes: vec2<f32>, half: Half) -> PhongLobe {
    let s = half.spread + vec3(slopes.x, 0.0, slopes.y);
    let det = max(determinant_of(s), 1e-14);
    let h = half.h;
    let sin_sq = max(dot(h.xy, h.xy), 1e-12);
    let exponent = adjugate_quadratic(s, h.xy) / (det * sin_sq);
    // A logarithm near one is too coarse for large exponents.
    let series = -sin_sq * (1.0 + sin_sq * (0.5 + sin_sq * (1.0 / 3.0 + sin_sq * 0.25)));
    let power = exp(exponent * select(log(max(1.0 - sin_sq, 1e-8)), series, sin_sq < 0.03));
    let trace = s.x + s.z;
    return PhongLobe(power, sqrt((det + trace + trace + 4.0) / det), 2.0 / sqrt(det));
}

// Schlick's Fresnel factor, and the diffuse albedo, of a metallic-roughness material.
struct Schlick {
    f0: vec3<f32>,
    f90: f32,
    diffuse: vec3<f32>,
}

fn schlick_of(base_color: vec3<f32>, metalness: f32, ior: f32, specular: f32) -> Schlick {
    let root = (ior - 1.0) / (ior + 1.0);
    let f0 = mix(vec3(root * root * specular), base_color, metalness);
    return Schlick(f0, specular + (1.0 - specular) * metalness, base_color * (1.0 - metalness));
}

fn schlick_fresnel(schlick: Schlick, wi_dot_h: f32) -> vec3<f32> {
    let c = max(1.0 - wi_dot_h, 0.0);
    let c2 = c * c;
    return schlick.f0 + (vec3(schlick.f90) - schlick.f0) * (c2 * c2 * c);
}

// The exact Fresnel factor of a dielectric. Twin of core/src/brdf/fresnel.rs, like the code below.
fn dielectric_fresnel(c: f32, ior: f32) -> f32 {
    let g = sqrt(ior * ior - 1.0 + c * c);
    let sum = max(g + c, 1e-6);
    let difference = g - c;
    let over = c * sum - 1.0;
    let under = c * difference + 1.0;
    let root = difference / (sum * under);
    return 0.5 * root * root * (under * under + over * over);
}

const MOST_REFLECTANCE: f32 = 0.9999;
// Nodes and weights of the Gauss quadrature of 2 * integral of f(c) c from 0 to 1.
const MEAN_NODES: vec3<f32> = vec3<f32>(0.21234054, 0.59053314, 0.91141204);
const MEAN_WEIGHTS: vec3<f32> = vec3<f32>(0.13965396, 0.4584822, 0.40186384);

struct Metal {
    n_sq: vec3<f32>,
    k_sq: vec3<f32>,
}

// Computes a metal from reflectance at normal incidence and tint toward grazing angles (Gulbrandsen 2014).
fn metal_of(reflectance: vec3<f32>, edge: vec3<f32>) -> Metal {
    let r = clamp(reflectance, vec3(0.0), vec3(MOST_REFLECTANCE));
    let root = sqrt(r);
    let least = (1.0 - r) / (1.0 + r);
    let most = (1.0 + root) / (1.0 - root);
    let n = most + (least - most) * edge;
    let k_sq = ((n + 1.0) * (n + 1.0) * r - (n - 1.0) * (n - 1.0)) / (1.0 - r);
    return Metal(n * n, max(k_sq, vec3(0.0)));
}

fn metal_fresnel(metal: Metal, cosine: f32) -> vec3<f32> {
    let cos_sq = min(cosine * cosine, 1.0);
    let sin_sq = 1.0 - cos_sq;
    let t0 = metal.n_sq - metal.k_sq - sin_sq;
    let length = sqrt(t0 * t0 + 4.0 * metal.n_sq * metal.k_sq);
    let t1 = length + cos_sq;
    let t2 = 2.0 * sqrt(max(0.5 * (length + t0), vec3(0.0))) * cosine;
    // The mean of (t1 - t2) / (t1 + t2) across and of that times (t3 - t4) / (t3 + t4) along the plane of incidence.
    let t3 = cos_sq * length + sin_sq * sin_sq;
    let t4 = t2 * sin_sq;
    return max((t1 - t2) * t3 / ((t1 + t2) * (t3 + t4)), vec3(0.0));
}

fn metal_mean(metal: Metal) -> vec3<f32> {
    if !HAS_METAL {
        return vec3(0.0);
    }
    return MEAN_WEIGHTS.x * metal_fresnel(metal, MEAN_NODES.x)
        + MEAN_WEIGHTS.y * metal_fresnel(metal, MEAN_NODES.y)
        + MEAN_WEIGHTS.z * metal_fresnel(metal, MEAN_NODES.z);
}

// The exact Fresnel factor of a dielectric, a metal, or a mixture.
struct Interface {
    ior: f32,
    // Weights of the dielectric and of the metal.
    weights: vec2<f32>,
    metal: Metal,
}

fn interface_of(base_color: vec3<f32>, edge: vec3<f32>, metalness: f32, ior: f32, specular: f32) -> Interface {
    var metal = Metal(vec3(1.0), vec3(0.0));
    if HAS_METAL {
        metal = metal_of(base_color, edge);
    }
    return Interface(ior, vec2(specular * (1.0 - metalness), metalness), metal);
}

fn interface_fresnel(surface: Interface, wi_dot_h: f32) -> vec3<f32> {
    var all = vec3(surface.weights.x * dielectric_fresnel(wi_dot_h, surface.ior));
    if HAS_METAL && surface.weights.y > 0.0 {
        all += surface.weights.y * metal_fresnel(surface.metal, wi_dot_h);
    }
    return all;
}

// Directional albedo of a lobe: a polynomial in 1 / (1 + 6 cos), and its mean. Twin of core/src/brdf/albedo.rs, as below.
struct Albedo {
    low: vec4<f32>,
    // The fifth coefficient and the mean.
    high: vec2<f32>,
}

const ALBEDO_STEPS: u32 = 16u;
const ALBEDO_WHOLE: u32 = 15u;
const ALBEDO_FUZZ: u32 = 16u;
const ALBEDO_BECKMANN: u32 = 17u;
const ALBEDO_WARD: u32 = 18u;

fn albedo_entry(row: u32, column: u32) -> Albedo {
    let first = 2u * (row * ALBEDO_STEPS + column);
    return Albedo(tables.albedo[first], tables.albedo[first + 1u].xy);
}

fn albedo_mix(a: Albedo, b: Albedo, t: f32) -> Albedo {
    return Albedo(a.low + (b.low - a.low) * t, a.high + (b.high - a.high) * t);
}

// Albedo of the lobe in a table row, for one width.
fn albedo_of_width(row: u32, alpha: f32) -> Albedo {
    let column = sqrt(clamp(alpha, 0.0, 1.0)) * f32(ALBEDO_STEPS - 1u);
    let left = min(u32(column), ALBEDO_STEPS - 2u);
    return albedo_mix(albedo_entry(row, left), albedo_entry(row, left + 1u), column - f32(left));
}

// Albedo for two widths: the mean.
fn albedo_of_row(row: u32, alpha: vec2<f32>) -> Albedo {
    if alpha.x == alpha.y {
        return albedo_of_width(row, alpha.x);
    }
    return albedo_mix(albedo_of_width(row, alpha.x), albedo_of_width(row, alpha.y), 0.5);
}

fn albedo_of_dielectric(alpha: vec2<f32>, ior: f32) -> Albedo {
    let row = (ior - 1.0) / (ior + 1.0) * f32(ALBEDO_STEPS - 1u);
    let low = min(u32(row), ALBEDO_STEPS - 2u);
    return albedo_mix(albedo_of_row(low, alpha), albedo_of_row(low + 1u, alpha), row - f32(low));
}

fn albedo_scaled(albedo: Albedo, by: f32) -> Albedo {
    return Albedo(by * albedo.low, by * albedo.high);
}

fn albedo_at(albedo: Albedo, cosine: f32) -> f32 {
    let x = 1.0 / (1.0 + 6.0 * max(cosine, 0.0));
    let low = albedo.low;
    return clamp((((albedo.high.x * x + low.w) * x + low.z) * x + low.y) * x + low.x, 0.0, 1.0);
}

// Share of light that a lobe leaves for two directions.
fn albedo_left(albedo: Albedo, cos_i: f32, cos_o: f32) -> f32 {
    return (1.0 - albedo_at(albedo, cos_i)) * (1.0 - albedo_at(albedo, cos_o));
}

fn albedo_normalization(albedo: Albedo) -> f32 {
    return 1.0 / max(1.0 - albedo.high.y, 1e-4);
}

fn multiple_reflectance(mean_fresnel: vec3<f32>, lobe: Albedo) -> vec3<f32> {
    let lost = 1.0 - lobe.high.y;
    return mean_fresnel * mean_fresnel * lobe.high.y / (1.0 - mean_fresnel * lost);
}

// A diffuse base below a dielectric.
struct DiffuseBase {
    albedo: vec3<f32>,
    above: Albedo,
}

fn base_reflect(base: DiffuseBase, light: Light, wo: vec3<f32>) -> vec3<f32> {
    let left = albedo_left(base.above, light.wi.z, wo.z);
    return base.albedo * (FRAC_1_PI * albedo_normalization(base.above)) * (left * light.cosine);
}

fn base_albedo(base: DiffuseBase) -> vec3<f32> {
    return base.albedo * (1.0 - albedo_at(base.above, 1.0));
}

// Rough diffuse reflection (EON). Twin of core/src/brdf/oren_nayar.rs.
struct RoughDiffuse {
    albedo: vec3<f32>,
    roughness: f32,
    scale: f32,
    multiple: vec3<f32>,
}

const EON_A: f32 = 0.2877934;
const EON_B: f32 = 0.07248821;
const EON_G: vec4<f32> = vec4<f32>(0.05710853, 0.49188187, -0.33218144, 0.071442995);

fn rough_diffuse_of(albedo: vec3<f32>, roughness: f32) -> RoughDiffuse {
    let scale = 1.0 / (1.0 + EON_A * roughness);
    let mean = scale * (1.0 + EON_B * roughness);
    let lost = max(1.0 - mean, 1e-7);
    return RoughDiffuse(albedo, roughness, scale, albedo * albedo * mean / (1.0 - albedo * (1.0 - mean)) / lost);
}

fn rough_single_albedo(rough: RoughDiffuse, cosine: f32) -> f32 {
    let m = 1.0 - clamp(cosine, 0.0, 1.0);
    let g = m * (EON_G.x + m * (EON_G.y + m * (EON_G.z + m * EON_G.w)));
    return (1.0 + rough.roughness * g) * rough.scale;
}

// Value without the cosine.
fn rough_diffuse_value(rough: RoughDiffuse, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    let cos_i = max(wi.z, 0.0);
    let cos_o = max(wo.z, 0.0);
    let s = dot(wi, wo) - cos_i * cos_o;
    let s_over_t = select(s, s / max(max(cos_i, cos_o), 1e-4), s > 0.0);
    let single = (1.0 + rough.roughness * s_over_t) * (rough.scale * FRAC_1_PI);
    let lost = max((1.0 - rough_single_albedo(rough, cos_i)) * (1.0 - rough_single_albedo(rough, cos_o)), 0.0);
    return rough.albedo * single + rough.multiple * (FRAC_1_PI * lost);
}

fn rough_diffuse_albedo(rough: RoughDiffuse, cosine: f32) -> vec3<f32> {
    let single = rough_single_albedo(rough, cosine);
    let mean = rough.scale * (1.0 + EON_B * rough.roughness);
    return rough.albedo * single + rough.multiple * ((1.0 - single) * (1.0 - mean));
}
