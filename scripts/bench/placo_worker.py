"""placo solves the poses: a process of its own, because placo needs Pinocchio 3.8.

Needs numpy and placo only. Reads one case per line from stdin and answers with one line of JSON.
Best practice as in placo's documentation: floating base masked, one solver for the whole path,
hard relative position tasks close the loops, a joints task holds what is given; no
visualisation, collisions not loaded, no dt, no velocity limits.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import numpy as np
import placo  # type: ignore[import-not-found]

Array = np.ndarray
STEPS = 30


class Loop:
    """A placo solver for one choice of given joints."""

    def __init__(
        self, setup: dict[str, Any], held: list[str], *, limits: bool, tolerance: float
    ) -> None:
        self.robot = placo.RobotWrapper(setup["urdf"], placo.Flags.ignore_collisions)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        for name, (low, high) in setup["limits"].items():
            self.robot.set_joint_limits(name, low, high)
        self.solver.enable_joint_limits(limits)
        self.solver.enable_velocity_limits(False)
        self.closures = []
        for first, second in setup["pairs"]:
            task = self.solver.add_relative_position_task(first, second, np.zeros(3))
            task.configure(f"{first}-{second}", "hard", 1.0)
            self.closures.append(task)
        self.held = held
        self.joints = self.solver.add_joints_task()
        self.joints.set_joints(dict.fromkeys(held, 0.0))
        # Hard is a little faster than soft here and reaches the same answers.
        self.joints.configure("given", "hard", 1.0)
        self.solver.add_regularization_task(1e-6)
        self.now = {"cpu": time.thread_time, "wall": time.perf_counter}[setup["clock"]]
        self.tolerance = tolerance * setup["length"]
        self.index = np.array([self.robot.get_joint_offset(name) for name in setup["names"]])

    def put(self, q: Array) -> None:
        """Set the joints to q (nq,) in the order of the mechanism."""
        whole = self.robot.state.q.copy()
        whole[self.index] = q
        self.robot.state.q = whole
        self.robot.update_kinematics()

    def solve(self, values: Array, start: Array, restart: bool) -> tuple[float, Array, float]:
        """Seconds, answers (N, nq) and steps per pose."""
        robot, solver, closures, joints = self.robot, self.solver, self.closures, self.joints
        held, tolerance, steps = self.held, self.tolerance, 0
        answers = np.empty((len(values), len(self.index)))
        self.put(start)
        whole = robot.state.q.copy()
        begin = self.now()
        for k, row in enumerate(values.tolist()):
            if restart:
                robot.state.q = whole
                robot.update_kinematics()
            for name, value in zip(held, row, strict=True):
                joints.set_joint(name, value)
            for _ in range(STEPS):
                solver.solve(True)
                robot.update_kinematics()
                steps += 1
                for task in closures:
                    task.update()
                if max([task.error_norm() for task in closures]) < tolerance:
                    break
            answers[k] = robot.state.q[self.index]
        return self.now() - begin, answers, steps / len(values)


def main() -> None:
    """Serve cases until stdin ends."""
    with open(sys.argv[1], encoding="utf-8") as file:
        setup = json.load(file)
    loops: dict[tuple[Any, ...], Loop] = {}
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        task = json.loads(line)
        key = (tuple(task["held"]), task["limits"], task["tolerance"])
        if key not in loops:
            loops[key] = Loop(
                setup, task["held"], limits=task["limits"], tolerance=task["tolerance"]
            )
        with np.load(task["case"]) as case:
            values, start = case["values"], case["start"]
        seconds, answers, steps = loops[key].solve(values, start, task["restart"])
        np.save(task["answers"], answers)
        print(json.dumps({"seconds": seconds, "steps": steps}), flush=True)


if __name__ == "__main__":
    main()
