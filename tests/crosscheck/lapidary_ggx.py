"""The `ggx` model of Lapidary as a BSDF of Mitsuba 3, written from the papers and not from Lapidary's source.

    f = (1 - F) (1 - metalness) base / pi  +  F D G2 / (4 cos_i cos_o)

* D: anisotropic GGX (Walter et al. 2007, Eq. 33; Heitz 2014, Eq. 85) of alpha = roughness^2, stretched by the aspect
  sqrt(1 - 0.9 |anisotropy|) of Burley 2012.
* G2: height-correlated masking and shadowing of Smith, 1 / (1 + L(i) + L(o)) with L of Heitz 2014, Eq. 72 and 99.
* F: Schlick 1994 at the half vector, from f0 to f90. f0 goes from specular ((ior - 1) / (ior + 1))^2 to the base colour with the
  metalness, f90 from specular to 1.

Mitsuba's own plugins are not of this form: `roughconductor` and `principled` mask and shadow independently, `roughplastic`
scatters between base and coat. Half vectors are drawn by Mitsuba's own distribution of visible normals.
"""

import math

import mitsuba as mi

MIN_ALPHA = 1e-3


def _number(props, name, default):
    return props[name] if name in props else default


def _smith_lambda(v, alpha_x, alpha_y):
    tan_sq = ((alpha_x * v.x) ** 2 + (alpha_y * v.y) ** 2) / (v.z * v.z)
    return 0.5 * (math.sqrt(1.0 + tan_sq) - 1.0)


class LapidaryGgx(mi.BSDF):
    """For scalar variants: one direction at a time."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base_color = props.get_texture("base_color")
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
        """Base colour, f0, f90, metalness, alphas and microfacets at a point."""
        if self.constant is not None:
            return self.constant
        is_map = [isinstance(number, mi.Texture) for number in self.numbers]
        values = [n.eval_1(si) if m else n for n, m in zip(self.numbers, is_map)]
        roughness, metalness, anisotropy, specular, above_one = values
        color = self.base_color.eval(si)
        base = (color[0], color[1], color[2])
        dielectric = specular * (above_one / (above_one + 2.0)) ** 2
        f0 = tuple(dielectric + metalness * (b - dielectric) for b in base)
        f90 = specular + metalness * (1.0 - specular)
        aspect = math.sqrt(1.0 - 0.9 * abs(anisotropy))
        alpha = roughness * roughness
        long, short = (min(max(a, MIN_ALPHA), 1.0) for a in (alpha / aspect, alpha * aspect))
        alphas = (long, short) if anisotropy >= 0.0 else (short, long)
        microfacets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alphas[0], alphas[1], True)
        found = (base, f0, f90, metalness, alphas, microfacets)
        if not any(is_map) and not self.base_color.is_spatially_varying():
            self.constant = found
        return found

    def glossy_share(self, lobe, cos):
        """Probability that a half vector is drawn and not a direction of the base."""
        base, f0, f90, metalness, _, _ = lobe
        grazing = (1.0 - cos) ** 5
        glossy = sum(f + (f90 - f) * grazing for f in f0)
        diffuse = sum(base) * (1.0 - metalness)
        return max(0.2, glossy / max(glossy + diffuse, 1e-6)) if diffuse > 0.0 else 1.0

    def evaluated(self, lobe, wi, wo):
        """BRDF times cosine, and density, of one pair of directions."""
        if wi.z <= 0.0 or wo.z <= 0.0:
            return mi.Color3f(0.0), 0.0
        base, f0, f90, metalness, (ax, ay), microfacets = lobe
        x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        cos_h = min(0.5 * length, 1.0)
        slope = (x / ax) ** 2 + (y / ay) ** 2 + z * z
        d = 1.0 / (math.pi * ax * ay * slope * slope)
        lambda_i = _smith_lambda(wi, ax, ay)
        g = 1.0 / (1.0 + lambda_i + _smith_lambda(wo, ax, ay))
        specular = d * g / (4.0 * wi.z)  # times the cosine of the light
        grazing = (1.0 - cos_h) ** 5
        base_cos = (1.0 - metalness) * wo.z / math.pi
        fresnel = [f + (f90 - f) * grazing for f in f0]
        value = [(1.0 - f) * b * base_cos + f * specular for f, b in zip(fresnel, base)]
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
            half, _ = lobe[5].sample(wi, sample2)
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
