"""The recorded page moves the arm as the motion says, and holds all it needs."""

from __future__ import annotations

import base64
import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.errors import OedError
from oed.report.motion_recording import (
    FRAMES,
    FRAMES_PER_SECOND,
    LARGEST,
    frame_times,
    record_motion,
    show_motion,
)
from oed.report.replay import Replay
from oed.robot import imi_scara, load_arm
from tests.design.primitive_arm import LENGTH, arm_and_post, elbow_at, planar_arm, sphere, tip_at
from tests.design.tetrahedron import write_binary_stl
from tests.paths import example_robot

msgpack = pytest.importorskip("msgpack")


def motion() -> Motion:
    t = np.arange(0.0, 1.0, 0.04)
    q = np.stack([np.sin(3 * t), 2 * t], axis=1)
    return Motion(t, q, 0 * q, 0 * q)


def viewer(replay: Replay | None) -> str:
    """The page that a frame unpacks."""
    assert replay is not None
    return gzip.decompress(base64.b64decode(replay.packed)).decode()


def commands(replay: Replay | None) -> list[dict]:
    """What Meshcat's page replays, one packed command after another."""
    packed = re.findall(r"data:application/octet-binary;base64,([A-Za-z0-9+/=]+)", viewer(replay))
    return [msgpack.unpackb(base64.b64decode(p), strict_map_key=False) for p in packed]


def drawn(replay: Replay | None) -> set[str]:
    """Bodies with a shape on the page."""
    shown = [c["path"] for c in commands(replay) if c["type"] == "set_object"]
    return {path.split("/planar/")[1].split("/")[0] for path in shown if "/planar/" in path}


def tracks(replay: Replay | None, body: str) -> tuple[ndarray, ndarray, ndarray]:
    """Time [s], position [m] and angle about z [rad] of a body's frames."""
    (animation,) = [c for c in commands(replay) if c["type"] == "set_animation"]
    (clip,) = [a["clip"] for a in animation["animations"] if a["path"].endswith(f"/{body}")]
    keys = {track["name"]: track["keys"] for track in clip["tracks"]}
    t = np.array([key["time"] for key in keys[".position"]]) / clip["fps"]
    position = np.array([key["value"] for key in keys[".position"]])
    x, y, z, w = np.array([key["value"] for key in keys[".quaternion"]]).T
    np.testing.assert_allclose(np.hypot(x, y), 0.0, atol=1e-6)
    return t, position, 2 * np.arctan2(z, w)


def test_every_frame_is_the_arms_pose_at_its_time(tmp_path: Path) -> None:
    told = motion()
    found = record_motion(arm_and_post(tmp_path), told)
    assert found.note == ""
    t, position, angle = tracks(found.replay, "lower")
    # Meshcat counts in frames of 1/64 s.
    np.testing.assert_allclose(t, told.t, atol=1 / 64)
    np.testing.assert_allclose(position, elbow_at(told.q), atol=1e-6)
    np.testing.assert_allclose(np.cos(angle - told.q.sum(axis=1)), 1.0, atol=1e-9)
    _, base, _ = tracks(found.replay, "base")
    np.testing.assert_allclose(base, 0.0, atol=1e-9)


def test_a_joint_that_is_held_stays_where_it_is_held(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path, joints=("elbow",), locked={"shoulder": 0.7})
    told = motion()
    one = Motion(told.t, told.q[:, 1:], told.dq[:, 1:], told.ddq[:, 1:])
    _, position, angle = tracks(record_motion(robot, one).replay, "lower")
    q = np.stack([np.full(len(told), 0.7), told.q[:, 1]], axis=1)
    np.testing.assert_allclose(position, elbow_at(q), atol=1e-6)
    tip = position + LENGTH * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(tip, tip_at(q), atol=1e-6)


def test_draws_what_is_meant_to_be_seen_else_what_collides(tmp_path: Path) -> None:
    collides = planar_arm(tmp_path, base=sphere(0.1), lower=sphere(0.1))
    assert drawn(record_motion(collides, motion()).replay) == {"base", "lower"}
    seen = sphere(0.1, kind="visual")
    both = planar_arm(tmp_path, base=sphere(0.1), upper=seen)
    assert drawn(record_motion(both, motion()).replay) == {"upper"}


def test_needs_nothing_from_elsewhere(tmp_path: Path) -> None:
    page = viewer(record_motion(arm_and_post(tmp_path), motion()).replay)
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="(?!data:)', page)


def test_missing_meshes_are_said(tmp_path: Path) -> None:
    absent = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    robot = planar_arm(tmp_path, upper=absent, lower=sphere(0.1, kind="visual"))
    found = record_motion(robot, motion())
    assert "gone.dae" in found.note
    assert drawn(found.replay) == {"lower"}


@pytest.mark.parametrize("kind", ["no file", "no shapes", "no mesh"])
def test_an_arm_without_shapes_moves_as_lines_and_it_is_said(tmp_path: Path, kind: str) -> None:
    absent = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    robot, said, elbow = {
        "no file": (imi_scara(), "does not come from a file", 0.359 / LENGTH),
        "no shapes": (planar_arm(tmp_path), "planar has no shapes", 1.0),
        "no mesh": (planar_arm(tmp_path, upper=absent), "gone.dae", 1.0),
    }[kind]
    told = motion()
    found = record_motion(robot, told)
    assert found.note.startswith("drawn as lines between its joints")
    assert said in found.note
    _, position, angle = tracks(found.replay, "bodies/1")
    np.testing.assert_allclose(position, elbow * elbow_at(told.q), atol=1e-6)
    np.testing.assert_allclose(np.cos(angle - told.q.sum(axis=1)), 1.0, atol=1e-9)


def test_what_is_too_large_for_a_page_is_drawn_more_plainly_and_it_is_said(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write_binary_stl(rng.normal(size=(4000, 3, 3)), tmp_path / "ball.stl")
    mesh = '<visual><geometry><mesh filename="ball.stl"/></geometry></visual>'
    robot = planar_arm(tmp_path, upper=mesh, lower=sphere(0.1))
    whole = record_motion(robot, motion())
    assert (whole.note, drawn(whole.replay)) == ("", {"upper"})
    assert whole.replay is not None
    plainer = record_motion(robot, motion(), largest=len(whole.replay.packed) - 1)
    assert plainer.note.startswith("drawn by its collision shapes: its drawings would take")
    assert drawn(plainer.replay) == {"lower"}
    lines = record_motion(robot, motion(), largest=1)
    assert lines.note.startswith("drawn as lines between its joints: its collision shapes")
    assert drawn(lines.replay) == set()


@pytest.mark.parametrize("name", ["ur_description/urdf/ur5_robot", "panda_description/urdf/panda"])
def test_drawings_of_common_arms_are_small_enough_for_a_page(name: str) -> None:
    robot = load_arm(str(example_robot(f"{name}.urdf")))
    t = frame_times(10.0)
    q = 0.7 * np.sin(t[:, None] * np.linspace(0.5, 1.0, robot.n))
    found = record_motion(robot, Motion(t, q, 0 * q, 0 * q))
    assert found.note == ""
    assert found.replay is not None
    assert len(found.replay.packed) < LARGEST


def test_a_notebook_shows_a_long_motion_in_few_frames_and_tells_what_is_not_shown() -> None:
    t = np.linspace(0.0, 20.0, 5 * FRAMES)
    q = np.stack([np.sin(t), np.cos(t)], axis=1)
    shown = show_motion(imi_scara(), Motion(t, q, 0 * q, 0 * q))
    assert "drawn as lines between its joints" in shown.caption
    assert shown._repr_html_().startswith("<iframe srcdoc=")
    times, position, _ = tracks(shown, "bodies/1")
    assert len(times) <= FRAMES
    np.testing.assert_allclose(np.hypot(*position[:, :2].T), 0.359, atol=1e-6)


def test_a_meshcat_that_cannot_start_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_port() -> None:
        raise RuntimeError("no free port")

    monkeypatch.setattr("oed.report.motion_recording.Meshcat", no_port)
    found = record_motion(arm_and_post(tmp_path), motion())
    assert "no free port" in found.note
    assert found.replay is None
    with pytest.raises(OedError, match="no free port"):
        show_motion(arm_and_post(tmp_path), motion())


@pytest.mark.parametrize("horizon", [0.5, 10.0, 600.0])
def test_a_long_motion_has_no_more_frames_than_a_page_can_hold(horizon: float) -> None:
    t = frame_times(horizon)
    assert (t[0], t[-1]) == (0.0, horizon)
    assert len(t) <= FRAMES + 1
    assert np.diff(t).max() <= max(1 / FRAMES_PER_SECOND, horizon / FRAMES) * (1 + 1e-9)


def test_the_camera_sees_the_whole_motion_and_the_floor_s_grid_is_gone(tmp_path: Path) -> None:
    told = motion()
    sent = commands(record_motion(arm_and_post(tmp_path), told).replay)
    given = {(c["path"], c["property"]): c["value"] for c in sent if c["type"] == "set_property"}
    (stand,) = [value for (path, _), value in given.items() if "/Cameras" in path]
    # 40 degrees high: all of a reach of two links is seen from some three times as far.
    assert 2 * LENGTH < np.linalg.norm(stand) < 10 * LENGTH
    assert given["/Grid", "visible"] is given["/Axes", "visible"] is False
