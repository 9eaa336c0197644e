"""The schema of a sizing case file: what may stand in scripts/cases/<name>.yaml.

Strict, like the schema of a description file: unknown keys, wrong types and numbers that are not
finite are faults. What needs the mechanism is checked in :mod:`pinmech.actuation.sizing.case`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, ConfigDict, Discriminator, Field, FiniteFloat, Tag

Name = Annotated[str, Field(min_length=1, max_length=200)]
Text = Annotated[str, Field(min_length=1, max_length=2000)]
Vector3 = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Vector6 = Annotated[list[FiniteFloat], Field(min_length=6, max_length=6)]
Matrix3 = Annotated[list[Vector3], Field(min_length=3, max_length=3)]
Positive = Annotated[FiniteFloat, Field(gt=0)]
NotNegative = Annotated[FiniteFloat, Field(ge=0)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


def _inertia_kind(value: Any) -> str:
    rows = isinstance(value, list) and any(isinstance(row, list) for row in value)
    return "matrix" if rows else "numbers"


Inertia = Annotated[
    Union[Annotated[Vector6, Tag("numbers")], Annotated[Matrix3, Tag("matrix")]],  # noqa: UP007
    Discriminator(_inertia_kind),
]


class PayloadSpec(_Strict):
    """What the platform carries."""

    mass: NotNegative = Field(description="[kg]")
    com: Vector3 = Field(default=[0.0, 0.0, 0.0], description="centre of mass, platform axes [m]")
    inertia: Inertia = Field(
        default=[0.0] * 6,
        description="about the centre of mass, platform axes [kg m2]: three rows of three, or "
        "ixx, ixy, ixz, iyy, iyz, izz (the order of URDF)",
    )

    def matrix(self) -> list[list[float]]:
        """The inertia as three rows of three [kg m2]."""
        if len(self.inertia) == 3:
            return [[float(x) for x in row] for row in self.inertia]  # type: ignore[union-attr]
        xx, xy, xz, yy, yz, zz = (float(x) for x in self.inertia)  # type: ignore[arg-type]
        return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


class JointFrictionSpec(_Strict):
    """Friction of one joint."""

    coulomb: NotNegative = Field(default=0.0, description="dry friction [N m or N]")
    viscous: NotNegative = Field(default=0.0, description="[N m s/rad or N s/m]")


class FrictionSpec(_Strict):
    """Joint friction instead of what the URDF says."""

    only: bool = Field(
        default=False, description="true: joints not named here have none; false: as in the URDF"
    )
    joints: dict[Name, JointFrictionSpec] = Field(
        description="joint name, or pattern with * and ?, to its friction; later entries win"
    )


class SlewSpec(_Strict):
    """A straight line in the outputs from rest to rest."""

    type: Literal["slew"]
    law: Literal["poly345", "poly4567"] = "poly4567"
    unit: Literal["rad", "deg"] = Field(default="rad", description="of the angles; lengths in m")
    start: dict[Name, FiniteFloat] = Field(alias="from", description="every output at the start")
    goal: dict[Name, FiniteFloat] = Field(alias="to", description="every output at the end")
    duration: Positive = Field(description="[s]")
    step: Positive | None = Field(default=None, description="[s]; left out: 401 samples")


class SweepSpec(_Strict):
    """Sines on the outputs that start and end at rest."""

    type: Literal["sweep"]
    unit: Literal["rad", "deg"] = Field(default="rad", description="of the angles; lengths in m")
    centre: dict[Name, FiniteFloat] | None = Field(default=None, description="left out: zero")
    amplitude: dict[Name, FiniteFloat] = Field(description="of every output")
    cycles: dict[Name, Annotated[int, Field(ge=0)]] = Field(description="of every output")
    duration: Positive = Field(description="[s]")
    ramp: Annotated[FiniteFloat, Field(gt=0, le=0.5)] = Field(
        default=0.1, description="part of the duration for the smooth start, and for the end"
    )
    step: Positive | None = Field(default=None, description="[s]; left out: 401 samples")


class LoadCaseSpec(_Strict):
    """One load case: a motion under gravity and a wrench. Trajectory or profile, not both."""

    name: Name
    gravity: Vector3 = Field(description="base axes [m/s2]; standing on Earth: [0, 0, -9.81]")
    trajectory: Name | None = Field(default=None, description="CSV file, relative to this file")
    profile: Annotated[SlewSpec | SweepSpec, Field(discriminator="type")] | None = None
    wrench: Vector6 = Field(
        default=[0.0] * 6,
        description="force [N], then moment [N m], of the world on the platform at its frame's "
        "origin, base axes",
    )


class CaseSpec(_Strict):
    """A whole case file."""

    schema_version: Literal[1] = Field(alias="schema", description="version of this format")
    name: Name
    title: str = ""
    assumptions: list[Text] = Field(default=[], description="printed below the tables")
    mechanism: Name = Field(description="built-in name, or description file relative to this file")
    payload: PayloadSpec | None = None
    friction: FrictionSpec | None = None
    drives: Annotated[list[Name], Field(min_length=1)] | None = Field(
        default=None, description="names of the drives to compare; left out: all"
    )
    sharing: Literal["min_norm", "weighted"] = Field(
        default="min_norm", description="how a redundant drive shares its torques"
    )
    load_cases: Annotated[list[LoadCaseSpec], Field(min_length=1)]


def case_schema() -> dict[str, Any]:
    """JSON schema of a case file, for editors."""
    schema = CaseSpec.model_json_schema(by_alias=True)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "pinmech sizing case"
    return schema
