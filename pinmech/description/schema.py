"""The schema of a description file: what may stand in loops/<name>.yaml.

The schema is strict: unknown keys, wrong types and non-finite numbers are faults. Everything that
needs the URDF (do the frames exist?) is checked in :mod:`pinmech.description.references`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Union, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, FiniteFloat, Tag
from pydantic_core import PydanticCustomError

ClosureType = Literal[
    "spherical", "revolute", "universal", "cylindrical", "prismatic", "planar", "fixed"
]
#: All closure types.
CLOSURES: tuple[str, ...] = get_args(ClosureType)
#: What the joint of a closure that can have a cone is called in messages.
JOINT_NAMES = {"spherical": "ball joint", "universal": "universal joint"}
OutputKind = Literal["joints", "orientation", "translation", "pose"]

#: How many names each kind of output has; ``joints`` may have any number.
OUTPUT_COUNT: dict[str, int] = {"orientation": 3, "translation": 3, "pose": 6}

Name = Annotated[str, Field(min_length=1, max_length=200)]
#: No length [m] or angle [rad] is larger; what is would overflow on the way through the solver.
LARGEST = 1e9
Number = Annotated[FiniteFloat, Field(ge=-LARGEST, le=LARGEST)]
Vector3 = Annotated[list[Number], Field(min_length=3, max_length=3)]


def _whole(value: Any) -> Any:
    if isinstance(value, bool | float):  # True == 1.0 == 1, but neither is a version
        raise PydanticCustomError("literal_error", "Input should be 1")
    return value


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, populate_by_name=True)


class FrameSpec(_Strict):
    """A frame by its link and an offset: position ``xyz`` [m], then ``rpy`` [rad] as in URDF."""

    link: Name
    xyz: Vector3 = Field(default=[0.0, 0.0, 0.0], description="position in the link [m]")
    rpy: Vector3 = Field(default=[0.0, 0.0, 0.0], description="roll, pitch, yaw [rad], fixed axes")


def _frame_kind(value: Any) -> str:
    return "link" if isinstance(value, str) else "offset"


FrameOrLink = Annotated[
    Union[Annotated[Name, Tag("link")], Annotated[FrameSpec, Tag("offset")]],  # noqa: UP007
    Discriminator(_frame_kind),
]


class ConeSpec(_Strict):
    """How far a ball joint or a universal joint may tilt."""

    axes: Annotated[list[Vector3], Field(min_length=2, max_length=2)] = Field(
        description="the housing's axis in the first frame, the stud's in the second; of a "
        "universal joint the axes of its two shafts"
    )
    angle: Annotated[FiniteFloat, Field(gt=0, le=math.pi)] = Field(
        description="largest angle between the two axes [rad]"
    )


class LoopSpec(_Strict):
    """One loop closure: two frames that belong together when the loop is closed."""

    name: Name
    type: ClosureType = Field(
        description="revolute, cylindrical, prismatic: along the common z; planar: normal along z; "
        "universal: z of the first perpendicular to z of the second; spherical: origins coincide; "
        "fixed: frames coincide"
    )
    frames: Annotated[list[FrameOrLink], Field(min_length=2, max_length=2)]
    limit: ConeSpec | None = Field(
        default=None, description="cone of a spherical closure, tilt of a universal one"
    )


class ActuatorSpec(_Strict):
    """An actuator: actuator value = scale · joint value + offset [rad or m]."""

    name: Name
    joint: Name
    scale: Number = 1.0
    offset: Number = 0.0


class OutputsSpec(_Strict):
    """What the mechanism positions: joint values, or the pose of the platform frame."""

    kind: OutputKind
    names: Annotated[list[Name], Field(min_length=1)]


class Description(_Strict):
    """A whole description file."""

    schema_version: Annotated[Literal[1], BeforeValidator(_whole)] = Field(
        alias="schema", description="version of this format"
    )
    name: Name
    title: str = ""
    source: str = Field(default="", description="where the mechanism is published, e.g. doi:...")
    urdf: Name = Field(description="path of the open-tree URDF, relative to this file")
    platform: Name = Field(description="link whose frame is the output frame")
    loops: Annotated[list[LoopSpec], Field(min_length=1)]
    actuators: Annotated[list[ActuatorSpec], Field(min_length=1)]
    outputs: OutputsSpec
    drives: dict[Name, Annotated[list[Name], Field(min_length=1)]] | None = Field(
        default=None, description='named subsets of the actuators; left out: one drive, "all"'
    )
    home: dict[Name, Number] = Field(
        default={}, description="joint values [rad or m] from which the home state is assembled"
    )
    length: Annotated[FiniteFloat, Field(gt=0, le=LARGEST)] | None = Field(
        default=None, description="characteristic length [m]; left out: from the closure frames"
    )


def json_schema() -> dict[str, Any]:
    """JSON schema of a description file, for editors (``pinmech schema`` prints it)."""
    schema = Description.model_json_schema(by_alias=True)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "pinmech mechanism description"
    return schema
