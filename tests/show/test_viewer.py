"""The viewer without a browser: what the scene holds, and where."""

from __future__ import annotations

import base64
import re
import struct
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import umsgpack

import pinmech as pm
from pinmech.errors import InputError
from pinmech.show.scene.scene import gap_line
from pinmech.show.scene.shapes import gap_colour, nice
from pinmech.show.scene.timing import Timing, joined_rows, paced, time_axis
from pinmech.show.scene.viewer import Viewer
from pinmech.structure.closures import Frame, Loop


@pytest.fixture(scope="module")
def path(antenna: pm.Mechanism) -> pm.PosePath:
    values = np.column_stack([np.linspace(-0.2, 0.2, 50), np.linspace(0.1, -0.1, 50)])
    return pm.inverse_path(antenna, values)


def place(viewer: Viewer, node: str) -> np.ndarray:
    """(4, 4) transform of a node below /meshcat, from the commands."""
    command = viewer.recorder.find(f"/meshcat/{node}", "set_transform")
    assert command is not None
    return np.array(command["matrix"]).reshape(4, 4).T


def prop(viewer: Viewer, node: str, name: str) -> Any:
    command = viewer.recorder.find(node, "set_property", name)
    assert command is not None
    return command["value"]


def page_commands(html: str) -> list[dict[str, Any]]:
    blobs = re.findall(r'^"([A-Za-z0-9+/=]+)",?$', html, flags=re.M)
    return [umsgpack.unpackb(base64.b64decode(blob)) for blob in blobs]


def floats(ext: umsgpack.Ext) -> np.ndarray:
    return np.array(struct.unpack(f"<{len(ext.data) // 4}f", ext.data))


@pytest.mark.parametrize("name", pm.mechanisms())
def test_at_home_both_frames_of_each_closure_coincide(name: str) -> None:
    mech = pm.load(name)
    viewer = pm.view(mech)
    for loop, closure in mech.loops.items():
        first, second = (place(viewer, f"closures/{loop}/{side}") for side in ("first", "second"))
        data = mech.model.createData()
        pin.forwardKinematics(mech.model, data, mech.home.q)
        for frame, found in zip(closure.frames, (first, second), strict=True):
            there = (data.oMi[frame.joint] * frame.placement).homogeneous
            np.testing.assert_allclose(found, there, atol=1e-12)
        if closure.type != "planar":  # its two origins may be apart within the plane
            np.testing.assert_allclose(first[:3, 3], second[:3, 3], atol=1e-10)
        assert prop(viewer, f"/meshcat/closures/{loop}/gap", "visible") is False
        red, green, _, _ = prop(viewer, f"/meshcat/closures/{loop}/second", "color")
        assert green > red
    np.testing.assert_allclose(place(viewer, "platform"), mech.home.platform.homogeneous)
    html = viewer.html()
    assert mech.title in html
    assert len(page_commands(html)) == len(viewer.recorder.commands())


def test_an_open_loop_shows_its_gap_in_red(antenna: pm.Mechanism) -> None:
    viewer = pm.view(antenna)
    q = np.array(antenna.home.q)
    q[antenna.coordinate("arm1")] += 0.3
    viewer.display(q)
    first, second = (place(viewer, f"closures/arm1/{side}") for side in ("first", "second"))
    size = np.linalg.norm(first[:3, 3] - second[:3, 3])
    assert size == pytest.approx(2 * 0.07 * np.sin(0.15))
    assert viewer.gaps()["arm1"] == pytest.approx(size)
    assert prop(viewer, "/meshcat/closures/arm1/gap", "visible") is True
    line = place(viewer, "closures/arm1/gap")
    ends = [line @ [0, y, 0, 1] for y in (-0.5, 0.5)]
    np.testing.assert_allclose(ends[0][:3], first[:3, 3], atol=1e-12)
    np.testing.assert_allclose(ends[1][:3], second[:3, 3], atol=1e-12)
    red, green, _, _ = prop(viewer, "/meshcat/closures/arm1/gap", "color")
    assert red > green
    assert prop(viewer, "/meshcat/closures/arm2/gap", "visible") is False


@pytest.mark.parametrize(
    ("kind", "gaping"),
    [
        ("spherical", (3.0, 4.0, 12.0)),
        ("cylindrical", (3.0, 4.0, 0.0)),
        ("prismatic", (3.0, 4.0, 0.0)),
        ("planar", (0.0, 0.0, 12.0)),
    ],
)
def test_a_closure_is_not_open_where_it_slides(kind: str, gaping: tuple[float, ...]) -> None:
    frame = Frame("f", 0, pin.SE3.Identity())
    first = pin.SE3.Random()
    second = first * pin.SE3(pin.SE3.Random().rotation, np.array([3.0, 4.0, 12.0]))
    start, end = gap_line(Loop("l", kind, (frame, frame), slice(0, 0)), first, second)
    np.testing.assert_allclose(first.rotation.T @ (end - start), gaping, atol=1e-12)
    np.testing.assert_allclose(end, second.translation)


def test_bodies_stand_where_pinocchio_puts_them(antenna: pm.Mechanism) -> None:
    state = pm.inverse(antenna, {"alpha": 0.2, "beta": -0.1}).unwrap()
    viewer = pm.view(state)
    for link, joint in (("arm1", "arm1"), ("rod3", "rod3_u2")):
        there = state.frame(link).homogeneous
        np.testing.assert_allclose(place(viewer, f"mechanism/visuals/{joint}"), there, atol=1e-12)
    shapes = [p for p in viewer.recorder.paths() if "/visuals/" in p]
    assert len(shapes) == len(viewer.bodies.visual_model.geometryObjects)


def test_the_camera_sees_the_whole_mechanism(antenna: pm.Mechanism) -> None:
    viewer = pm.view(antenna)
    turn = viewer.recorder.find("/meshcat", "set_transform")
    assert turn is not None
    shift = np.array(turn["matrix"]).reshape(4, 4).T
    camera = "/Cameras/default/rotated/<object>"
    x, z, minus_y = prop(viewer, camera, "position")
    eye = np.array([x, -minus_y, z])
    half = np.deg2rad(prop(viewer, camera, "fov")) / 2
    away = eye / np.linalg.norm(eye)
    up = np.cross(away, np.cross([0, 0, 1], away))
    for node in ("platform", "closures/arm1/first", "closures/arm2/first", "closures/arm3/first"):
        seen = (shift @ place(viewer, node)[:, 3])[:3] - eye
        assert abs(seen @ up / np.linalg.norm(up)) < -(seen @ away) * np.tan(half)


def test_a_mechanism_without_shapes_is_a_stick_figure(antenna: pm.Mechanism) -> None:
    bare = re.sub(r"<visual>.*?</visual>", "", antenna.urdf, flags=re.DOTALL)
    assert antenna.path is not None
    text = antenna.path.read_text(encoding="utf-8")
    viewer = pm.view(pm.from_text(text, bare))
    sticks = [p for p in viewer.recorder.paths() if "/stick" in p]
    assert len(sticks) >= 10
    assert not viewer.bodies.visual_model.geometryObjects


def test_a_path_is_baked_into_the_page(path: pm.PosePath, tmp_path: Path) -> None:
    viewer = pm.view(path, time=np.arange(50) * 0.1, frames=20)
    page = viewer.write_html(tmp_path / "page.html")
    html = page.read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)\s*=\s*["']?https?:""", html.split("<script>")[0])
    *_, last = page_commands(html)
    assert last["type"] == "set_animation"
    clips = {a["path"]: a["clip"]["tracks"] for a in last["animations"]}
    assert "/meshcat/mechanism/visuals/arm1" in clips
    position, quaternion = clips["/meshcat/closures/arm1/first"]
    times = floats(position["times"])
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(4.9)
    assert len(times) <= 20
    assert (np.diff(times) > 0).all()
    placed = floats(position["values"]).reshape(-1, 3)
    for at, where in zip(times, placed, strict=True):
        row = round(float(at) / 0.1)
        state = path.state(row)
        np.testing.assert_allclose(where, state.frame("arm1_tip").translation, atol=1e-6)
    # Both frames of a closure stay together in every keyframe.
    other = floats(clips["/meshcat/closures/arm1/second"][0]["values"]).reshape(-1, 3)
    np.testing.assert_allclose(placed, other, atol=1e-6)
    assert len(floats(quaternion["values"])) == 4 * len(times)
    assert viewer.recorder.find("/meshcat/trace") is not None
    assert "in real time" in html


def test_failed_rows_are_left_out_and_reported(antenna: pm.Mechanism) -> None:
    values = np.zeros((30, 2))
    values[:, 0] = np.linspace(0.0, 0.1, 30)
    values[10:14] = [1.5, 0.0]
    broken = pm.inverse_path(antenna, values)
    assert not broken.success[10:14].any()
    with pytest.warns(UserWarning, match="4 of 30 poses failed"):
        viewer = pm.view(broken)
    assert "row 10: unreachable" in viewer.notes[0]
    assert "4 of 30 poses failed" in viewer.html()
    position = next(
        a["clip"]["tracks"][0]
        for a in page_commands(viewer.html())[-1]["animations"]
        if a["path"] == "/meshcat/platform"
    )
    assert np.isfinite(floats(position["values"])).all()
    trace = viewer.recorder.find("/meshcat/trace")
    assert trace is not None
    pieces = trace["object"]["geometries"][0]
    points = floats(pieces["data"]["attributes"]["position"]["array"])
    assert len(points) == (29 - 5) * 2 * 3


def test_bad_subjects_are_refused(antenna: pm.Mechanism, path: pm.PosePath) -> None:
    other = pm.load("decoupled_pf")
    with pytest.raises(InputError, match="needs a Mechanism"):
        pm.view("antenna_3rsu")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="time belongs to a path"):
        pm.view(antenna, time=[0.0])
    with pytest.raises(InputError, match="shape"):
        pm.view(path, time=[0.0, 1.0])
    with pytest.raises(InputError, match="increase"):
        pm.view(path, time=np.zeros(50))
    with pytest.raises(InputError, match="duration"):
        pm.view(path, duration=float("nan"))
    with pytest.raises(InputError, match="frames"):
        pm.view(path, frames=1)
    with pytest.raises(InputError, match="no pose of the path"):
        pm.view(pm.inverse_path(antenna, [[1.5, 0.0]]))
    with pytest.raises(InputError, match="empty"):
        pm.view(pm.inverse_path(antenna, np.zeros((0, 2))))
    viewer = pm.view(antenna)
    with pytest.raises(InputError, match="another mechanism"):
        viewer.display(other.home)
    with pytest.raises(InputError, match="finite"):
        viewer.display(np.full(antenna.model.nq, np.nan))
    with pytest.raises(InputError, match="no path to play"):
        viewer.play()
    with pytest.raises(InputError, match="rate"):
        viewer.play(path, rate=0.0)


STL = """solid s
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.1 0
endloop
endfacet
endsolid s
"""


def with_mesh(antenna: pm.Mechanism, folder: Path, content: str) -> pm.Mechanism:
    """The antenna with a mesh file, of twice the size, for its first shape."""
    assert antenna.path is not None
    (folder / "part.stl").write_text(content, encoding="utf-8")
    mesh = '<geometry><mesh filename="part.stl" scale="2 2 2"/></geometry>'
    urdf = re.sub(r"<geometry>.*?</geometry>", mesh, antenna.urdf, count=1, flags=re.DOTALL)
    (folder / "a.urdf").write_text(urdf, encoding="utf-8")
    text = antenna.path.read_text(encoding="utf-8")
    file = folder / "a.yaml"
    file.write_text(text.replace("../urdf/antenna_3rsu.urdf", "a.urdf"), encoding="utf-8")
    return pm.load(file)


def test_meshes_are_read_from_the_folder_of_the_urdf(antenna: pm.Mechanism, tmp_path: Path) -> None:
    viewer = pm.view(with_mesh(antenna, tmp_path, STL))
    shape = viewer.bodies.visual_model.geometryObjects[0]
    node = f"mechanism/visuals/base/{shape.name}"
    sent = viewer.recorder.find(f"/meshcat/{node}")
    assert sent is not None
    assert "part.stl" not in str(sent["object"]["geometries"][0])  # the page holds the mesh itself
    np.testing.assert_allclose(np.linalg.norm(place(viewer, node)[:3, :3], axis=0), 2.0)


def test_a_broken_mesh_is_one_message(antenna: pm.Mechanism, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="antenna_3rsu cannot be read"):
        pm.view(with_mesh(antenna, tmp_path, "not a mesh"))


def test_importing_pinmech_does_not_import_meshcat_and_viewing_prints_nothing(
    tmp_path: Path,
) -> None:
    code = (
        "import sys, pinmech as pm\n"
        "assert 'meshcat' not in sys.modules and 'rich' not in sys.modules\n"
        "viewer = pm.view(pm.load('antenna_3rsu'))\n"
        f"viewer.write_html({str(tmp_path / 'x.html')!r})\n"
        "assert viewer.url is None\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_live_page_follows() -> None:
    code = (
        "import numpy as np, pinmech as pm\n"
        "mech = pm.load('antenna_3rsu')\n"
        "path = pm.inverse_path(mech, np.linspace([0, 0], [0.1, 0.1], 10))\n"
        "viewer = pm.view(mech)\n"
        "url = viewer.connect()\n"
        "assert url.startswith('http://127.0.0.1:') and viewer.url == url\n"
        "viewer.play(path, time=np.arange(10) * 0.01, rate=2.0)\n"
        "page = viewer._recorder.window.get_scene()\n"
        "sent = page.count('fetch(\"data:')\n"
        "assert sent == len(viewer.recorder.commands()) + 1, (sent, 'one: animation stopped')\n"
        "other = pm.view(mech, url=viewer._recorder.window.zmq_url)\n"
        "assert other.url == url\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_no_server_is_a_message_not_a_hang(
    antenna: pm.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pinmech.show.scene.recorder._PATIENCE", 200)
    for url in ("tcp://127.0.0.1:9", "not an address"):
        with pytest.raises(InputError, match="no meshcat server answers"):
            pm.view(antenna, url=url)


def test_timing_keeps_both_ends_and_thins_evenly() -> None:
    time = np.concatenate([np.linspace(0, 1, 1000), np.linspace(1.1, 100, 50)])
    timing = Timing.of(np.ones(1050, bool), time, given=True, duration=10.0, frames=101)
    assert timing.rows[0] == 0
    assert timing.rows[-1] == 1049
    assert timing.at[-1] == pytest.approx(10.0)
    np.testing.assert_allclose(timing.at, time[timing.rows] / 10.0)
    assert len(timing.rows) <= 101
    assert "10 times as fast" in timing.describe()


def test_timing_stands_still_where_rows_failed() -> None:
    success = np.ones(20, bool)
    success[[0, 5, 6, 19]] = False
    timing = Timing.of(success, np.arange(20.0), given=True, duration=None, frames=50)
    assert timing.rows[0] == 1
    assert timing.rows[-1] == 18
    assert (np.diff(timing.at) > 0).all()
    k = int(np.flatnonzero(timing.rows == 7)[0])
    assert timing.rows[k - 2] == timing.rows[k - 1] == 4
    assert timing.at[k - 1] > timing.at[k - 2] + 1.9
    assert joined_rows(success, np.array([3, 4, 7, 8])).tolist() == [True, False, True]


def test_one_good_row_is_no_animation(antenna: pm.Mechanism) -> None:
    one = pm.inverse_path(antenna, [[0.1, 0.0]])
    viewer = pm.view(one)
    assert not viewer.recorder.animated
    np.testing.assert_allclose(place(viewer, "platform"), one.state(0).platform.homogeneous)


def test_a_late_viewer_skips_poses_but_shows_the_last() -> None:
    import time

    seen = []
    for k in paced(np.arange(40) * 0.005):
        seen.append(k)
        time.sleep(0.02)
    assert seen[0] == 0
    assert seen[-1] == 39
    assert len(seen) < 30
    assert seen == sorted(set(seen))


def test_a_deleted_node_takes_its_children_along(antenna: pm.Mechanism) -> None:
    viewer = pm.view(antenna)
    viewer.meshcat["closures"].delete()
    assert not [p for p in viewer.recorder.paths() if "/closures/" in p]
    assert viewer.recorder.commands()[0]["type"] == "delete"
    assert viewer.meshcat.static_html().startswith("<!DOCTYPE html>")


def test_names_from_a_file_are_text_in_the_page(antenna: pm.Mechanism) -> None:
    assert antenna.path is not None
    text = antenna.path.read_text(encoding="utf-8")
    evil = text.replace("title: 2-DOF", "title: <script>alert(1)</script> 2-DOF")
    assert evil != text
    html = pm.view(pm.from_text(evil, antenna.urdf)).html()
    assert "<script>alert(1)" not in html
    assert "&lt;script&gt;alert(1)" in html


def test_small_things() -> None:
    assert [nice(x) for x in (0.051, 0.5, 7.0, 19.9)] == [0.05, 0.5, 5.0, 10.0]
    assert gap_colour(0.0)[1] > gap_colour(0.0)[0]
    assert gap_colour(1.0)[0] > gap_colour(1.0)[1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match="numbers"):
            time_axis(["a"], 1)  # type: ignore[list-item]
