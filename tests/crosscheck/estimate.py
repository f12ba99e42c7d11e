"""Error of a noisy picture against another noisy picture, without the noise.

Each renderer makes two pictures of independent noise, a1, a2 and b1, b2. The noises of (a1 - b1) and (a2 - b2) are independent of each
other, so that the mean of their product over the pixels is the squared difference of the two expected pictures: nothing has to
be subtracted, and the estimate is as often too low as too high.
"""

from dataclasses import asdict, dataclass

import numpy as np


@dataclass
class Estimate:
    """Relative RMSE of expected pictures; zero where noise hides the difference."""

    error: float
    # One standard error above the estimate.
    at_most: float
    # Relative RMSE that noise gives each mean of two pictures.
    noise: float
    noise_of_reference: float
    # Sum of the picture over sum of the reference.
    energy: float

    def as_dict(self):
        return asdict(self)


def relative_error(pictures, references):
    """`pictures` and `references`: two arrays each, of height x width x 3."""
    a1, a2, b1, b2 = (np.asarray(p, np.float64) for p in [*pictures, *references])
    if not a1.shape == a2.shape == b1.shape == b2.shape:
        raise ValueError(f"pictures of several sizes: {a1.shape}, {a2.shape}, {b1.shape}, {b2.shape}")
    for picture in (a1, a2, b1, b2):
        bad = np.count_nonzero(~np.isfinite(picture))
        if bad:
            raise ValueError(f"{bad} values of a picture are not finite")
    power = np.mean(b1 * b2)
    if not power > 0.0:
        raise ValueError("the reference is black")
    squares = np.mean((a1 - b1) * (a2 - b2), axis=2)
    mean, spread = squares.mean(), squares.std() / np.sqrt(squares.size)

    def relative(square):
        return float(np.sqrt(max(square, 0.0) / power))

    return Estimate(
        error=relative(mean),
        at_most=relative(max(mean, 0.0) + spread),
        noise=relative(np.mean((a1 - a2) ** 2) / 4.0),
        noise_of_reference=relative(np.mean((b1 - b2) ** 2) / 4.0),
        energy=float((a1 + a2).sum() / (b1 + b2).sum()),
    )
