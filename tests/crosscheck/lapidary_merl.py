"""Files of the MERL database (Matusik et al. 2003) as a BSDF of Mitsuba 3, whose own `measured` reads another format.

It looks a pair of directions up as the database's reader does: the entry that the angles of half and difference vector
(Rusinkiewicz 1998) fall into, without interpolation. Half of the directions are drawn from a GGX lobe of `alpha`.
"""

import math

import mitsuba as mi
import numpy as np

# Entries along the angle of the half vector, that of the difference vector, and its azimuth.
HALF, DIFFERENCE, AZIMUTH = 90, 90, 180
SCALES = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)


def read(path):
    """Reflectance by colour, as flat lists."""
    with open(path, "rb") as file:
        size = np.fromfile(file, "<i4", 3)
        if tuple(size) != (HALF, DIFFERENCE, AZIMUTH):
            raise ValueError(f"{path}: a table of {tuple(size)}")
        planes = np.fromfile(file, "<f8").reshape(3, -1)
    return [np.maximum(plane * scale, 0.0) for plane, scale in zip(planes, SCALES)]


def entry(wi, wo):
    """Index of the entry of two directions of unit length."""
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    length = math.sqrt(x * x + y * y + z * z)
    theta = math.acos(min(z / length, 1.0))
    phi = math.atan2(y, x)
    # The light, turned so that the half vector becomes the normal.
    east = math.cos(phi) * wi.x + math.sin(phi) * wi.y
    north = math.cos(phi) * wi.y - math.sin(phi) * wi.x
    tilted = math.cos(theta) * east - math.sin(theta) * wi.z
    height = math.sin(theta) * east + math.cos(theta) * wi.z
    difference = math.acos(min(max(height, -1.0), 1.0))
    azimuth = math.atan2(north, tilted) % math.pi
    i = min(int(math.sqrt(theta / (0.5 * math.pi)) * HALF), HALF - 1)
    j = min(int(difference / (0.5 * math.pi) * DIFFERENCE), DIFFERENCE - 1)
    k = min(int(azimuth / math.pi * AZIMUTH), AZIMUTH - 1)
    return (i * DIFFERENCE + j) * AZIMUTH + k


class LapidaryMerl(mi.BSDF):
    """For scalar variants: one direction at a time."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.planes = read(props["filename"])
        self.microfacets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, props["alpha"], props["alpha"], True)
        glossy = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        self.m_components = [glossy]
        self.m_flags = glossy

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs = mi.BSDFSample3f()
        if si.wi.z <= 0.0:
            return bs, mi.Color3f(0.0)
        if sample1 < 0.5:
            bs.wo = mi.reflect(si.wi, self.microfacets.sample(si.wi, sample2)[0])
        else:
            bs.wo = mi.warp.square_to_cosine_hemisphere(sample2)
        bs.pdf = self.pdf(ctx, si, bs.wo)
        bs.eta = 1.0
        bs.sampled_component = 0
        bs.sampled_type = +mi.BSDFFlags.GlossyReflection
        return bs, self.eval(ctx, si, bs.wo) / bs.pdf if bs.pdf > 0.0 else mi.Color3f(0.0)

    def eval(self, ctx, si, wo, active=True):
        if si.wi.z <= 0.0 or wo.z <= 0.0:
            return mi.Color3f(0.0)
        at = entry(si.wi, wo)
        return mi.Color3f(*(float(plane[at]) * wo.z for plane in self.planes))

    def pdf(self, ctx, si, wo, active=True):
        if si.wi.z <= 0.0 or wo.z <= 0.0:
            return 0.0
        half = mi.Normal3f(*(a + b for a, b in zip(si.wi, wo)))
        length = math.sqrt(half.x**2 + half.y**2 + half.z**2)
        half = mi.Normal3f(half.x / length, half.y / length, half.z / length)
        glossy = self.microfacets.pdf(si.wi, half) / (2.0 * length)
        return 0.5 * glossy + 0.5 * wo.z / math.pi

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo), self.pdf(ctx, si, wo)

    def to_string(self):
        return "LapidaryMerl[]"


def register():
    """Makes `<bsdf type="lapidary_merl">` known; call it after `mi.set_variant`."""
    mi.register_bsdf("lapidary_merl", LapidaryMerl)
