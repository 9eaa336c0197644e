"""Fixtures that several test folders share: the built-in antenna mechanisms, loaded once."""

from __future__ import annotations

import pytest

import pinmech as pm


@pytest.fixture(scope="session")
def antenna() -> pm.Mechanism:
    """antenna_3rsu: Table 1, universal strut."""
    return pm.load("antenna_3rsu")


@pytest.fixture(scope="session")
def wide() -> pm.Mechanism:
    """antenna_3rsu_wide: Table 2, universal strut."""
    return pm.load("antenna_3rsu_wide")


@pytest.fixture(scope="session")
def antenna_s() -> pm.Mechanism:
    """antenna_3rsu_s: Table 1, spherical strut."""
    return pm.load("antenna_3rsu_s")
