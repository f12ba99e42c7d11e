"""The `ggx` model of Lapidary as a BSDF of Mitsuba 3, written from the papers and not from Lapidary's source.

    f = (1 - metalness) base / pi (1 - A(i)) (1 - A(o)) / (1 - mean A)  +  F D G2 / (4 cos_i cos_o)
        + metalness M (1 - E(i)) (1 - E(o)) / (pi (1 - mean E))

* D: anisotropic GGX (Walter et al. 2007, Eq. 33; Heitz 2014, Eq. 85) of alpha = roughness^2, stretched by the aspect
  sqrt(1 - 0.9 |anisotropy|) of Burley 2012.
* G2: height-correlated masking and shadowing of Smith, 1 / (1 + L(i) + L(o)) with L of Heitz 2014, Eq. 72 and 99.
* F: Fresnel's equations for unpolarised light at the half vector, of a dielectric (times specular) and of a conductor, mixed
  by the metalness. The conductor has the base colour at normal incidence and Gulbrandsen's edge tint (2014).
* E: directional albedo of D G2 / (4 cos_i cos_o), and A with the dielectric's factor; the mean of those of both alphas.
  They are integrated here with numpy.
* M = Fm^2 mean E / (1 - Fm (1 - mean E)) with the conductor's mean factor Fm (Kulla and Conty 2017).

Mitsuba's own plugins are not of this form: `roughconductor` and `principled` mask and shadow independently and lose light
between facets, `roughplastic` scatters between base and coat. Half vectors are drawn by Mitsuba's own distribution of visible normals.
"""

import cmath
import functools
import math

import mitsuba as mi
import numpy as np
from microfacets import dielectric, visible_normals

MIN_ALPHA = 1e-3
COSINES = np.linspace(0.0, 1.0, 41)
ALPHAS = np.linspace(0.0, 1.0, 21)
ROOTS = np.linspace(0.0, 0.82, 18)


def _number(props, name, default):
    return props[name] if name in props else default


def _smith_lambda(v, alpha_x, alpha_y):
    tan_sq = ((alpha_x * v.x) ** 2 + (alpha_y * v.y) ** 2) / (v.z * v.z)
    return 0.5 * (math.sqrt(1.0 + tan_sq) - 1.0)


def _fresnel(cos, index):
    """Of a complex index of refraction, scalar."""
    inner = cmath.sqrt(1.0 - (1.0 - cos * cos) / (index * index))
    across = (cos - index * inner) / (cos + index * inner)
    along = (index * cos - inner) / (index * cos + inner)
    return 0.5 * (abs(across) ** 2 + abs(along) ** 2)


def _metal_index(reflectance, edge):
    r = min(max(reflectance, 0.0), 0.9999)
    n = edge * (1.0 - r) / (1.0 + r) + (1.0 - edge) * (1.0 + math.sqrt(r)) / (1.0 - math.sqrt(r))
    k_sq = ((n + 1.0) ** 2 * r - (n - 1.0) ** 2) / (1.0 - r)
    return complex(n, math.sqrt(max(k_sq, 0.0)))


@functools.cache
def _albedos():
    """E and A over COSINES, ALPHAS and the square roots ROOTS of the reflectance at normal incidence (E is the last)."""
    table = np.zeros((len(COSINES), len(ALPHAS), len(ROOTS) + 1))
    for i, cos_o in enumerate(np.maximum(COSINES, 1e-3)):
        for j, alpha in enumerate(np.maximum(ALPHAS, MIN_ALPHA)):
            half, wo = visible_normals(cos_o, alpha, side=48)
            cos_h = half @ wo
            cos_i = 2.0 * cos_h * half[:, 2] - cos_o
            tan = lambda c: np.sqrt(1.0 + alpha * alpha * (1.0 / (c * c) - 1.0))
            root_i, root_o = tan(np.maximum(cos_i, 1e-6)), tan(cos_o)
            weight = np.where(cos_i > 0.0, (1.0 + root_o) / (root_i + root_o), 0.0)
            for k, root in enumerate(ROOTS):
                table[i, j, k] = np.mean(weight * dielectric(cos_h, (1.0 + root) / (1.0 - root)))
            table[i, j, -1] = np.mean(weight)
    return table


def _over_alpha(table, alpha):
    at = alpha * (len(ALPHAS) - 1)
    low = min(int(at), len(ALPHAS) - 2)
    return table[:, low] + (table[:, low + 1] - table[:, low]) * (at - low)


class _Albedo:
    """Over the cosine, and its mean."""

    def __init__(self, values):
        self.values = values
        self.mean = np.trapezoid(2.0 * COSINES * values, COSINES)
        self.normalization = 1.0 / max(1.0 - self.mean, 1e-4)

    def left(self, cosine):
        return 1.0 - np.interp(cosine, COSINES, self.values)


def _albedos_of(alphas, ior, specular):
    table = 0.5 * (_over_alpha(_albedos(), alphas[0]) + _over_alpha(_albedos(), alphas[1]))
    at = (ior - 1.0) / (ior + 1.0) / ROOTS[-1] * (len(ROOTS) - 1)
    low = min(int(at), len(ROOTS) - 2)
    dielectric = table[:, low] + (table[:, low + 1] - table[:, low]) * (at - low)
    return _Albedo(table[:, -1]), _Albedo(specular * dielectric)


class LapidaryGgx(mi.BSDF):
    """For scalar variants: one direction at a time."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base_color = props.get_texture("base_color")
        self.edge_color = props.get_texture("edge_color")
        self.numbers = [
            _number(props, name, default)
            for name, default in [
                ("roughness", 0.5),
                ("metalness", 0.0),
                ("anisotropy", 0.0),
                ("specular", 1.0),
                ("ior_above_one", 0.5),
            ]
        ]
        self.constant = None
        glossy = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        diffuse = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [glossy, diffuse]
        self.m_flags = glossy | diffuse

    def lobe(self, si):
        """Base colour, interface, alphas, microfacets, albedos and multiple reflectance at a point."""
        if self.constant is not None:
            return self.constant
        is_map = [isinstance(number, mi.Texture) for number in self.numbers]
        values = [n.eval_1(si) if m else n for n, m in zip(self.numbers, is_map)]
        roughness, metalness, anisotropy, specular, above_one = values
        color, edge = self.base_color.eval(si), self.edge_color.eval(si)
        base = (color[0], color[1], color[2])
        metal = [_metal_index(b, edge[i]) for i, b in enumerate(base)] if metalness > 0.0 else None
        aspect = math.sqrt(1.0 - 0.9 * abs(anisotropy))
        alpha = roughness * roughness
        long, short = (min(max(a, MIN_ALPHA), 1.0) for a in (alpha / aspect, alpha * aspect))
        alphas = (long, short) if anisotropy >= 0.0 else (short, long)
        microfacets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alphas[0], alphas[1], True)
        whole, above = _albedos_of(alphas, 1.0 + above_one, specular)
        multiple = (0.0, 0.0, 0.0)
        if metal:
            cosines = (np.arange(64) + 0.5) / 64
            mean = [sum(2.0 * c * _fresnel(c, index) for c in cosines) / 64 for index in metal]
            multiple = tuple(m * m * whole.mean / (1.0 - m * (1.0 - whole.mean)) for m in mean)
        found = (base, (metalness, specular, complex(1.0 + above_one), metal), alphas, microfacets, whole, above, multiple)
        varying = self.base_color.is_spatially_varying() or self.edge_color.is_spatially_varying()
        if not any(is_map) and not varying:
            self.constant = found
        return found

    def fresnel(self, interface, cos):
        metalness, specular, dielectric, metal = interface
        grey = (1.0 - metalness) * specular * _fresnel(cos, dielectric)
        return [grey + (metalness * _fresnel(cos, metal[i]) if metal else 0.0) for i in range(3)]

    def glossy_share(self, lobe, cos):
        """Probability that a half vector is drawn and not a direction of the base."""
        base, interface = lobe[0], lobe[1]
        glossy = sum(self.fresnel(interface, cos))
        diffuse = sum(base) * (1.0 - interface[0])
        return max(0.2, glossy / max(glossy + diffuse, 1e-6)) if diffuse > 0.0 else 1.0

    def evaluated(self, lobe, wi, wo):
        """BRDF times cosine, and density, of one pair of directions."""
        if wi.z <= 0.0 or wo.z <= 0.0:
            return mi.Color3f(0.0), 0.0
        base, interface, (ax, ay), _, whole, above, multiple = lobe
        x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        cos_h = min(0.5 * length, 1.0)
        slope = (x / ax) ** 2 + (y / ay) ** 2 + z * z
        d = 1.0 / (math.pi * ax * ay * slope * slope)
        lambda_i = _smith_lambda(wi, ax, ay)
        g = 1.0 / (1.0 + lambda_i + _smith_lambda(wo, ax, ay))
        specular = d * g / (4.0 * wi.z)  # times the cosine of the light
        left = above.left(wi.z) * above.left(wo.z) * above.normalization
        lost = whole.left(wi.z) * whole.left(wo.z) * whole.normalization
        cosine = wo.z / math.pi
        value = [
            f * specular + ((1.0 - interface[0]) * b * left + interface[0] * m * lost) * cosine
            for f, b, m in zip(self.fresnel(interface, cos_h), base, multiple)
        ]
        share = self.glossy_share(lobe, wi.z)
        # Density of visible normals over the Jacobian of reflection: D G1(wi) / (4 cos_i), Heitz 2018, Eq. 17.
        visible = d / (1.0 + lambda_i) / (4.0 * wi.z)
        return mi.Color3f(*value), share * visible + (1.0 - share) * wo.z / math.pi

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs = mi.BSDFSample3f()
        wi = si.wi
        if wi.z <= 0.0:
            return bs, mi.Color3f(0.0)
        lobe = self.lobe(si)
        glossy = sample1 < self.glossy_share(lobe, wi.z)
        if glossy:
            half, _ = lobe[3].sample(wi, sample2)
            bs.wo = mi.reflect(wi, half)
        else:
            bs.wo = mi.warp.square_to_cosine_hemisphere(sample2)
        value, bs.pdf = self.evaluated(lobe, wi, bs.wo)
        bs.eta = 1.0
        bs.sampled_component = 0 if glossy else 1
        bs.sampled_type = +(mi.BSDFFlags.GlossyReflection if glossy else mi.BSDFFlags.DiffuseReflection)
        return bs, value / bs.pdf if bs.pdf > 0.0 else mi.Color3f(0.0)

    def eval(self, ctx, si, wo, active=True):
        return self.evaluated(self.lobe(si), si.wi, wo)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.evaluated(self.lobe(si), si.wi, wo)[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.evaluated(self.lobe(si), si.wi, wo)

    def to_string(self):
        return "LapidaryGgx[]"


def register():
    """Makes `<bsdf type="lapidary_ggx">` known; call it after `mi.set_variant`."""
    mi.register_bsdf("lapidary_ggx", LapidaryGgx)
