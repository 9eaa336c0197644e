"""What is solved: the same poses for everybody, with the answers known beforehand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

import pinmech as pm

Array = np.ndarray

#: Stopping rule of the baselines: loop gap over the characteristic length.
TOLERANCE = 1e-10
#: How far an answer may be from the known one [rad; of torques relative to the largest].
AGREEMENT = 1e-6
#: Newton steps after which a baseline gives up.
STEPS = 30


@dataclass(frozen=True)
class Case:
    """A row of poses to solve.

    Attributes:
        name, title: for the command line and for the table.
        held: joints whose values are given.
        values: (N, n_held) their values [rad].
        start: (nq,) closed configuration to start from.
        restart: True when every pose starts from ``start``, False when from the one before.
        expected: (N, nq) the answers [rad].
    """

    name: str
    title: str
    held: tuple[str, ...]
    values: Array
    start: Array
    restart: bool
    expected: Array


@dataclass(frozen=True)
class Motion:
    """A motion whose torques are wanted.

    Attributes:
        path: the closed configurations.
        states: the same as states.
        rates, accelerations: (N, n_out) of the outputs [rad/s, rad/s²].
        drive: name of the drive; ``joints`` its joints.
        expected: (N, n_drive) torques of least norm [N·m].
    """

    path: pm.PosePath
    states: tuple[pm.ClosedState, ...]
    rates: Array
    accelerations: Array
    drive: str
    joints: tuple[str, ...]
    expected: Array


@dataclass(frozen=True)
class Run:
    """What a contender did with a case.

    Attributes:
        seconds: for all poses.
        answers: (N, nq) configurations, or (N, n_drive) torques.
        steps: Newton steps per pose; NaN where there are none.
    """

    seconds: float
    answers: Array
    steps: float = float("nan")


def smooth(count: int) -> tuple[Array, Array, Array]:
    """(N, 2) outputs, rates and accelerations of a closed curve of ±14 and ±11 deg in 10 s."""
    w = 2.0 * np.pi / 10.0
    t = np.linspace(0.0, 10.0, count)
    size, turns, phase = np.array([0.25, 0.2]), w * np.array([1.0, 2.0]), np.array([0.0, 0.4])
    angle = t[:, None] * turns + phase
    return size * np.sin(angle), size * turns * np.cos(angle), -size * turns**2 * np.sin(angle)


def scattered(count: int) -> Array:
    """(N, 2) outputs in random order within ±3 deg of a pose: nothing to extrapolate."""
    return np.array([0.1, -0.05]) + np.random.default_rng(1).uniform(-0.052, 0.052, (count, 2))


def kinematic_cases(mech: pm.Mechanism, count: int) -> list[Case]:
    """Inverse and forward kinematics along both paths, and pose by pose from home."""
    cases = []
    drive = mech.drive("12")
    columns = [list(mech.actuators).index(name) for name in drive]
    arms = tuple(mech.actuators[name].joint for name in drive)
    outputs = tuple(mech.outputs)
    title = {"smooth": "smooth path", "random": "nearby poses in random order"}
    for kind, wanted in (("smooth", smooth(count)[0]), ("random", scattered(count))):
        # Pose by pose and polished, so that no contender is judged by its own answers.
        states = [pm.inverse(mech, row).unwrap() for row in wanted]
        q = np.array([polished(mech, state.q, outputs) for state in states])
        actuators = mech.actuator_values(q)[:, columns]
        for way, held, values in (("inverse", outputs, wanted), ("forward", arms, actuators)):
            name = f"{way}_{kind}"
            cases.append(Case(name, f"`{way}_path`, {title[kind]}", held, values, q[0], False, q))
            if kind == "random":
                call = f"one `{way}` call, from home"
                cases.append(Case(f"{way}_call", call, held, values, mech.home.q, True, q))
    return cases


def motion(mech: pm.Mechanism, count: int) -> Motion:
    """The smooth path with its rates, driven by all three arms."""
    outputs, rates, accelerations = smooth(count)
    path = pm.inverse_path(mech, outputs)
    states = tuple(path.state(k) for k in range(count))
    expected = [
        list(pm.inverse_dynamics(s, v, a, drive="123").torques.values())
        for s, v, a in zip(states, rates, accelerations, strict=True)
    ]
    joints = tuple(mech.actuators[name].joint for name in mech.drive("123"))
    return Motion(path, states, rates, accelerations, "123", joints, np.array(expected))


def polished(mech: pm.Mechanism, q: Array, held: tuple[str, ...]) -> Array:
    """One more Newton step (dense, by numpy): the answer to the last digits."""
    state, data = pm.verify_closed(mech, q), mech.model.createData()
    pin.forwardKinematics(mech.model, data, q)
    free = [k for k, name in enumerate(mech.joints) if name not in held]
    gaps = []
    for loop in mech.loops.values():
        first, second = loop.frames
        one = data.oMi[first.joint] * first.placement
        two = data.oMi[second.joint] * second.placement
        gaps.append(one.actInv(two).translation)
    out = q.copy()
    out[free] -= np.linalg.solve(pm.closure_jacobian(state)[:, free], np.concatenate(gaps))
    return out


def residuals(mech: pm.Mechanism, q: Array) -> Array:
    """(N,) largest loop gap over the characteristic length, measured alike for everybody."""
    data = mech.model.createData()
    out = np.zeros(len(q))
    for k, row in enumerate(q):
        pin.forwardKinematics(mech.model, data, row)
        for loop in mech.loops.values():
            first, second = loop.frames
            gap = data.oMi[first.joint].act(first.placement.translation) - data.oMi[
                second.joint
            ].act(second.placement.translation)
            out[k] = max(out[k], float(np.linalg.norm(gap)) / mech.length)
    return out


def spherical_pairs(mech: pm.Mechanism) -> list[tuple[str, str]]:
    """Names of the two links of every loop; the baselines know spherical closures only."""
    pairs = []
    for loop in mech.loops.values():
        if loop.type != "spherical":
            raise SystemExit(f"the baselines know spherical closures only, not {loop.type}")
        pairs.append((loop.frames[0].label, loop.frames[1].label))
    return pairs
