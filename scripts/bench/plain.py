"""Plain Newton on Pinocchio as most people write it: readable, fresh arrays, no tricks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

import pinmech as pm
from bench.cases import STEPS, TOLERANCE, Case, Motion, Run, spherical_pairs
from bench.clock import now

Array = np.ndarray

WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def along(case: Case, free: list[int], held: list[int], newton: Callable[[Array], int]) -> Run:
    """Solve a case pose by pose with ``newton(q)``, which works in place and counts its steps."""
    q, steps = case.start.copy(), 0
    answers = np.empty((len(case.values), len(q)))
    begin = now()
    for k, values in enumerate(case.values):
        if case.restart:
            q[:] = case.start
        q[held] = values
        steps += newton(q)
        answers[k] = q
    return Run(now() - begin, answers, steps / len(case.values))


class PlainFrames:
    """Loop gaps and Jacobians from frames: ``updateFramePlacements`` and ``getFrameJacobian``."""

    name = "plain Newton on Pinocchio (frames)"

    def __init__(self, mech: pm.Mechanism) -> None:
        self.model, self.length = mech.model, mech.length
        self.data = self.model.createData()
        self.names = list(mech.joints)
        self.pairs = [
            (self.model.getFrameId(a), self.model.getFrameId(b)) for a, b in spherical_pairs(mech)
        ]
        self.outputs = [self.names.index(name) for name in mech.outputs]

    def solve(self, case: Case) -> Run:
        """Newton in the coordinates that are not given."""
        held = [self.names.index(name) for name in case.held]
        free = [k for k in range(self.model.nv) if k not in held]
        model, data, tolerance = self.model, self.data, TOLERANCE * self.length

        def newton(q: Array) -> int:
            for step in range(STEPS):
                pin.computeJointJacobians(model, data, q)
                pin.updateFramePlacements(model, data)
                e = np.concatenate(
                    [data.oMf[b].translation - data.oMf[a].translation for a, b in self.pairs]
                )
                if np.linalg.norm(e) < tolerance:
                    return step
                jacobian = np.vstack(
                    [
                        pin.getFrameJacobian(model, data, b, WORLD)[:3]
                        - pin.getFrameJacobian(model, data, a, WORLD)[:3]
                        for a, b in self.pairs
                    ]
                )
                q[free] -= np.linalg.solve(jacobian[:, free], e)
            return STEPS

        return along(case, free, held, newton)

    def dynamics(self, motion: Motion) -> Run:
        """Null space by ``solve``, ``rnea``, and a pseudo-inverse for the redundant drive."""
        model, data = self.model, self.data
        held = self.outputs
        free = [k for k in range(model.nv) if k not in held]
        driven = [self.names.index(name) for name in motion.joints]
        answers = np.empty((len(motion.rates), len(driven)))
        begin = now()
        rows = zip(motion.path.q, motion.rates, motion.accelerations, strict=True)
        for k, (q, rate, acceleration) in enumerate(rows):
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            jacobian = np.vstack(
                [
                    pin.getFrameJacobian(model, data, b, WORLD)[:3]
                    - pin.getFrameJacobian(model, data, a, WORLD)[:3]
                    for a, b in self.pairs
                ]
            )
            basis = np.zeros((model.nv, len(held)))
            basis[held] = np.eye(len(held))
            basis[free] = -np.linalg.solve(jacobian[:, free], jacobian[:, held])
            v = basis @ rate
            pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
            drift = np.concatenate(
                [
                    pin.getFrameClassicalAcceleration(model, data, b, WORLD).linear
                    - pin.getFrameClassicalAcceleration(model, data, a, WORLD).linear
                    for a, b in self.pairs
                ]
            )
            a = basis @ acceleration
            a[free] -= np.linalg.solve(jacobian[:, free], drift)
            tau = pin.rnea(model, data, q, v, a)
            answers[k] = np.linalg.pinv(basis[driven].T) @ (basis.T @ tau)
        return Run(now() - begin, answers)


class PlainConstraints:
    """Loop gaps and Jacobian from Pinocchio's constraint models, through the variant."""

    name = "plain Newton on Pinocchio (constraint models)"

    def __init__(self, mech: pm.Mechanism) -> None:
        self.model, self.length = mech.model, mech.length
        self.data = self.model.createData()
        self.names = list(mech.joints)
        spherical_pairs(mech)
        self.models = mech.constraint_models()
        self.datas = pin.StdVec_ConstraintData()
        for constraint in self.models:
            self.datas.append(constraint.createData())

    def solve(self, case: Case) -> Run:
        """Newton in the coordinates that are not given."""
        held = [self.names.index(name) for name in case.held]
        free = [k for k in range(self.model.nv) if k not in held]
        model, data, tolerance = self.model, self.data, TOLERANCE * self.length

        def newton(q: Array) -> int:
            for step in range(STEPS):
                pin.computeJointJacobians(model, data, q)
                for constraint, scratch in zip(self.models, self.datas, strict=True):
                    constraint.calc(model, data, scratch)
                e = np.concatenate(
                    [scratch.extract().constraint_position_error for scratch in self.datas]
                )
                if np.linalg.norm(e) < tolerance:
                    return step
                jacobian = pin.getConstraintsJacobian(model, data, self.models, self.datas)
                q[free] -= np.linalg.solve(jacobian[:, free], e)
            return STEPS

        return along(case, free, held, newton)
