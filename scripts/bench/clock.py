"""The clock of the benchmark.

CPU time of the calling thread, so that whatever else the machine is doing does not count; on an
idle machine it is the wall time, as nobody here needs a second thread. ``wall`` for wall time.
"""

from __future__ import annotations

import time

CLOCKS = {"cpu": time.thread_time, "wall": time.perf_counter}
_used = ["cpu"]


def use(kind: str) -> None:
    """Choose ``cpu`` or ``wall``."""
    if kind not in CLOCKS:
        raise ValueError(f"no clock {kind!r}; known: {', '.join(CLOCKS)}")
    _used[0] = kind


def used() -> str:
    """The clock in use."""
    return _used[0]


def now() -> float:
    """Seconds."""
    return CLOCKS[_used[0]]()
