"""Half vectors of a GGX surface on a regular grid of random numbers, for integrals by numpy."""

import numpy as np


def visible_normals(cos_o, alpha, side):
    """`side` x `side` normals that are seen under a cosine, as a spherical cap (Dupuy and Benyoub 2023), and the direction to the eye."""
    u, v = (grid.ravel() for grid in np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2))
    wo = np.array([np.sqrt(max(0.0, 1.0 - cos_o * cos_o)), 0.0, cos_o])
    stretched = np.array([alpha * wo[0], 0.0, wo[2]])
    stretched /= np.linalg.norm(stretched)
    z = (1.0 - v) * (1.0 + stretched[2]) - stretched[2]
    sine = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
    cap = np.stack([sine * np.cos(2 * np.pi * u), sine * np.sin(2 * np.pi * u), z], 1) + stretched
    half = cap * np.array([alpha, alpha, 1.0])
    half[:, 2] = np.maximum(half[:, 2], 1e-9)
    return half / np.linalg.norm(half, axis=1, keepdims=True), wo


def dielectric(cos, index):
    """Fresnel's factor of a dielectric; 1 where all is reflected."""
    inner = np.sqrt(np.maximum(1.0 - (1.0 - cos**2) / index**2, 0.0))
    across = (cos - index * inner) / (cos + index * inner)
    along = (index * cos - inner) / (index * cos + inner)
    return 0.5 * (across**2 + along**2)
