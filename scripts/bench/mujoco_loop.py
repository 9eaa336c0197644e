"""The same Newton on MuJoCo: as most people write it, and with as much care as pinmech's own."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

import pinmech as pm
from bench.cases import STEPS, TOLERANCE, Case, Motion, Run, spherical_pairs
from bench.clock import now
from bench.plain import along

Array = np.ndarray

#: The careful loop goes as far as pinmech does.
TIGHT = 1e-12


def mjcf(mech: pm.Mechanism) -> str:
    """The same tree for MuJoCo: bodies, hinges and inertias from the Pinocchio model, one site
    for each frame of a loop. The loops stay open."""
    model = mech.model

    def text(values: Array) -> str:
        return " ".join(repr(float(x)) for x in values)

    def place(pose: pin.SE3) -> str:
        x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
        return f'pos="{text(pose.translation)}" quat="{text(np.array([w, x, y, z]))}"'

    sites: dict[int, list[str]] = {k: [] for k in range(model.njoints)}
    for loop in mech.loops.values():
        for frame in loop.frames:
            sites[frame.joint].append(f'<site name="{frame.label}" {place(frame.placement)}/>')

    def body(k: int) -> str:
        joint, inertia = model.joints[k], model.inertias[k]
        if joint.nq != 1 or not mech.turning[joint.idx_v]:
            raise SystemExit(f"the MuJoCo baseline knows hinges only, not {joint.shortname()}")
        scratch = joint.createData()
        joint.calc(scratch, np.zeros(model.nq))
        axis = np.asarray(scratch.S).reshape(6)[3:]
        i = inertia.inertia
        full = np.array([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
        parts = [
            f'<body name="{model.names[k]}" {place(model.jointPlacements[k])}>',
            f'<joint name="{model.names[k]}" type="hinge" axis="{text(axis)}"/>',
            f'<inertial pos="{text(inertia.lever)}" mass="{inertia.mass!r}" '
            f'fullinertia="{text(full)}"/>',
            *sites[k],
            *(body(child) for child in range(1, model.njoints) if model.parents[child] == k),
            "</body>",
        ]
        return "\n".join(parts)

    roots = [body(k) for k in range(1, model.njoints) if model.parents[k] == 0]
    gravity = text(model.gravity.linear)
    return "\n".join(
        [
            '<mujoco><compiler angle="radian"/>',
            f'<option gravity="{gravity}"><flag constraint="disable"/></option><worldbody>',
            *sites[0],
            *roots,
            "</worldbody></mujoco>",
        ]
    )


class _Mujoco:
    def __init__(self, mech: pm.Mechanism) -> None:
        self.model = mujoco.MjModel.from_xml_string(mjcf(mech))
        self.data = mujoco.MjData(self.model)
        self.length, self.names = mech.length, list(mech.joints)
        found = [self.model.joint(k).name for k in range(self.model.njnt)]
        if found != self.names:
            raise SystemExit(f"MuJoCo orders the joints differently: {found}")
        self.pairs = [
            (self.model.site(a).id, self.model.site(b).id) for a, b in spherical_pairs(mech)
        ]
        self.outputs = [self.names.index(name) for name in mech.outputs]

    def _split(self, names: tuple[str, ...]) -> tuple[list[int], list[int]]:
        held = [self.names.index(name) for name in names]
        return held, [k for k in range(self.model.nv) if k not in held]


class MujocoPlain(_Mujoco):
    """Readable: fresh arrays, ``mj_jacSite``, ``np.linalg.solve``."""

    name = "MuJoCo, plainly written"

    def solve(self, case: Case) -> Run:
        """Newton in the coordinates that are not given."""
        model, data, tolerance = self.model, self.data, TOLERANCE * self.length
        held, free = self._split(case.held)

        def newton(q: Array) -> int:
            for step in range(STEPS):
                data.qpos[:] = q
                mujoco.mj_kinematics(model, data)
                mujoco.mj_comPos(model, data)
                e = np.concatenate([data.site_xpos[b] - data.site_xpos[a] for a, b in self.pairs])
                if np.linalg.norm(e) < tolerance:
                    return step
                rows = []
                for a, b in self.pairs:
                    one, two = np.zeros((3, model.nv)), np.zeros((3, model.nv))
                    mujoco.mj_jacSite(model, data, one, None, a)
                    mujoco.mj_jacSite(model, data, two, None, b)
                    rows.append(two - one)
                q[free] -= np.linalg.solve(np.vstack(rows)[:, free], e)
            return STEPS

        return along(case, free, held, newton)

    def dynamics(self, motion: Motion) -> Run:
        """``mj_jacDot`` for the drift, ``mj_inverse`` for the open tree, ``pinv`` for the drive."""
        model, data = self.model, self.data
        held, free = self.outputs, [k for k in range(model.nv) if k not in self.outputs]
        driven = [self.names.index(name) for name in motion.joints]
        answers = np.empty((len(motion.rates), len(driven)))
        begin = now()
        rows = zip(motion.path.q, motion.rates, motion.accelerations, strict=True)
        for k, (q, rate, acceleration) in enumerate(rows):
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            jacobian = self._stack(mujoco.mj_jac)
            basis = np.zeros((model.nv, len(held)))
            basis[held] = np.eye(len(held))
            basis[free] = -np.linalg.solve(jacobian[:, free], jacobian[:, held])
            v = basis @ rate
            data.qvel[:] = v
            mujoco.mj_comVel(model, data)
            drift = self._stack(mujoco.mj_jacDot) @ v
            a = basis @ acceleration
            a[free] -= np.linalg.solve(jacobian[:, free], drift)
            data.qacc[:] = a
            mujoco.mj_inverse(model, data)
            answers[k] = np.linalg.pinv(basis[driven].T) @ (basis.T @ data.qfrc_inverse)
        return Run(now() - begin, answers)

    def _stack(self, jac) -> Array:  # type: ignore[no-untyped-def]
        model, data = self.model, self.data
        rows = []
        for a, b in self.pairs:
            one, two = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            jac(model, data, one, None, data.site_xpos[a], model.site_bodyid[a])
            jac(model, data, two, None, data.site_xpos[b], model.site_bodyid[b])
            rows.append(two - one)
        return np.vstack(rows)


class MujocoCareful(_Mujoco):
    """Nothing allocated that need not be, LAPACK called directly, Jacobians only when needed."""

    name = "MuJoCo, with equal care"

    def __init__(self, mech: pm.Mechanism) -> None:
        super().__init__(mech)
        rows, nv = 3 * len(self.pairs), self.model.nv
        self.one, self.two = np.zeros((rows, nv)), np.zeros((rows, nv))
        self.jacobian = np.zeros((rows, nv))
        self.sites = [
            (a, b, self.one[3 * k : 3 * k + 3], self.two[3 * k : 3 * k + 3])
            for k, (a, b) in enumerate(self.pairs)
        ]
        self.bodies = [
            (a, b, int(self.model.site_bodyid[a]), int(self.model.site_bodyid[b]), one, two)
            for a, b, one, two in self.sites
        ]
        self.first = np.array([a for a, _ in self.pairs])
        self.second = np.array([b for _, b in self.pairs])

    def _fill(self) -> Array:
        model, data, jac = self.model, self.data, mujoco.mj_jacSite
        for a, b, one, two in self.sites:
            jac(model, data, one, None, a)
            jac(model, data, two, None, b)
        return np.subtract(self.two, self.one, out=self.jacobian)

    def solve(self, case: Case) -> Run:
        """Newton in the coordinates that are not given."""
        model, data = self.model, self.data
        bound = (TIGHT * self.length) ** 2
        held, free_list = self._split(case.held)
        free = np.array(free_list)
        positions, qpos = data.site_xpos, data.qpos
        first, second = self.first, self.second
        place, centre, solve = mujoco.mj_kinematics, mujoco.mj_comPos, lapack.dgesv

        def newton(q: Array) -> int:
            for step in range(STEPS):
                qpos[:] = q
                place(model, data)
                e = (positions.take(second, 0) - positions.take(first, 0)).ravel()
                if e.dot(e) <= bound:
                    return step
                centre(model, data)
                q[free] -= solve(self._fill().take(free, 1), e)[2]
            return STEPS

        return along(case, free_list, held, newton)

    def dynamics(self, motion: Motion) -> Run:
        """One LU for basis and drift, ``mj_rne`` for the open tree."""
        model, data = self.model, self.data
        held = np.array(self.outputs)
        free = np.array([k for k in range(model.nv) if k not in self.outputs])
        driven = np.array([self.names.index(name) for name in motion.joints])
        basis = np.zeros((model.nv, len(held)))
        basis[held] = np.eye(len(held))
        tau = np.zeros(model.nv)
        qpos, qvel, qacc, positions = data.qpos, data.qvel, data.qacc, data.site_xpos
        answers = np.empty((len(motion.rates), len(driven)))
        begin = now()
        for k in range(len(motion.rates)):
            qpos[:] = motion.path.q[k]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            jacobian = self._fill()
            lu, pivots, x, _ = lapack.dgesv(jacobian.take(free, 1), jacobian.take(held, 1))
            basis[free] = -x
            v = basis @ motion.rates[k]
            qvel[:] = v
            mujoco.mj_comVel(model, data)
            for a, b, body_a, body_b, one, two in self.bodies:
                mujoco.mj_jacDot(model, data, one, None, positions[a], body_a)
                mujoco.mj_jacDot(model, data, two, None, positions[b], body_b)
            drift = np.subtract(self.two, self.one, out=self.jacobian) @ v
            acceleration = basis @ motion.accelerations[k]
            acceleration[free] -= lapack.dgetrs(lu, pivots, drift)[0]
            qacc[:] = acceleration
            mujoco.mj_rne(model, data, 1, tau)
            # Least norm of the torques u with A u = b and A (2, 3): u = Aᵀ (A Aᵀ)⁻¹ b.
            arms = basis[driven]
            answers[k] = arms @ lapack.dgesv(arms.T @ arms, basis.T @ tau)[2]
        return Run(now() - begin, answers)
