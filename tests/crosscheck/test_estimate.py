"""The estimator of errors, on pictures whose difference is known."""

import unittest

import numpy as np

from estimate import relative_error

SHAPE = (60, 80, 3)


def noisy(picture, spread, seed):
    return picture + np.random.default_rng(seed).normal(0.0, spread, picture.shape)


class Estimates(unittest.TestCase):
    def setUp(self):
        self.truth = np.random.default_rng(5).uniform(0.5, 1.5, SHAPE)

    def estimate(self, scale, spread=0.1):
        ours = [noisy(scale * self.truth, spread, seed) for seed in (1, 2)]
        theirs = [noisy(self.truth, spread, seed) for seed in (3, 4)]
        return relative_error(ours, theirs)

    def test_noise_is_taken_off(self):
        same = self.estimate(1.0)
        self.assertLess(same.error, 0.012)
        self.assertAlmostEqual(same.noise, 0.1 / np.sqrt(2.0) / np.sqrt(np.mean(self.truth**2)), delta=0.002)

    def test_a_difference_below_the_noise_is_seen(self):
        self.assertAlmostEqual(self.estimate(1.03).error, 0.03, delta=0.006)
        self.assertAlmostEqual(self.estimate(1.03).energy, 1.03, delta=0.003)

    def test_the_spread_tells_when_there_is_too_much_noise(self):
        self.assertGreater(self.estimate(1.0, spread=1.0).at_most, 0.02)

    def test_pictures_that_cannot_be_compared_are_refused(self):
        good = [self.truth, self.truth]
        hole = self.truth.copy()
        hole[3, 4, 1] = np.nan
        for bad, words in [
            ([hole, self.truth], "1 values"),
            ([self.truth[:, 1:], self.truth], "several sizes"),
        ]:
            with self.assertRaisesRegex(ValueError, words):
                relative_error(bad, good)
        with self.assertRaisesRegex(ValueError, "black"):
            relative_error(good, [0.0 * self.truth] * 2)


if __name__ == "__main__":
    unittest.main()
