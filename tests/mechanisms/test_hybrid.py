"""A serial arm on the platform: kinematics, statics and dynamics go through both."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from lxml import etree

import pinmech as pm
from pinmech.description.arms import example_robots
from pinmech.designs.planar_3r import Planar3R, planar_3r
from pinmech.errors import DescriptionError, InputError, UnknownNameError

Array = np.ndarray

#: The arm's root on the platform's top.
TOP = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 0.4), np.array([0.01, -0.02, 0.05]))
JOINTS = ("arm_shoulder", "arm_elbow", "arm_wrist")
UR5 = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


@functools.cache
def gimbal() -> pm.Mechanism:
    return pm.load("gpr_3ps")


@functools.cache
def wafer_handler() -> pm.Mechanism:
    return gimbal().with_arm(planar_3r(), placement=TOP)


@functools.cache
def robot(name: str) -> pm.Mechanism:
    if name == "panda":
        arm = [f"panda_joint{k}" for k in range(1, 8)]  # the fingers stay shut
        return gimbal().with_arm("panda", placement=TOP, joints=arm, prefix="p_")
    return gimbal().with_arm(
        "ur5_robot", placement=TOP, home={"shoulder_lift_joint": -1.2, "elbow_joint": 1.0}
    )


def placed(mech: pm.Mechanism, seed: int) -> tuple[Array, pm.ClosedState]:
    """Random outputs near home and the state there."""
    rng = np.random.default_rng(seed)
    x = np.array([*mech.home.outputs.values()])
    x[0] = rng.uniform(0.25, 0.4)
    x[1:3] = rng.uniform(-0.1, 0.1, 2)
    x[3:] += rng.uniform(-0.4, 0.4, len(x) - 3)
    x = np.clip(x, mech.lower[list(mech.outputs.coordinates)], np.inf)
    x = np.minimum(x, mech.upper[list(mech.outputs.coordinates)])
    return x, pm.inverse(mech, x).unwrap()


def chain(upper: float, fore: float, hand: float, a: float, b: float, c: float) -> Array:
    """Tool position of the planar arm in its base plane, by hand."""
    return np.array(
        [
            upper * math.cos(a) + fore * math.cos(a + b) + hand * math.cos(a + b + c),
            upper * math.sin(a) + fore * math.sin(a + b) + hand * math.sin(a + b + c),
        ]
    )


# -------------------------------------------------------------------------------- composition


def test_outputs_are_those_of_the_mechanism_then_of_the_arm() -> None:
    mech = wafer_handler()
    assert tuple(mech.outputs) == ("z", "alpha", "beta", *JOINTS)
    assert tuple(mech.actuators) == ("q1", "q2", "q3", *JOINTS)
    assert mech.drives == {"all": ("q1", "q2", "q3", *JOINTS)}
    assert mech.platform == "platform"
    assert mech.length == gimbal().length
    assert set(gimbal().frames) < set(mech.frames)
    assert pm.mobility(mech.home).dof == 6
    assert "arm_tool" in mech.frames
    assert mech.home.joints["q1"] == gimbal().home.joints["q1"]


def test_every_drive_gains_the_arm(antenna: pm.Mechanism) -> None:
    mech = antenna.with_arm(planar_3r())
    assert mech.drives["12"] == ("arm1", "arm2", *JOINTS)
    assert mech.drives["123"] == ("arm1", "arm2", "arm3", *JOINTS)
    state = pm.inverse(mech, [0.1, 0.2, 0.3, -0.4, 0.5]).unwrap()
    r = pm.inverse_dynamics(state, [0.0] * 5, [0.0] * 5, drive="123")
    assert r.preload_basis.shape == (6, 1)
    assert np.abs(r.preload_basis[3:]).max() < 1e-9  # an arm cannot be preloaded
    assert state.mode["arm1"] == 1


def test_the_original_is_untouched() -> None:
    before = (gimbal().model.nv, tuple(gimbal().outputs), gimbal().urdf)
    wafer_handler()
    assert (gimbal().model.nv, tuple(gimbal().outputs), gimbal().urdf) == before


# --------------------------------------------------------------------------------- kinematics


@pytest.mark.parametrize("seed", range(5))
def test_kinematics_of_the_wafer_handler(seed: int) -> None:
    """Platform as without the arm; tool as the chain by hand says, carried by the platform."""
    mech, arm = wafer_handler(), Planar3R()
    x, state = placed(mech, seed)
    alone = pm.inverse(gimbal(), x[:3]).unwrap()
    np.testing.assert_allclose(state.platform.homogeneous, alone.platform.homogeneous, atol=1e-12)
    for name, value in alone.actuators.items():
        assert state.actuators[name] == pytest.approx(value, abs=1e-12)
    np.testing.assert_allclose([state.actuators[n] for n in JOINTS], x[3:], atol=1e-15)
    flat = chain(arm.upper, arm.fore, arm.hand, *x[3:])
    tool = np.array([*flat, arm.height + 2 * arm.step])
    expected = alone.platform.act(TOP.act(tool))
    np.testing.assert_allclose(state.frame("arm_tool").translation, expected, atol=1e-11)
    back = pm.forward(mech, state.actuators).unwrap()
    np.testing.assert_allclose(list(back.outputs.values()), x, atol=1e-9)


@pytest.mark.parametrize("name", ["ur5_robot", "panda"])
def test_robots_of_example_robot_data(name: str) -> None:
    """The hand is where the robot's own model puts it on the platform."""
    mech = robot(name)
    prefix = "p_" if name == "panda" else "arm_"
    own = pin.buildModelFromUrdf(str(example_robots()[name]))
    mass = [sum(inertia.mass for inertia in m.inertias) for m in (mech.model, gimbal().model, own)]
    assert mass[0] == pytest.approx(mass[1] + mass[2], rel=1e-12)
    data = own.createData()
    for seed in range(3):
        x, state = placed(mech, seed)
        q = pin.neutral(own)
        for joint, value in list(state.joints.items()):
            if joint.startswith(prefix) and own.existJointName(joint[len(prefix) :]):
                q[own.joints[own.getJointId(joint[len(prefix) :])].idx_q] = value
        pin.framesForwardKinematics(own, data, q)
        hand = "panda_hand" if name == "panda" else "ee_link"
        expected = state.platform * TOP * data.oMf[own.getFrameId(hand)]
        found = state.frame(prefix + hand)
        np.testing.assert_allclose(found.homogeneous, expected.homogeneous, atol=1e-11)
        back = pm.forward(mech, state.actuators).unwrap()
        np.testing.assert_allclose(list(back.outputs.values()), x, atol=1e-9)
    assert pm.mobility(state).dof == len(mech.outputs)


def test_rates_by_differences() -> None:
    mech, h = wafer_handler(), 1e-6
    x, state = placed(mech, 7)
    rates = np.array([0.1, 0.3, -0.2, 1.0, -2.0, 0.5])
    jacobian = pm.frame_jacobian(state, "arm_tool")
    ends = [pm.inverse(mech, x + s * h * rates).unwrap().frame("arm_tool") for s in (1, -1)]
    linear = (ends[0].translation - ends[1].translation) / (2 * h)
    turn = pin.log3(ends[0].rotation @ ends[1].rotation.T) / (2 * h)
    np.testing.assert_allclose(jacobian @ rates, np.append(linear, turn), atol=1e-7)
    # the arm's own joints do not move the platform, nor its rods
    inverse = pm.inverse_jacobian(state)
    np.testing.assert_allclose(inverse[:3, 3:], 0, atol=1e-10)
    np.testing.assert_allclose(inverse[3:], np.eye(6)[3:], atol=1e-10)


def test_limits_and_reach_are_still_told() -> None:
    mech = wafer_handler()
    too_far = pm.inverse(mech, [0.3, 0, 0, 3.0, 0, 0])
    assert (too_far.success, too_far.status) == (False, "limit")
    assert "arm_shoulder" in too_far.message
    too_high = pm.inverse(mech, [0.7, 0, 0, 0, 0, 0])
    assert (too_high.success, too_high.status) == (False, "limit")


# -------------------------------------------------------------------------- statics, dynamics


def potential(mech: pm.Mechanism, x: Array) -> float:
    state = pm.inverse(mech, x).unwrap()
    data = mech.model.createData()
    pin.forwardKinematics(mech.model, data, state.q)
    bodies = range(1, mech.model.njoints)
    return 9.81 * sum(
        mech.model.inertias[k].mass * data.oMi[k].act(mech.model.inertias[k].lever)[2]
        for k in bodies
    )


@pytest.mark.parametrize("name", ["planar", "ur5_robot", "panda"])
def test_statics_equal_virtual_work(name: str) -> None:
    """The slope of the potential energy over each output is what the drives do per output."""
    mech = wafer_handler() if name == "planar" else robot(name)
    x, state = placed(mech, 3)
    r = pm.inverse_dynamics(state, np.zeros(len(x)), np.zeros(len(x)))
    torques = np.array([r.torques[actuator] for actuator in mech.actuators])
    per_output = pm.inverse_jacobian(state).T @ torques
    h = 1e-5
    for k, step in enumerate(h * np.eye(len(x))):
        slope = (potential(mech, x + step) - potential(mech, x - step)) / (2 * h)
        assert per_output[k] == pytest.approx(slope, abs=1e-5 * max(1.0, abs(slope)))
    assert np.abs(torques[:3]).max() > 20.0  # the rods carry the arm


def test_the_rods_feel_where_the_arm_is() -> None:
    """Stretched over rod 1 the arm loads it; folded away it does not. Sum of thrusts unchanged."""
    mech = gimbal().with_arm(planar_3r(), placement=pin.SE3(np.eye(3), np.array([0, 0, 0.05])))
    thrusts = {}
    for name, shoulder in (("over_1", 0.0), ("away", math.radians(165))):
        state = pm.inverse(mech, [0.3, 0, 0, shoulder, 0, 0]).unwrap()
        r = pm.inverse_dynamics(state, [0] * 6, [0] * 6)
        thrusts[name] = np.array([r.torques[f"q{k}"] for k in (1, 2, 3)])
        assert max(abs(r.torques[joint]) for joint in JOINTS) < 1e-9  # level: no torque needed
    assert thrusts["over_1"][0] > thrusts["away"][0] + 10
    assert thrusts["over_1"].sum() == pytest.approx(thrusts["away"].sum(), rel=1e-9)
    rods = sum(mech.model.inertias[k].mass for k in range(1, mech.model.njoints))
    assert thrusts["away"].sum() == pytest.approx(9.81 * rods, rel=1e-9)


def test_arm_as_payload_gives_the_same_thrusts() -> None:
    """The arm at rest is a rigid body on the platform, as its own model adds it up."""
    arm = pin.buildModelFromXML(planar_3r())
    data, angles = arm.createData(), np.array([0.4, -0.9, 0.7])
    pin.forwardKinematics(arm, data, angles)
    whole = pin.Inertia.Zero()
    for k in range(arm.njoints):
        whole += data.oMi[k].act(arm.inertias[k]) if k else arm.inertias[0]
    on_platform = TOP.act(whole)
    payload = pm.Payload(on_platform.mass, on_platform.lever, on_platform.inertia)
    mech, pose = wafer_handler(), [0.33, 0.03, -0.05]
    state, bare = pm.inverse(mech, [*pose, *angles]).unwrap(), pm.inverse(gimbal(), pose).unwrap()
    rates, second = [0.1, 0.2, -0.1], [1.0, -0.5, 0.8]
    one = pm.inverse_dynamics(state, [*rates, 0, 0, 0], [*second, 0, 0, 0])
    two = pm.inverse_dynamics(bare, rates, second, loads=pm.Loads(payload=payload))
    for k in (1, 2, 3):
        assert one.torques[f"q{k}"] == pytest.approx(two.torques[f"q{k}"], rel=1e-9)


@pytest.mark.parametrize("name", ["planar", "ur5_robot", "panda"])
def test_forward_dynamics_round_trip(name: str) -> None:
    mech = wafer_handler() if name == "planar" else robot(name)
    rng = np.random.default_rng(1)
    for seed in range(2):
        _, state = placed(mech, seed)
        rates, second = rng.normal(size=(2, len(mech.outputs)))
        r = pm.inverse_dynamics(state, rates, second)
        a = pm.forward_dynamics(state, r.velocity, r.torques)
        np.testing.assert_allclose(a, r.acceleration, atol=1e-6)


def test_on_the_decoupled_mechanism_too() -> None:
    mech = pm.load("decoupled_4r").with_arm(planar_3r(), placement=TOP, prefix="x_")
    state = pm.inverse(mech, [0.5, 0.6, 0.1, 0.2, 0.3]).unwrap()
    assert state.actuators["q2"] == pytest.approx(0.6, abs=1e-10)
    assert (pm.mobility(state).dof, pm.mobility(state).overconstraint) == (5, 4)
    r = pm.inverse_dynamics(state, [1, 2, 3, 4, 5], [5, 4, 3, 2, 1])
    a = pm.forward_dynamics(state, r.velocity, r.torques)
    np.testing.assert_allclose(a, r.acceleration, atol=1e-6)


# ------------------------------------------------------------------------------------- choice


def test_joints_home_and_prefix() -> None:
    mech = gimbal().with_arm(
        planar_3r(), prefix="w_", joints=["shoulder", "wrist"], home={"wrist": 0.5}
    )
    assert tuple(mech.outputs)[3:] == ("w_shoulder", "w_wrist")
    assert mech.home.outputs["w_wrist"] == 0.5
    with pytest.raises(UnknownNameError, match="elbow2"):
        gimbal().with_arm(planar_3r(), joints=["elbow2"])
    with pytest.raises(UnknownNameError, match="wirst"):
        gimbal().with_arm(planar_3r(), home={"wirst": 0.1})
    with pytest.raises(InputError, match="home of arm_wrist"):
        gimbal().with_arm(planar_3r(), home={"wrist": 5.0})


def test_panda_starts_inside_its_limits() -> None:
    """Its fourth joint cannot be 0."""
    home = robot("panda").home.joints
    assert -3.1 < home["p_panda_joint4"] < -0.06
    assert not [name for name in robot("panda").joints if "finger" in name]


def test_what_cannot_be_mounted_is_refused() -> None:
    with pytest.raises(InputError, match="orientation"):
        pm.load("spherical_3paur").with_arm(planar_3r())
    with pytest.raises(UnknownNameError, match="panda"):
        gimbal().with_arm("pandas")
    with pytest.raises(DescriptionError):
        gimbal().with_arm("<robot name='x'><link name='a'></robot>")
    with pytest.raises(InputError, match="exists already"):
        gimbal().with_arm(planar_3r(), prefix="").with_arm(planar_3r(), prefix="")
    bare = gimbal().with_arm(planar_3r(), prefix="")  # the same colours in both, other names
    assert tuple(bare.outputs)[3:] == ("shoulder", "elbow", "wrist")
    twice = gimbal().with_arm(planar_3r(), prefix="a_").with_arm(planar_3r(), prefix="b_")
    assert len(twice.outputs) == 9


def test_the_planar_arm_by_name_is_the_one_its_design_writes() -> None:
    by_name = gimbal().with_arm("planar_3r", placement=TOP)
    assert by_name.urdf == wafer_handler().urdf
    assert by_name.title == wafer_handler().title
    assert "planar_3r" in by_name.title
    with pytest.raises(UnknownNameError, match="planar_3r"):
        gimbal().with_arm("planar_3R")


def test_missing_meshes_are_named_all(tmp_path: Path) -> None:
    mesh = '<visual><geometry><mesh filename="package://here/{}.stl"/></geometry></visual>'
    text = planar_3r()
    for name in ("one", "two"):
        text = text.replace('<link name="hand">', f'<link name="hand">{mesh.format(name)}', 1)
    (tmp_path / "hand.urdf").write_text(text)
    with pytest.raises(DescriptionError) as caught:
        gimbal().with_arm(tmp_path / "hand.urdf")
    assert [fault.where.startswith("hand.urdf:") for fault in caught.value.faults] == [True, True]
    assert "one.stl" in str(caught.value)
    assert "two.stl" in str(caught.value)


def test_meshes_are_found() -> None:
    """Mesh paths of the installed robot package are absolute and exist."""
    for name in ("ur5_robot", "panda"):
        files = [
            m.get("filename") for m in etree.fromstring(robot(name).urdf.encode()).iter("mesh")
        ]
        assert len(files) > 6
        assert all(Path(file).is_file() for file in files)


@pytest.mark.parametrize("name", ["planar", "panda"])
def test_view_shows_mechanism_and_arm(name: str, tmp_path: Path) -> None:
    mech = wafer_handler() if name == "planar" else robot(name)
    _, state = placed(mech, 2)
    viewer = pm.view(state)
    shown = "\n".join(viewer.recorder.paths())
    for body in ("q1", "yaw", "arm_wrist" if name == "planar" else "p_panda_joint7"):
        assert f"/{body}/" in shown
    assert max(viewer.gaps().values()) < 1e-10
    assert viewer.write_html(tmp_path / "arm.html").stat().st_size > 1e5
