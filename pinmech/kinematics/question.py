"""What is asked of inverse kinematics, what an answer is, and what is seen on the way to one."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from pinmech.equations.continuation import Tracked
from pinmech.equations.limits import limit_breaches
from pinmech.equations.outputs import pose_of
from pinmech.equations.problem import Pose, Problem
from pinmech.kinematics.limb_solver import LimbAnswer
from pinmech.mechanism.mechanism import Mechanism
from pinmech.structure.closures import ClosureSystem, Configuration

Array = np.ndarray


@dataclass
class Seen:
    """What strategies met that is no answer; :mod:`pinmech.kinematics.refusals` reads it.

    Attributes:
        iterations: linear systems solved.
        outputs_beyond: the limit that an output itself breaks; empty if none.
        open_by: how far given joints leave the loops open [m].
        limbs: limbs that fail, each with its reason.
        rootless: limb whose equation has no root at this pose; empty if none.
        beyond: the limit that a solution breaks; empty if none.
        other_mode: a solution in another working mode was met.
        no_such_mode: the mode asked for does not exist at the pose of the guess.
        tracked: where the continuation ended.
    """

    iterations: int = 0
    outputs_beyond: str = ""
    open_by: float = 0.0
    limbs: list[LimbAnswer] = field(default_factory=list)
    rootless: str = ""
    beyond: str = ""
    other_mode: bool = False
    no_such_mode: bool = False
    tracked: Tracked | None = None


@dataclass
class Question:
    """Outputs that are asked for.

    Attributes:
        mechanism, system: the mechanism, and scratch memory.
        target: (n_out,) outputs [rad, m].
        start: (nq,) closed joint values to start from.
        signs: (n_equations,) signs that the labels shall have, 0 for any; None where labels do not
            tell where the start is.
        limits: whether limits count.
        seen: what was met so far.
    """

    mechanism: Mechanism
    system: ClosureSystem
    target: Array
    start: Array
    signs: Array | None
    limits: bool
    seen: Seen = field(default_factory=Seen)

    @property
    def joints(self) -> bool:
        """True when the outputs are joints."""
        return self.mechanism.outputs.kind == "joints"

    @property
    def held(self) -> Array:
        """Indices of the coordinates that the outputs hold."""
        return self.mechanism.facts.outputs_held.held

    @property
    def free(self) -> Array:
        """Indices of the others."""
        return self.mechanism.facts.outputs_held.free

    @cached_property
    def problem(self) -> Problem:
        """The equations that the outputs leave."""
        if self.joints:
            return Problem(self.mechanism, self.free)
        return Problem(self.mechanism, self.free, pose=self.pose)

    @cached_property
    def pose(self) -> Pose:
        """The pose that outputs other than joints ask for."""
        return pose_of(self.mechanism, self.target)

    def place(self) -> Array:
        """The start with the held coordinates where they shall be, a copy."""
        q = self.start.copy()
        if self.joints:
            q[self.held] = self.target
        return q

    def poses(self, q: Array) -> pin.Data:
        """Where the bodies are at q, closed or not."""
        return self.system.place(q)

    def in_mode(self, at: Configuration) -> bool:
        """True when a configuration is in the working mode asked for, as far as labels tell."""
        return self.signs is None or self.mechanism.facts.labels.agree(self.signs, at)

    def breaches(self, q: Array) -> list[str]:
        """Limits that closed joint values break, if limits count."""
        return limit_breaches(self.mechanism, q) if self.limits else []


@dataclass(frozen=True)
class Answer:
    """Joint values that answer a question.

    Attributes:
        q: (nq,) [rad or m].
        at: the equations there.
        regular: True when it is known that no two working modes meet there.
    """

    q: Array
    at: Configuration
    regular: bool = False
