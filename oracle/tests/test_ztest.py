"""Tests of the statistics on numbers with a known distribution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from oracle import ztest
from oracle.ztest import Answer, Estimate


def noisy(random: np.random.Generator, count: int, scale: float = 0.1) -> np.ndarray:
    return 1 + scale * random.normal(size=(count, 16, 24, 3))


def test_p_of_equals_is_uniform() -> None:
    """Tests that 3456 of Welch's p-values, from samples with equal means, are uniform (Kolmogorov-Smirnov)."""
    random = np.random.default_rng(3)
    found = [
        ztest.welch(Estimate.of_samples(noisy(random, 8)), Estimate.of_samples(noisy(random, 20, 0.3)))[1]
        for _ in range(3)
    ]
    assert stats.kstest(np.ravel(found), "uniform").pvalue > 0.001


def test_welch_is_scipys() -> None:
    random = np.random.default_rng(4)
    a, b = noisy(random, 7), noisy(random, 12, 0.4)
    t, p = ztest.welch(Estimate.of_samples(a), Estimate.of_samples(b))
    scipys = stats.ttest_ind(a, b, equal_var=False)
    np.testing.assert_allclose(t, scipys.statistic, rtol=1e-6)
    np.testing.assert_allclose(p, scipys.pvalue, rtol=1e-5)


def test_sidak_is_the_chance_of_one_among_many() -> None:
    assert ztest.family_p(np.array([0.5, 0.01])) == pytest.approx(1 - 0.99**2)
    assert ztest.family_p(np.array([1e-20, 0.5, 0.5])) == pytest.approx(3e-20)
    assert ztest.family_p(np.ones(5)) == 1.0


def test_false_alarms_are_as_rare_as_stated() -> None:
    """At a significance of 0.1, about 20 of 200 comparisons of equal distributions fail."""
    random = np.random.default_rng(5)
    alarms = 0
    for _ in range(200):
        a, b = (Estimate.of_samples(noisy(random, 10)) for _ in range(2))
        alarms += ztest.compare({1: (a, b)}, significance=0.1).different
    assert 6 <= alarms <= 38  # 4 standard deviations of a binomial


def test_one_pixel_off_is_found_and_named() -> None:
    random = np.random.default_rng(6)
    a, b = noisy(random, 16), noisy(random, 16)
    a[:, 5, 7, 1] += 1.0
    verdict = ztest.compare({1: (Estimate.of_samples(a), Estimate.of_samples(b))})
    assert verdict.different
    assert verdict.levels[0].place == "(7, 5) green"


def test_blocks_are_means_of_what_the_mask_leaves() -> None:
    renders = np.stack([np.full((4, 4, 3), value) for value in (1.0, 3.0)])
    renders[:, 0, 0] = 100.0
    mask = np.ones((4, 4, 3))
    mask[0, 0] = 0
    found = ztest.of_renders(renders, 2, mask)
    assert found.mean.shape == (2, 2, 3)
    np.testing.assert_allclose(found.mean, 2.0)
    whole = ztest.of_renders(renders, ztest.WHOLE, mask)
    np.testing.assert_allclose(whole.mean, np.full((1, 1, 3), 2.0))


def test_values_without_noise_are_compared_to_rounding() -> None:
    flat = Estimate(np.full((2, 2, 3), 12.0), np.zeros((2, 2, 3)), np.full((2, 2, 3), 9.0))
    rounded = Estimate(flat.mean * (1 + 1e-6), flat.stderr, flat.dof)
    other = Estimate(flat.mean * 1.01, flat.stderr, flat.dof)
    assert ztest.compare({8: (flat, rounded)}).same
    assert ztest.compare({8: (flat, other)}).different


def rare(random: np.random.Generator, count: int, share: float) -> np.ndarray:
    """Samples with the mean 1, of which only a share is not black."""
    return (random.random((count, 32, 48, 3)) < share) / share


def test_rare_light_is_undecided_and_not_different() -> None:
    """One sample in 20 has all of the light: 8 samples say that a pixel is black, or far too bright."""
    random = np.random.default_rng(7)
    truth = Estimate(np.ones((32, 48, 3)), np.full((32, 48, 3), 1e-3), np.full((32, 48, 3), 31.0))
    few = ztest.Estimate.of_samples(rare(random, 8, 0.05)).steadied()
    assert not few.is_normal
    verdict = ztest.compare({1: (few, truth)})
    assert verdict.answer is Answer.UNDECIDED
    assert "too few samples to judge pixels" in str(verdict)
    # Means of blocks have enough samples, and agree.
    whole = ztest.of_renders(rare(random, 8, 0.05), ztest.WHOLE, np.ones((32, 48, 3)))
    exact = Estimate(np.ones((1, 1, 3)), np.full((1, 1, 3), 1e-3), np.full((1, 1, 3), 31.0))
    assert whole.is_normal
    assert ztest.compare({ztest.WHOLE: (whole, exact)}).same
    assert ztest.compare({1: (few, truth), ztest.WHOLE: (whole, exact)}).answer is Answer.UNDECIDED


def test_a_difference_that_is_judged_outweighs_what_is_not() -> None:
    random = np.random.default_rng(8)
    truth = Estimate(np.ones((32, 48, 3)), np.full((32, 48, 3), 1e-3), np.full((32, 48, 3), 31.0))
    few = ztest.Estimate.of_samples(rare(random, 8, 0.05)).steadied()
    darker = Estimate(np.full((1, 1, 3), 0.9), np.full((1, 1, 3), 1e-3), np.full((1, 1, 3), 7.0))
    exact = Estimate(np.ones((1, 1, 3)), np.full((1, 1, 3), 1e-3), np.full((1, 1, 3), 31.0))
    assert ztest.compare({1: (few, truth), ztest.WHOLE: (darker, exact)}).different


def test_the_skewness_is_that_of_the_distribution() -> None:
    """Exponential samples have the skewness 2, for which Cochran's rule asks for 100 samples; normal ones have none."""
    random = np.random.default_rng(9)
    exponential = random.exponential(size=(400, 32, 48, 3))
    assert ztest.skewness(exponential) == pytest.approx(2.0, abs=0.15)
    assert Estimate.of_samples(exponential[:120]).is_normal
    assert not Estimate.of_samples(exponential[:60]).is_normal
    for count in (4, 8, 16):
        assert Estimate.of_samples(noisy(random, count)).is_normal
        assert Estimate.of_samples(random.normal(size=(count, 1, 1, 3))).is_normal
    assert ztest.skewness(np.ones((8, 4, 4, 3))) == 0.0
