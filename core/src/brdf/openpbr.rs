//! The opaque part of OpenPBR Surface 1.1 (Academy Software Foundation 2024), with its names, defaults and ranges.
//!
//! From below: a rough diffuse base ([`OrenNayar`]) under a dielectric, mixed with a metal (F82 tint, Kutz et al. 2021) by
//! `base_metalness`; a coat; fuzz. The specification leaves the form of the layers open. Here:
//!
//! * every layer transmits the light it does not reflect, by the product over both directions, which keeps the whole
//!   reciprocal; a diffuse base is normalized for all layers above at once;
//! * lobes are GGX ([`GgxLobe`]), with the loss of metals between facets restored; fuzz is Estevez and Kulla's, not
//!   Zeltner's table;
//! * a coat tints by its color whatever the angle, roughens the base, lowers its contrast of indices and darkens it by
//!   reflections inside, as specified (sections on coat roughening and darkening).
//!
//! Transmission, subsurface scattering and thin films are stored but not rendered.

use super::prelude::*;
use super::{
    fresnel::{MEAN_NODES, MEAN_WEIGHTS, dielectric_x8},
    fuzz,
    microfacet::MIN_ALPHA,
    oren_nayar::OrenNayar,
};

parameters! {
    /// Parameters of [`OpenPbr`].
    pub struct OpenPbrParameters {
        base_weight: f32 = Parameter::number(
            "Base weight", [0.0, 1.0], 1.0, "Scales the base color of a dielectric and the reflectance of a metal.",
        ).in_section("Base"),
        base_color: Vec3 = shared::BASE_COLOR.in_section("Base"),
        base_diffuse_roughness: f32 = Parameter::number(
            "Base roughness", [0.0, 1.0], 0.0,
            "Roughness of the diffuse base: 0 is Lambertian, 1 is flat and dusty as clay or the moon.",
        ).known_as("diffuse_roughness").in_section("Base"),
        base_metalness: f32 = Parameter::number(
            "Metalness", [0.0, 1.0], 0.0, "0 for a dielectric, 1 for a metal. Values between are for transitions in maps.",
        ).known_as("metalness").in_section("Base"),
        specular_weight: f32 = Parameter::number(
            "Specular weight", [0.0, 1.0], 1.0, "Scales the highlight: 0 is none, 1 all that the index of refraction gives.",
        ).known_as("specular").in_section("Specular"),
        specular_color: Vec3 = Parameter::color(
            "Specular color", [1.0; 3], "Tint of a dielectric's highlight, and of a metal's reflection toward grazing angles.",
        ).in_section("Specular"),
        specular_roughness: f32 = Parameter::number(
            "Specular roughness", [0.0, 1.0], 0.3,
            "Width of the highlight, 0 (mirror) to 1 (dull). Perceptual: the microfacet width alpha is its square.",
        ).known_as("roughness").in_section("Specular"),
        specular_ior: f32 = Parameter::number(
            "Specular IOR", [1.0, 10.0], 1.5, "Index of refraction of a dielectric: water 1.33, plastics and glass 1.5.",
        ).with_slider([1.0, 3.0]).above_one().known_as("ior").in_section("Specular"),
        specular_roughness_anisotropy: f32 = Parameter::number(
            "Specular anisotropy", [0.0, 1.0], 0.0, "How far the highlight is stretched along the tangent.",
        ).known_as("anisotropy").in_section("Specular"),
        coat_weight: f32 = Parameter::number(
            "Coat weight", [0.0, 1.0], 0.0, "How much of the surface has a clear coat: 1 for lacquer and car paint.",
        ).in_section("Coat"),
        coat_color: Vec3 = Parameter::color("Coat color", [1.0; 3], "Tint of the layers below the coat.").in_section("Coat"),
        coat_roughness: f32 = Parameter::number(
            "Coat roughness", [0.0, 1.0], 0.0, "Width of the coat's highlight, 0 (mirror) to 1 (dull). It blurs the base too.",
        ).in_section("Coat"),
        coat_roughness_anisotropy: f32 = Parameter::number(
            "Coat anisotropy", [0.0, 1.0], 0.0, "How far the coat's highlight is stretched along the tangent.",
        ).in_section("Coat"),
        coat_ior: f32 = Parameter::number(
            "Coat IOR", [1.0, 3.0], 1.6, "Index of refraction of the coat: lacquers 1.5 to 1.6.",
        ).above_one().in_section("Coat"),
        coat_darkening: f32 = Parameter::number(
            "Coat darkening", [0.0, 1.0], 1.0,
            "How much of the darkening by reflections inside the coat is shown: 1 is physical, as wood under varnish.",
        ).in_section("Coat"),
        fuzz_weight: f32 = Parameter::number(
            "Fuzz weight", [0.0, 1.0], 0.0, "How much of the surface has fuzz: dust, velvet, peach skin.",
        ).in_section("Fuzz"),
        fuzz_color: Vec3 = Parameter::color("Fuzz color", [1.0; 3], "Color of the fuzz.").in_section("Fuzz"),
        fuzz_roughness: f32 = Parameter::number(
            "Fuzz roughness", [0.0, 1.0], 0.5, "How far the fuzz glows from the edges inward.",
        ).in_section("Fuzz"),
    }
}

/// Upper bound of quantities unbounded in the specification.
const UNBOUNDED: f32 = 1e6;

/// OpenPBR's parameters of light inside a surface and of films on it, kept for other programs.
///
/// Maps multiply all of them, also the index of the film, so plain pictures of other programs stay unchanged.
const STORED: &[Parameter] = &[
    Parameter::number("Transmission weight", [0.0, 1.0], 0.0, "How much of the base is clear, as glass or water.")
        .named("transmission_weight"),
    Parameter::color(
        "Transmission color",
        [1.0; 3],
        "Color of light after the transmission depth, or at once if that is 0.",
    )
    .named("transmission_color"),
    Parameter::number(
        "Transmission depth",
        [0.0, UNBOUNDED],
        0.0,
        "Distance inside after which light has the transmission color.",
    )
    .with_slider([0.0, 1.0])
    .named("transmission_depth"),
    Parameter::color(
        "Transmission scatter",
        [0.0; 3],
        "Color of light that is scattered inside: milk, honey, murky water.",
    )
    .named("transmission_scatter"),
    Parameter::number(
        "Transmission scatter anisotropy",
        [-1.0, 1.0],
        0.0,
        "Scattering inside: below 0 backward, above 0 forward.",
    )
    .named("transmission_scatter_anisotropy"),
    Parameter::number("Transmission dispersion scale", [0.0, 1.0], 0.0, "Share of the Abbe number's dispersion.")
        .named("transmission_dispersion_scale"),
    Parameter::number(
        "Transmission Abbe number",
        [0.0, UNBOUNDED],
        20.0,
        "Dispersion at full scale: flint glass 30, crown glass 60.",
    )
    .with_slider([9.0, 91.0])
    .named("transmission_dispersion_abbe_number"),
    Parameter::number(
        "Subsurface weight",
        [0.0, 1.0],
        0.0,
        "How much of the opaque base is lit from below, as skin, wax or marble.",
    )
    .named("subsurface_weight"),
    Parameter::color("Subsurface color", [0.8; 3], "Color of light that leaves near its point of entry.")
        .named("subsurface_color"),
    Parameter::number("Subsurface radius", [0.0, UNBOUNDED], 1.0, "Distance that light travels below the surface.")
        .with_slider([0.0, 1.0])
        .named("subsurface_radius"),
    Parameter::color(
        "Subsurface radius scale",
        [1.0, 0.5, 0.25],
        "Distance that each color travels, in subsurface radii.",
    )
    .named("subsurface_radius_scale"),
    Parameter::number(
        "Subsurface scatter anisotropy",
        [-1.0, 1.0],
        0.0,
        "Scattering below: under 0 backward, above 0 forward.",
    )
    .named("subsurface_scatter_anisotropy"),
    Parameter::number(
        "Thin film weight",
        [0.0, 1.0],
        0.0,
        "How much of the surface has a film: soap, oil, tempered steel.",
    )
    .named("thin_film_weight"),
    Parameter {
        unit: "µm",
        ..Parameter::number("Thin film thickness", [0.0, UNBOUNDED], 0.5, "Thickness of the film.")
    }
    .with_slider([0.0, 1.0])
    .named("thin_film_thickness"),
    Parameter::number("Thin film IOR", [1.0, 10.0], 1.4, "Index of refraction of the film.")
        .with_slider([1.0, 3.0])
        .named("thin_film_ior"),
];

/// The layered surface.
#[derive(Clone, Copy, Debug)]
pub struct OpenPbr {
    diffuse: OrenNayar,
    /// Tint of the diffuse base, with its normalization below all layers.
    diffuse_scale: Vec3,
    lobe: GgxLobe,
    /// Index of refraction relative to the layer above, and the color of the dielectric's reflection.
    ior: f32,
    dielectric: Vec3,
    metal: F82,
    /// Mean share of light that all layers leave to the diffuse base.
    left_mean: f32,
    /// Tint of the lobe and of its restored loss, by the coat.
    tint: Vec3,
    whole: Albedo,
    multiple: Vec3,
    /// Albedo of the dielectric above the diffuse base.
    above: Albedo,
    coat: GgxLobe,
    coat_weight: f32,
    coat_ior: f32,
    coat_albedo: Albedo,
    fuzz: Vec3,
    fuzz_roughness: f32,
    fuzz_albedo: Albedo,
}

/// Schlick's Fresnel factor of a metal with its tint at 82° (Kutz et al. 2021, *Novel aspects of the Adobe Standard
/// Material*).
#[derive(Clone, Copy, Debug)]
struct F82 {
    f0: Vec3,
    grazing: Vec3,
    dip: Vec3,
    weight: f32,
}

impl F82 {
    #[inline]
    fn new(f0: Vec3, tint: Vec3, specular: f32, metalness: f32) -> Self {
        const COS: f32 = 1.0 / 7.0;
        let m = 1.0 - COS;
        let (m2, grazing) = (m * m, Vec3::ONE - f0);
        let schlick = f0 + grazing * (m2 * m2 * m);
        let dip = schlick * (Vec3::ONE - tint) / (COS * m2 * m2 * m2);
        Self { f0, grazing, dip, weight: specular * metalness }
    }

    /// The factor, weighted by specular weight and metalness.
    #[inline(always)]
    fn fresnel<L: Lanes>(&self, cosine: L) -> Vec3x8<L> {
        let m = (L::splat(1.0) - cosine).at_least(0.0);
        let m2 = m * m;
        let m5 = m2 * m2 * m;
        let value =
            Vec3x8::splat(self.f0) + Vec3x8::splat(self.grazing) * m5 - Vec3x8::splat(self.dip) * (cosine * m5 * m);
        let value = Vec3x8 { x: value.x.at_least(0.0), y: value.y.at_least(0.0), z: value.z.at_least(0.0) };
        value * L::splat(self.weight)
    }

    /// Mean under uniform light, unweighted.
    fn mean(&self) -> Vec3 {
        // 2 ∫ (1 - c)⁵ c dc = 1/21, 2 ∫ c² (1 - c)⁶ dc = 1/126.
        self.f0 + self.grazing / 21.0 - self.dip / 126.0
    }
}

/// Widths as in the specification.
fn widths(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let short = 1.0 - anisotropy;
    let long = roughness * roughness * (2.0 / (1.0 + short * short)).sqrt();
    [long.clamp(MIN_ALPHA, 1.0), (short * long).clamp(MIN_ALPHA, 1.0)]
}

impl OpenPbr {
    /// Parameters must be within their ranges.
    #[inline]
    pub fn new(p: &OpenPbrParameters) -> Self {
        // A rough coat blurs the base below it.
        let blurred = (p.specular_roughness.powi(4) + 2.0 * p.coat_roughness.powi(4)).min(1.0).sqrt().sqrt();
        let roughness = p.specular_roughness + (blurred - p.specular_roughness) * p.coat_weight;
        let lobe = GgxLobe::new(widths(roughness, p.specular_roughness_anisotropy));
        let coat = GgxLobe::new(widths(p.coat_roughness, p.coat_roughness_anisotropy));
        // The base lies below the coat, not below air. Without a contrast the ratio is inverted, to avoid total reflection.
        let ratio = p.specular_ior / (1.0 + (p.coat_ior - 1.0) * p.coat_weight);
        let ior = ratio.max(1.0 / ratio);
        let color = p.base_color * p.base_weight;
        let metal = F82::new(color, p.specular_color, p.specular_weight, p.base_metalness);
        let dielectric = p.specular_color * (p.specular_weight * (1.0 - p.base_metalness));
        let whole = Albedo::of_ggx(lobe.alpha());
        let multiple = multiple_reflectance(metal.mean(), &whole) * (metal.weight * whole.normalization());
        let above = Albedo::of_dielectric(lobe.alpha(), ior).scaled(p.specular_weight * p.specular_color.max_element());
        let coat_albedo = Albedo::of_dielectric(coat.alpha(), p.coat_ior).scaled(p.coat_weight);
        let fuzz_albedo = Albedo::of_fuzz(p.fuzz_roughness).scaled(p.fuzz_weight * p.fuzz_color.max_element());
        let tint = Vec3::ONE.lerp(p.coat_color * darkening(p, color, roughness), p.coat_weight);
        let left = |cosine: f32| {
            let of = |albedo: &Albedo| 1.0 - albedo.at_one(cosine);
            of(&above) * of(&coat_albedo) * of(&fuzz_albedo)
        };
        let mean: f32 = MEAN_NODES.iter().zip(MEAN_WEIGHTS).map(|(&cosine, weight)| weight * left(cosine)).sum();
        Self {
            diffuse: OrenNayar::new(color, p.base_diffuse_roughness),
            diffuse_scale: tint * ((1.0 - p.base_metalness) / mean.max(1e-4)),
            left_mean: mean,
            lobe,
            ior,
            dielectric,
            metal,
            tint,
            whole,
            multiple,
            above,
            coat,
            coat_weight: p.coat_weight,
            coat_ior: p.coat_ior,
            coat_albedo,
            fuzz: p.fuzz_color * p.fuzz_weight,
            fuzz_roughness: p.fuzz_roughness,
            fuzz_albedo,
        }
    }

    /// Albedos of the sampled parts for an outgoing direction: coat, lobe, diffuse rest.
    fn shares(&self, wo: Vec3) -> [f32; 3] {
        let cosine = wo.z.clamp(0.0, 1.0);
        let coat = self.coat_albedo.at_one(cosine);
        let fresnel = (self.metal.fresnel(f32x8::splat(cosine))
            + Vec3x8::splat(self.dielectric) * dielectric_x8(f32x8::splat(cosine), self.ior))
        .lane(0);
        let below = 1.0 - coat;
        let glossy = below * luminance(fresnel * self.tint);
        let diffuse = below * luminance(self.diffuse.albedo_at(cosine) * self.diffuse_scale)
            + luminance(self.fuzz) * self.fuzz_albedo.at_one(cosine).max(0.1);
        let sum = (coat + glossy + diffuse).max(1e-6);
        // A minimum for each part present: albedos hold for uniform light.
        let least = |share: f32, is_there: bool| if is_there { share / sum + 0.1 } else { 0.0 };
        let shares = [least(coat, self.coat_weight > 0.0), least(glossy, true), least(diffuse, diffuse > 0.0)];
        let total: f32 = shares.iter().sum();
        shares.map(|share| share / total)
    }
}

/// Share of the base's albedo left by reflections inside the coat (OpenPBR, "Coat darkening").
fn darkening(p: &OpenPbrParameters, color: Vec3, roughness: f32) -> Vec3 {
    let specular = Albedo::of_smooth_dielectric(p.coat_ior);
    let inside_diffuse = 1.0 - (1.0 - specular.mean()) / (p.coat_ior * p.coat_ior);
    let inside_smooth = specular.at_one(1.0);
    let spread = roughness + (1.0 - roughness) * (1.0 - p.base_metalness);
    let inside = inside_smooth + (inside_diffuse - inside_smooth) * spread;
    let darkened = Vec3::splat(1.0 - inside) / (Vec3::ONE - color * inside);
    Vec3::ONE.lerp(darkened, p.coat_darkening)
}

impl Model for OpenPbr {
    const LABEL: &'static str = "OpenPBR";
    const SUMMARY: &'static str = "The layered surface of OpenPBR: base, metal, coat and fuzz, with its parameters.";
    const PARAMETERS: &'static [Parameter] = OpenPbrParameters::LIST;
    const STORED: &'static [Parameter] = STORED;

    #[inline]
    fn from_values(values: &Values) -> Self {
        Self::new(&OpenPbrParameters::new(values))
    }
}

impl Brdf for OpenPbr {
    fn brdf_cos_x8(&self, wi: Vec3x8, wo: Vec3, inv_kappa: f32x8) -> Vec3x8 {
        self.reflect(&LightsX8::at(wi, inv_kappa), wo)
    }

    #[inline(always)]
    fn reflect<L: Lanes>(&self, lights: &LightsX8<L>, wo: Vec3) -> Vec3x8<L> {
        let half = HalfVectors::new(lights.wi, wo);
        let (cos_i, cos_o) = (lights.wi.z, L::splat(wo.z));
        let gray = dielectric_x8(half.wi_dot_h, self.ior);
        let fresnel = self.metal.fresnel(half.wi_dot_h) + Vec3x8::splat(self.dielectric) * gray;
        let glossy = fresnel * self.lobe.reflect(lights, &half, wo);
        let multiple = Vec3x8::splat(self.multiple * FRAC_1_PI) * (self.whole.left(cos_i, cos_o) * lights.cosine);
        let diffuse = self.diffuse.value(lights.wi, wo) * (self.above.left(cos_i, cos_o) * lights.cosine);
        let mut value =
            (glossy + multiple).scale(Vec3x8::splat(self.tint)) + diffuse.scale(Vec3x8::splat(self.diffuse_scale));
        if self.coat_weight > 0.0 {
            let lobe = self.coat.reflect(lights, &half, wo) * dielectric_x8(half.wi_dot_h, self.coat_ior);
            let lobe = lobe * L::splat(self.coat_weight);
            value = value * self.coat_albedo.left(cos_i, cos_o) + Vec3x8 { x: lobe, y: lobe, z: lobe };
        }
        if self.fuzz != Vec3::ZERO {
            let lobe = fuzz::reflect(self.fuzz_roughness, lights, &half, wo);
            value = value * self.fuzz_albedo.left(cos_i, cos_o) + Vec3x8::splat(self.fuzz) * lobe;
        }
        value * is_seen(wo)
    }

    fn lobes(&self) -> Lobes {
        let coat = if self.coat_weight > 0.0 { self.coat.alpha() } else { NO_LOBE };
        [self.lobe.alpha(), coat, NO_LOBE]
    }

    fn albedo(&self) -> Vec3 {
        let whole = self.whole.at_one(1.0);
        let one = f32x8::splat(1.0);
        let fresnel = (self.metal.fresnel(one) + Vec3x8::splat(self.dielectric) * dielectric_x8(one, self.ior)).lane(0);
        let glossy = (fresnel * whole + self.multiple * ((1.0 - whole) / self.whole.normalization())) * self.tint;
        let [above, coat, fuzz] = [&self.above, &self.coat_albedo, &self.fuzz_albedo].map(|albedo| albedo.at_one(1.0));
        // The lobe passes the layers twice; the base is normalized.
        let through = ((1.0 - coat) * (1.0 - fuzz)).powi(2);
        let left = (1.0 - above) * (1.0 - coat) * (1.0 - fuzz) * self.left_mean;
        let diffuse = self.diffuse.albedo_at(1.0) * self.diffuse_scale * left;
        glossy * through
            + diffuse
            + Vec3::splat(coat * (1.0 - fuzz).powi(2))
            + self.fuzz * Albedo::of_fuzz(self.fuzz_roughness).at_one(1.0)
    }

    fn sample(&self, wo: Vec3, u: Vec3) -> Vec3 {
        let [coat, glossy, _] = self.shares(wo);
        let mirrored = |lobe: &GgxLobe| {
            let h = lobe.sample_half_vector(wo, u.x, u.y);
            2.0 * wo.dot(h) * h - wo
        };
        match u.z {
            z if z < coat => mirrored(&self.coat),
            z if z < coat + glossy => mirrored(&self.lobe),
            _ => cosine_direction(u.x, u.y),
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3) -> f32 {
        let [coat, glossy, diffuse] = self.shares(wo);
        coat * self.coat.pdf(wi, wo) + glossy * self.lobe.pdf(wi, wo) + diffuse * wi.z.max(0.0) * FRAC_1_PI
    }
}
