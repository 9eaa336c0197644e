"""MuJoCo as a second engine: its mass matrix, bias and Jacobians, projected on the motions that
its own closure Jacobian allows. Nothing of pinmech's algebra and nothing of Pinocchio in it.

MuJoCo's equality constraints are soft; so the closures are taken as exact rows, the difference of
the velocities of the two points that belong together, and never simulated.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from kinematics import platforms
from kinematics.loaded import loads, motion, states, uneven
from kinematics.sampling import DIMENSIONS

import pinmech as pm

mujoco = pytest.importorskip("mujoco")

Array = np.ndarray


class Engine:
    """The open tree of a mechanism in MuJoCo, with a payload bolted to the platform."""

    def __init__(self, mech: pm.Mechanism, urdf: str, description: str, world: pm.Loads) -> None:
        self.mech, self.world = mech, world
        text = re.sub(r"<(visual|collision)\b.*?</\1>", "", urdf, flags=re.DOTALL)
        text = re.sub(r"<dynamics[^>]*/>", "", text)
        # MuJoCo wants positive inertia on each moving body; links of a virtual chain have none.
        text = re.sub(r'<link name="(v\d)"\s*/>', _speck, text)
        if world.payload is not None:
            i = np.array(world.payload.inertia)
            parts = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
            parts["izz"] = (2, 2)
            inertia = " ".join(f'{key}="{float(i[at])!r}"' for key, at in parts.items())
            text = text.replace(
                "</robot>",
                f'<link name="payload"><inertial><origin xyz="{_row(world.payload.com)}"/>'
                f'<mass value="{world.payload.mass!r}"/><inertia {inertia}/></inertial></link>'
                f'<joint name="bolt" type="fixed"><parent link="{mech.platform}"/>'
                '<child link="payload"/></joint></robot>',
            )
        compiler = (
            '<mujoco><compiler fusestatic="false" balanceinertia="false" discardvisual="true" '
            'inertiafromgeom="false" strippath="false" angle="radian"/></mujoco>'
        )
        text = re.sub(r"(<robot\b[^>]*>)", rf"\1{compiler}", text, count=1)
        text = re.sub(r"<\?xml[^>]*\?>", "", text)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.model.opt.gravity[:] = world.gravity
        self.data = mujoco.MjData(self.model)
        assert self.model.nv == mech.model.nv
        self.order = [self.model.joint(name).dofadr[0] for name in mech.joints]
        assert sorted(self.order) == list(range(self.model.nv))
        self.pairs = _closure_points(description)

    def at(self, q: Array, v: Array) -> None:
        """Bring the tree to q and v, in the order of pinmech's joints."""
        self.data.qpos[self.order] = q
        self.data.qvel[self.order] = v
        mujoco.mj_forward(self.model, self.data)

    def _jacobian(self, body: str, offset: Array, dot: bool = False) -> tuple[Array, Array]:
        number = self.model.body(body).id
        turn = self.data.xmat[number].reshape(3, 3)
        point = self.data.xpos[number] + turn @ offset
        linear, angular = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        call = mujoco.mj_jacDot if dot else mujoco.mj_jac
        call(self.model, self.data, linear, angular, point, number)
        return linear[:, self.order], angular[:, self.order]

    def gaps(self) -> Array:
        """(loops, 3) how far the points that belong together are apart [m]."""
        out = []
        for (one, p), (two, r) in self.pairs:
            ends = []
            for body, offset in ((one, p), (two, r)):
                number = self.model.body(body).id
                ends.append(self.data.xpos[number] + self.data.xmat[number].reshape(3, 3) @ offset)
            out.append(ends[1] - ends[0])
        return np.array(out)

    def closure(self, dot: bool = False) -> Array:
        """(rows, nv) closure Jacobian, or its time derivative."""
        rows = [
            self._jacobian(two, r, dot)[0] - self._jacobian(one, p, dot)[0]
            for (one, p), (two, r) in self.pairs
        ]
        return np.vstack(rows)

    def mass(self) -> Array:
        """(nv, nv) mass matrix."""
        full = np.zeros((self.model.nv, self.model.nv))
        try:
            mujoco.mj_fullM(self.model, self.data, full)
        except TypeError:  # MuJoCo 3
            mujoco.mj_fullM(self.model, full, self.data.qM)
        return full[np.ix_(self.order, self.order)]

    def bias(self) -> Array:
        """(nv,) Coriolis, centrifugal and gravity forces."""
        return self.data.qfrc_bias[self.order].copy()

    def outputs(self, dot: bool = False) -> Array:
        """(n_out, nv) output rates per joint rate, or its time derivative."""
        outputs = self.mech.outputs
        if outputs.kind == "joints":
            rows = np.zeros((len(outputs), self.model.nv))
            for k, name in enumerate(outputs):
                rows[k, self.mech.joints.index(name)] = 0.0 if dot else 1.0
            return rows
        linear, angular = self._jacobian(self.mech.platform, np.zeros(3), dot)
        return {"pose": np.vstack([linear, angular]), "orientation": angular}[outputs.kind]

    def torques(self, q: Array, rates: Array, accelerations: Array, names: list[str]) -> Array:
        """(n_drive,) least-norm torques of the drive."""
        self.at(q, np.zeros(self.model.nv))
        closure = self.closure()
        free = np.linalg.svd(closure)[2][np.linalg.matrix_rank(closure, tol=1e-8) :].T
        motion = free @ np.linalg.inv(self.outputs() @ free)
        v = motion @ rates
        self.at(q, v)
        drift = self.closure(dot=True) @ v
        particular = -np.linalg.pinv(closure) @ drift
        lack = accelerations - self.outputs(dot=True) @ v - self.outputs() @ particular
        a = particular + motion @ lack
        model = self.mech.model
        rub = model.upperDryFrictionLimit * np.sign(v) + model.damping * v
        linear, angular = self._jacobian(self.mech.platform, np.zeros(3))
        wrench = np.array(self.world.wrench)
        world = linear.T @ wrench[:3] + angular.T @ wrench[3:]
        need = motion.T @ (self.mass() @ a + self.bias() + rub - world)
        actuators = [self.mech.actuators[name] for name in names]
        work = np.array([motion[x.coordinate] * x.scale for x in actuators])
        return np.linalg.pinv(work.T) @ need


def _row(values: object) -> str:
    return " ".join(repr(float(x)) for x in values)  # type: ignore[attr-defined]


def _speck(found: re.Match[str]) -> str:
    return (
        f'<link name="{found[1]}"><inertial><mass value="1e-12"/><inertia ixx="1e-14" '
        'iyy="1e-14" izz="1e-14" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _closure_points(description: str) -> list[tuple[tuple[str, Array], tuple[str, Array]]]:
    """Body and offset of each loop's two frames, read from the YAML by hand."""
    from ruamel.yaml import YAML

    pairs = []
    for loop in YAML(typ="safe").load(description)["loops"]:
        assert loop["type"] == "spherical"
        ends = []
        for frame in loop["frames"]:
            if isinstance(frame, str):
                ends.append((frame, np.zeros(3)))
            else:
                ends.append((frame["link"], np.array(frame.get("xyz", (0, 0, 0)), dtype=float)))
        pairs.append((ends[0], ends[1]))
    return pairs


def _texts(name: str) -> tuple[pm.Mechanism, str, str]:
    if name in DIMENSIONS:
        mech = uneven(name) if name != "antenna_3rsu_s" else pm.load(name)
        loops = pm.load(name).path
        assert loops is not None
        return mech, (loops.parent / f"../urdf/{name}.urdf").read_text(), loops.read_text()
    legs = {"stewart, seven legs": platforms.stewart(legs=7), "wrist": platforms.wrist(legs=4)}
    found = legs[name]
    mech = found.load().with_friction({"leg*": (0.01, 0.02)})
    return mech, found.urdf(), found.description()


NAMES = ["antenna_3rsu", "antenna_3rsu_wide", "antenna_3rsu_s", "stewart, seven legs", "wrist"]


@pytest.mark.parametrize("name", NAMES)
def test_torques_agree_with_mujoco(name: str) -> None:
    """Random states, motions, gravity, payload, wrench and friction; every drive."""
    mech, urdf, description = _texts(name)
    rng, worst = np.random.default_rng(111), 0.0
    for state in states(mech, 4, 112):
        world = loads(rng)
        engine = Engine(mech, urdf, description, world)
        rates, accelerations = motion(mech, rng)
        for drive, names in mech.drives.items():
            r = pm.inverse_dynamics(state, rates, accelerations, drive=drive, loads=world)
            expected = engine.torques(state.q, rates, accelerations, list(names))
            assert np.abs(engine.gaps()).max() < 1e-11  # MuJoCo agrees that the loops are closed
            found = np.array(list(r.torques.values()))
            off = np.abs(found - expected).max() / np.abs(expected).max()
            worst = max(worst, float(off))
    assert worst < 1e-9  # measured: 3e-12


@pytest.mark.parametrize("name", NAMES)
def test_mass_bias_and_closure_agree_with_mujoco(name: str) -> None:
    """The ingredients one by one, so that a disagreement is found where it arises."""
    import pinocchio as pin

    mech, urdf, description = _texts(name)
    rng = np.random.default_rng(113)
    state = states(mech, 1, 114)[0]
    engine = Engine(mech, urdf, description, pm.Loads())
    rates, accelerations = motion(mech, rng)
    v, a = pm.velocity(state, rates), pm.acceleration(state, rates, accelerations)
    engine.at(state.q, v)
    data = mech.model.createData()
    mass = pin.crba(mech.model, data, state.q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    np.testing.assert_allclose(engine.mass(), mass, atol=1e-8 * np.abs(mass).max())
    bias = pin.nonLinearEffects(mech.model, data, state.q, v)
    np.testing.assert_allclose(engine.bias(), bias, atol=1e-8 * np.abs(bias).max())
    closure = engine.closure()
    assert np.abs(closure @ pm.tangent(state)).max() < 1e-11
    assert np.linalg.matrix_rank(closure, tol=1e-8) == np.linalg.matrix_rank(
        pm.closure_jacobian(state), tol=1e-8
    )
    drift = engine.closure(dot=True) @ v
    np.testing.assert_allclose(closure @ a, -drift, atol=1e-9 * max(1.0, np.abs(drift).max()))
