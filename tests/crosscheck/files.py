"""Files that materials of the cases name, written anew in each run."""

from pathlib import Path

import numpy as np
from cases import IOR, PLASTIC_ALPHA
from microfacets import dielectric, visible_normals

HERE = Path(__file__).parent
# Entries of a MERL table along the angles of the half vector and the difference vector, and the azimuth of the latter.
MERL_SIZE = (90, 90, 180)
# Reflectance of a unit of red, green and blue of a MERL file.
MERL_SCALES = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)


def copy_principled(path):
    """The principled BRDF as a function."""
    path.write_text((HERE / "principled.wgsl").read_text())


def _masking(cos, alpha):
    return 2.0 / (1.0 + np.sqrt(1.0 + alpha**2 * (1.0 / cos**2 - 1.0)))


def _passed(cos_o, index, through):
    """Share of light under a cosine that goes through the rough dielectric, or is reflected, and that no other facet masks."""
    half, wo = visible_normals(max(cos_o, 1e-3), PLASTIC_ALPHA, side=64)
    cos_h = half @ wo
    reflected = dielectric(cos_h, index)
    if through:
        inner = np.sqrt(1.0 - (1.0 - cos_h**2) / index**2)
        share, cos_i = 1.0 - reflected, wo[2] / index + (inner - cos_h / index) * half[:, 2]
    else:
        share, cos_i = reflected, 2.0 * cos_h * half[:, 2] - wo[2]
    return np.mean(np.where(cos_i > 0.0, _masking(np.maximum(cos_i, 1e-6), PLASTIC_ALPHA), 0.0) * share)


def write_rough_plastic(path):
    """`rough_plastic.wgsl` with what its dielectric lets through."""
    cosines = np.linspace(0.0, 1.0, 64)
    transmitted = [_passed(c, IOR, through=True) for c in cosines]
    # The mean over these cosines with both ends whole, as Mitsuba has it; the integral is 0.421 in place of 0.415.
    inside = np.mean([2.0 * c * _passed(c, 1.0 / IOR, through=False) for c in cosines])
    text = (HERE / "rough_plastic.wgsl").read_text()
    head, code = text[: text.index("const PI")], text[text.index("const PI") :]
    for name, value in [
        ("TRANSMITTED", ", ".join(f"{t:.6f}" for t in transmitted)),
        ("INSIDE", f"{inside:.6f}"),
        ("ALPHA", str(PLASTIC_ALPHA)),
        ("COUNT", str(len(cosines))),
    ]:
        code = code.replace(name, value)
    path.write_text(head + code)


def merl_directions():
    """Half vector's cosine, and those of the directions to light and eye, in the middle of each entry."""
    n_h, n_d, n_p = MERL_SIZE
    middle = lambda n: (np.arange(n) + 0.5) / n
    theta_h = (0.5 * np.pi * middle(n_h) ** 2)[:, None, None]
    theta_d = (0.5 * np.pi * middle(n_d))[None, :, None]
    phi_d = (np.pi * middle(n_p))[None, None, :]
    # The difference vector, turned about y by the angle of the half vector: only its height is needed.
    across, along = -np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d), np.cos(theta_h) * np.cos(theta_d)
    return np.cos(theta_h), np.cos(theta_d), along + across, along - across


def write_merl(path):
    """A green plastic with a red highlight that no exchange of colours or angles leaves the same, as a file of the MERL database."""
    cos_h, cos_d, cos_i, cos_o = merl_directions()
    # Below the horizon, where nothing is measured, it goes on.
    cos_i, cos_o = (np.maximum(c, 1e-3) for c in (cos_i, cos_o))
    slope = (1.0 - cos_h**2) / PLASTIC_ALPHA**2 + cos_h**2
    d = 1.0 / (np.pi * PLASTIC_ALPHA**2 * slope**2)
    highlight = d * _masking(cos_i, PLASTIC_ALPHA) * _masking(cos_o, PLASTIC_ALPHA) / (4.0 * cos_i * cos_o)
    schlick = (1.0 - cos_d) ** 5
    with path.open("wb") as file:
        np.array(MERL_SIZE, "<i4").tofile(file)
        for scale, base, grazing in zip(MERL_SCALES, (0.05, 0.35, 0.1), (0.3, 0.1, 0.05)):
            plane = base / np.pi + (grazing + (1.0 - grazing) * schlick) * highlight
            (plane / scale).astype("<f8").tofile(file)


def write_even(path):
    """A sky without lamps, from 0.5 to 1.5 and coloured by its direction, as a Radiance file."""
    y, x = np.mgrid[0:32, 0:64]
    angle = 2.0 * np.pi * (x + 0.5) / 64
    sky = np.stack([1.0 + 0.5 * np.cos(angle), np.full(x.shape, 0.9), 1.0 - 0.5 * (y + 0.5) / 32], -1)
    exponent = np.ceil(np.log2(sky.max(-1, keepdims=True))).astype(int)
    texels = np.concatenate([np.clip(sky / 2.0**exponent * 256, 0, 255), exponent + 128], -1)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n"
    path.write_bytes(head + texels.astype(np.uint8).tobytes())
