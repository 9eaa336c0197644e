"""Sharing by itself: torques, gain, preload and what a drive cannot produce, by numpy and hand."""

from __future__ import annotations

import numpy as np
import pytest

from pinmech.actuation.forces.sharing import check_sharing, share
from pinmech.errors import InputError


def matrix(rows: int, columns: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(rows, columns))


@pytest.mark.parametrize(("rows", "columns"), [(2, 2), (2, 3), (3, 4), (3, 2), (2, 1)])
@pytest.mark.parametrize("weights", ["even", "uneven"])
def test_share_is_the_weighted_pseudoinverse(rows: int, columns: int, weights: str) -> None:
    a, b = matrix(rows, columns, 1), matrix(rows, 1, 2)[:, 0]
    w = np.ones(columns) if weights == "even" else np.arange(1.0, columns + 1)
    found = share(a, b, w)
    gain = w[:, None] * np.linalg.pinv(a * w)
    np.testing.assert_allclose(found.gain, gain, atol=1e-12)
    np.testing.assert_allclose(found.torques, gain @ b, atol=1e-12)
    np.testing.assert_allclose(found.unbalanced, b - a @ gain @ b, atol=1e-12)
    assert found.preload.shape == (columns, max(0, columns - rows))
    np.testing.assert_allclose(a @ found.preload, 0, atol=1e-12)
    assert found.beyond.shape == (rows, max(0, rows - columns))
    np.testing.assert_allclose(found.beyond.T @ a, 0, atol=1e-12)
    np.testing.assert_allclose(found.beyond.T @ found.beyond, np.eye(found.beyond.shape[1]))


def test_distance_is_the_smallest_singular_value_over_the_largest() -> None:
    for a in (np.diag([4.0, 1.0]), np.array([[0, 4.0, 0], [0, 0, 1.0]])):
        assert share(a, np.ones(2), np.ones(a.shape[1])).distance == pytest.approx(0.25)


def test_a_drive_with_too_few_actuators_is_at_distance_zero() -> None:
    """Three motions and two actuators: one is always free, however well the two do."""
    a = np.array([[2.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    found = share(a, np.array([2.0, 3.0, 5.0]), np.ones(2))
    assert found.distance == 0.0
    np.testing.assert_allclose(found.torques, [1.0, 3.0])
    np.testing.assert_allclose(found.unbalanced, [0.0, 0.0, 5.0], atol=1e-12)
    np.testing.assert_allclose(np.abs(found.beyond), [[0], [0], [1]], atol=1e-12)


def test_a_singular_drive_produces_what_it_can() -> None:
    a = np.array([[1.0, 0.0], [0.0, 1e-9]])
    found = share(a, np.array([3.0, 1.0]), np.ones(2))
    np.testing.assert_allclose(found.torques, [3.0, 0.0])
    np.testing.assert_allclose(found.unbalanced, [0.0, 1.0])
    assert found.distance == pytest.approx(1e-9)
    assert (found.beyond.shape, found.preload.shape) == ((2, 1), (2, 1))


def test_a_drive_that_moves_nothing() -> None:
    found = share(np.zeros((2, 2)), np.array([1.0, 2.0]), np.ones(2))
    np.testing.assert_array_equal(found.torques, 0.0)
    np.testing.assert_allclose(found.unbalanced, [1.0, 2.0])
    assert (found.distance, found.preload.shape) == (0.0, (2, 2))


def test_weights_are_ratios_of_the_effort_limits() -> None:
    np.testing.assert_array_equal(check_sharing("min_norm", np.array([5.0, np.inf])), [1, 1])
    np.testing.assert_allclose(check_sharing("weighted", np.array([5.0, 20.0])), [0.25, 1.0])
    with pytest.raises(InputError, match="some actuators have none"):
        check_sharing("weighted", np.array([5.0, np.inf]))
