"""Write scripts/trajectories/sun_june.csv: a solar tracker follows the sun through a day.

    python scripts/make_sun_trajectory.py            write the file
    python scripts/make_sun_trajectory.py --check    compare it with a fresh calculation

Place and day: 48 deg North, 11 deg East, the solstice of 21 June 2024, the longest day; from the
minute when the sun has risen to 20 deg in the morning to when it sinks below 20 deg.

Sun. The low-precision formulas of the Astronomical Almanac, as given by J. J. Michalsky, "The
Astronomical Almanac's algorithm for approximate solar position (1950-2050)", Solar Energy 40(3),
1988, doi:10.1016/0038-092X(88)90045-X: good to 0.01 deg. Refraction (0.05 deg at 20 deg) and the
parallax (0.002 deg) are left out. 0.01 deg is 1e-4 of the angles, far below what sizing feels.

Axes of the mechanism: R1 vertical, so base z points up; base x north, y west. The panel lies on
the platform's plate, its normal along the platform's z. The platform turns by Rz(theta1)
R-y(theta2), so the normal is (-sin theta2 cos theta1, -sin theta2 sin theta1, cos theta2), and
theta2 is the sun's zenith angle, theta1 its azimuth from south towards east (positive before
noon). theta2 stays within 24.6 .. 70 deg: well below the singularity at 90 deg, and away from 0
deg, where the azimuth would jump.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import trajectory_script

from pinmech.actuation.motion.trajectory import Trajectory

LATITUDE, LONGITUDE = 48.0, 11.0  # deg, east positive
DAY = datetime(2024, 6, 21, tzinfo=UTC)
LOWEST = 20.0  # deg, elevation of the sun at both ends
STEP = 60.0  # s
FILE = trajectory_script.FOLDER / "sun_june.csv"

Array = np.ndarray


def sun(days: Array, latitude: float, longitude: float) -> tuple[Array, Array]:
    """Elevation (N,) [rad] and azimuth (N,) [rad] of the sun, from south towards east.

    Args:
        days: days since 2000-01-01T12:00 UT (N,).
        latitude, longitude: [deg], north and east positive.
    """
    mean_longitude = np.radians(280.460 + 0.9856474 * days)
    anomaly = np.radians(357.528 + 0.9856003 * days)
    ecliptic = mean_longitude + np.radians(1.915 * np.sin(anomaly) + 0.020 * np.sin(2 * anomaly))
    obliquity = np.radians(23.439 - 4e-7 * days)
    right_ascension = np.arctan2(np.cos(obliquity) * np.sin(ecliptic), np.cos(ecliptic))
    declination = np.arcsin(np.sin(obliquity) * np.sin(ecliptic))
    hours = 24.0 * ((days + 0.5) % 1.0)  # universal time
    sidereal = np.radians(15.0 * (6.697375 + 0.0657098242 * days + hours) + longitude)
    hour_angle = (sidereal - right_ascension + np.pi) % (2 * np.pi) - np.pi  # positive after noon
    north = np.radians(latitude)
    up = np.sin(north) * np.sin(declination) + np.cos(north) * np.cos(declination) * np.cos(
        hour_angle
    )
    east = -np.cos(declination) * np.sin(hour_angle)
    south = np.sin(north) * np.cos(declination) * np.cos(hour_angle) - np.cos(north) * np.sin(
        declination
    )
    return np.arctan2(up, np.hypot(east, south)), np.arctan2(east, south)


def day() -> tuple[Trajectory, list[str]]:
    """The tracker's motion through the day, and the comments of its file."""
    begin = (DAY - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
    clock = np.arange(0.0, 86_400.0, STEP)
    elevation, azimuth = sun(begin + clock / 86_400.0, LATITUDE, LONGITUDE)
    high = np.flatnonzero(elevation >= np.radians(LOWEST))
    kept = slice(int(high[0]), int(high[-1]) + 1)
    start = DAY + timedelta(seconds=float(clock[kept][0]))
    comments = [
        "A solar tracker follows the sun through a day. Written by scripts/make_sun_trajectory.py.",
        f"{LATITUDE:g} deg North, {LONGITUDE:g} deg East; time 0 is {start:%Y-%m-%dT%H:%M:%SZ}; "
        f"one sample every {STEP:g} s,",
        f"as long as the sun stands at least {LOWEST:g} deg high.",
        "Base axes: x north, y west, z up. theta1 is the sun's azimuth from south towards east,",
        "theta2 its zenith angle: the platform's z axis looks at the sun.",
    ]
    values = np.round(np.column_stack([azimuth, np.pi / 2 - elevation])[kept], 12)
    return Trajectory(("theta1", "theta2"), clock[kept] - clock[kept][0], values), comments


def main(arguments: list[str] | None = None) -> int:
    """Write or check the file; the exit code is 0 when all is well."""
    description = "Write the trajectory of a solar tracker."
    return trajectory_script.run(day, FILE, arguments, description=description)


if __name__ == "__main__":
    raise SystemExit(main())
