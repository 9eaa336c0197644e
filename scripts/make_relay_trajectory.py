"""Write scripts/trajectories/relay_iss.csv: a relay satellite's antenna follows the ISS.

    python scripts/make_relay_trajectory.py            write the file
    python scripts/make_relay_trajectory.py --check    compare it with a fresh calculation

A geostationary relay satellite at 31 deg East follows the International Space Station over one
whole visible arc, from the first time it rises behind the Earth after the epoch of the elements to
when it sets. Needs sgp4: pip install 'pinmech[orbit]'.

Frames. sgp4 gives positions in TEME. A turn by Greenwich mean sidereal time (IAU 1982) makes them
Earth-fixed; TEME is defined by the mean equinox, so GMST is the right angle and no equation of
the equinoxes enters. Left out: polar motion (below 0.6", 20 m) and UT1 - UTC (-0.17 s at that date,
80 m at the ISS). Seen from 36 000 km, 80 m are 2e-6 rad, less than the elements themselves are off
(kilometres), and 1e-5 of the angles. The relay satellite is ideal: it stands still in the
Earth-fixed frame, on the equator.

Satellite axes: z to the Earth's centre, x east, y south (x cross y = z). The antenna's base frame
has the satellite's axes. Pointing direction is the paper's eq. (16), P = (sin b, -sin a cos b,
cos a cos b), so b = asin P_x and a = atan2(-P_y, P_z).

Visible: the line of sight keeps 100 km above the WGS-84 ellipsoid (clear of the atmosphere). The
ellipsoid raised by that height is taken as an ellipsoid with both semi-axes longer by it.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import trajectory_script

from pinmech.actuation.motion.trajectory import Trajectory
from pinmech.errors import MissingExtraError, PinmechError

TLE = (
    "1 25544U 98067A   19343.69339541  .00001764  00000-0  38792-4 0  9991",
    "2 25544  51.6439 211.2001 0007417  17.6667  85.6398 15.50103472202482",
)
LONGITUDE = np.radians(31.0)
GEOSTATIONARY_RADIUS = 42_164.17  # km, of an orbit that takes one sidereal day
EQUATORIAL_RADIUS, FLATTENING = 6_378.137, 1 / 298.257223563  # WGS-84, km
ATMOSPHERE = 100.0  # km
STEP = 10.0  # s
FILE = trajectory_script.FOLDER / "relay_iss.csv"

Array = np.ndarray


def satellite() -> Any:
    """The ISS as an sgp4 satellite record."""
    try:
        from sgp4.api import Satrec
    except ImportError:
        raise MissingExtraError("sgp4", "orbit") from None
    return Satrec.twoline2rv(*TLE)


def gmst(jd: Array, fraction: Array) -> Array:
    """Greenwich mean sidereal time (IAU 1982) [rad] of a Julian date in two parts (UT1).

    Source: D. Vallado, Fundamentals of Astrodynamics and Applications, eq. 3-45.
    """
    # 876600 h of the linear term are whole turns a day: taking them out keeps the digits.
    t = ((jd - 2_451_545.0) + fraction) / 36_525.0
    days = (jd - 2_451_545.0) % 1.0 + fraction
    seconds = 67_310.54841 + 8_640_184.812866 * t + 0.093104 * t**2 - 6.2e-6 * t**3
    return (2 * np.pi * (seconds / 86_400.0 + days)) % (2 * np.pi)


def iss(record: Any, seconds: Array) -> Array:
    """Earth-fixed positions of the ISS (N, 3) [km], seconds after the epoch of the elements."""
    jd = np.full(len(seconds), record.jdsatepoch)
    fraction = record.jdsatepochF + seconds / 86_400.0
    errors, teme, _ = record.sgp4_array(jd, fraction)
    if errors.any():
        raise PinmechError(f"sgp4 failed with code {errors[errors != 0][0]}")
    angle = gmst(jd, fraction)
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = teme.T
    return np.column_stack([cos * x + sin * y, cos * y - sin * x, z])


def axes() -> tuple[Array, Array]:
    """The relay satellite: its position (3,) [km] and its axes as rows (3, 3), Earth-fixed."""
    up = np.array([np.cos(LONGITUDE), np.sin(LONGITUDE), 0.0])
    east = np.array([-np.sin(LONGITUDE), np.cos(LONGITUDE), 0.0])
    return GEOSTATIONARY_RADIUS * up, np.array([east, [0.0, 0.0, -1.0], -up])


def clearance(target: Array) -> Array:
    """Least distance of the line of sight from the Earth's centre, in units of the ellipsoid.

    Args:
        target: Earth-fixed positions (N, 3) [km].

    Returns:
        (N,): at least 1 where the line of sight to the relay keeps clear of the ellipsoid that is
        raised by the atmosphere.
    """
    polar_radius = EQUATORIAL_RADIUS * (1 - FLATTENING)
    shrink = 1 / (np.array([EQUATORIAL_RADIUS, EQUATORIAL_RADIUS, polar_radius]) + ATMOSPHERE)
    start, way = target * shrink, (axes()[0] - target) * shrink
    part = np.clip(-np.sum(start * way, axis=1) / np.sum(way * way, axis=1), 0.0, 1.0)
    return np.linalg.norm(start + part[:, None] * way, axis=1)


def pointing(target: Array) -> tuple[Array, Array]:
    """Angles alpha, beta (N,) [rad] that point the antenna at Earth-fixed positions (N, 3) [km]."""
    position, rows = axes()
    sight = (target - position) @ rows.T
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    return np.arctan2(-sight[:, 1], sight[:, 2]), np.arcsin(sight[:, 0])


def arc() -> tuple[Trajectory, list[str]]:
    """The first whole visible arc after the epoch, and the comments of its file."""
    record = satellite()
    # Whole seconds of UTC, so that the file's time 0 is a date that reads well.
    epoch = datetime(2000, 1, 1, 12, tzinfo=UTC) + timedelta(
        days=record.jdsatepoch - 2_451_545.0 + record.jdsatepochF
    )
    start = epoch.replace(microsecond=0) + timedelta(seconds=1)
    lead = (start - epoch).total_seconds()
    clock = np.arange(0.0, 4 * 3600.0)
    visible = clearance(iss(record, lead + clock)) >= 1
    rises = np.flatnonzero(~visible[:-1] & visible[1:]) + 1
    first = int(rises[0])
    last = first + int(np.flatnonzero(~visible[first:])[0]) - 1
    time = np.arange(0.0, last - first + 0.5, STEP)
    alpha, beta = pointing(iss(record, lead + first + time))
    begin = start + timedelta(seconds=first)
    comments = [
        "A geostationary relay satellite at 31 deg East follows the International Space Station",
        "over one visible arc, from rise to set. Written by scripts/make_relay_trajectory.py.",
        f"Time 0 is {begin:%Y-%m-%dT%H:%M:%SZ}; the ISS sets {last - first} s later; "
        f"one sample every {STEP:g} s.",
        "Satellite axes: z to the Earth's centre, x east, y south; the antenna's base frame has",
        "the same axes. Pointing direction (sin beta, -sin alpha cos beta, cos alpha cos beta).",
        "Visible: the line of sight keeps 100 km above the WGS-84 ellipsoid.",
        f"Orbit: sgp4 from these elements, epoch {epoch:%Y-%m-%dT%H:%M:%SZ}; TEME turned to",
        "Earth-fixed by Greenwich mean sidereal time (IAU 1982).",
        *TLE,
    ]
    values = np.round(np.column_stack([alpha, beta]), 12)
    return Trajectory(("alpha", "beta"), time, values), comments


def main(arguments: list[str] | None = None) -> int:
    """Write or check the file; the exit code is 0 when all is well."""
    description = "Write the trajectory of a relay antenna."
    return trajectory_script.run(arc, FILE, arguments, description=description)


if __name__ == "__main__":
    raise SystemExit(main())
