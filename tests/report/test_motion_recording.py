"""The recorded page moves the arm as the motion says, and holds all it needs."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import numpy as np
import pytest
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.report.motion_recording import record_motion
from oed.robot import imi_scara
from tests.design.primitive_arm import LENGTH, arm_and_post, elbow_at, planar_arm, sphere, tip_at

msgpack = pytest.importorskip("msgpack")


def motion() -> Motion:
    t = np.arange(0.0, 1.0, 0.04)
    q = np.stack([np.sin(3 * t), 2 * t], axis=1)
    return Motion(t, q, 0 * q, 0 * q)


def commands(page: Path) -> list[dict]:
    """What Meshcat's page replays, one packed command after another."""
    packed = re.findall(
        r"data:application/octet-binary;base64,([A-Za-z0-9+/=]+)", page.read_text(encoding="utf-8")
    )
    return [msgpack.unpackb(base64.b64decode(p), strict_map_key=False) for p in packed]


def drawn(page: Path) -> set[str]:
    """Bodies with a shape on the page."""
    found = {c["path"].split("/planar/")[1] for c in commands(page) if c["type"] == "set_object"}
    return {path.split("/")[0] for path in found}


def tracks(page: Path, body: str) -> tuple[ndarray, ndarray, ndarray]:
    """Time [s], position [m] and angle about z [rad] of a body's frames."""
    (animation,) = [c for c in commands(page) if c["type"] == "set_animation"]
    (clip,) = [a["clip"] for a in animation["animations"] if a["path"].endswith(f"/{body}")]
    keys = {track["name"]: track["keys"] for track in clip["tracks"]}
    t = np.array([key["time"] for key in keys[".position"]]) / clip["fps"]
    position = np.array([key["value"] for key in keys[".position"]])
    x, y, z, w = np.array([key["value"] for key in keys[".quaternion"]]).T
    np.testing.assert_allclose(np.hypot(x, y), 0.0, atol=1e-6)
    return t, position, 2 * np.arctan2(z, w)


def test_every_frame_is_the_arms_pose_at_its_time(tmp_path: Path) -> None:
    page, told = tmp_path / "motion.html", motion()
    assert record_motion(arm_and_post(tmp_path), told, page) == ""
    t, position, angle = tracks(page, "lower")
    # Meshcat counts in frames of 1/64 s.
    np.testing.assert_allclose(t, told.t, atol=1 / 64)
    np.testing.assert_allclose(position, elbow_at(told.q), atol=1e-6)
    np.testing.assert_allclose(np.cos(angle - told.q.sum(axis=1)), 1.0, atol=1e-9)
    _, base, _ = tracks(page, "base")
    np.testing.assert_allclose(base, 0.0, atol=1e-9)


def test_a_joint_that_is_held_stays_where_it_is_held(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path, joints=("elbow",), locked={"shoulder": 0.7})
    told = motion()
    one = Motion(told.t, told.q[:, 1:], told.dq[:, 1:], told.ddq[:, 1:])
    assert record_motion(robot, one, tmp_path / "motion.html") == ""
    _, position, angle = tracks(tmp_path / "motion.html", "lower")
    q = np.stack([np.full(len(told), 0.7), told.q[:, 1]], axis=1)
    np.testing.assert_allclose(position, elbow_at(q), atol=1e-6)
    tip = position + LENGTH * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(tip, tip_at(q), atol=1e-6)


def test_draws_what_is_meant_to_be_seen_else_what_collides(tmp_path: Path) -> None:
    page = tmp_path / "motion.html"
    record_motion(planar_arm(tmp_path, base=sphere(0.1), lower=sphere(0.1)), motion(), page)
    assert drawn(page) == {"base", "lower"}
    seen = sphere(0.1, kind="visual")
    record_motion(planar_arm(tmp_path, base=sphere(0.1), upper=seen), motion(), page)
    assert drawn(page) == {"upper"}


def test_needs_nothing_from_elsewhere(tmp_path: Path) -> None:
    record_motion(arm_and_post(tmp_path), motion(), tmp_path / "motion.html")
    page = (tmp_path / "motion.html").read_text(encoding="utf-8")
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="(?!data:)', page)


def test_missing_meshes_are_said(tmp_path: Path) -> None:
    absent = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    robot = planar_arm(tmp_path, upper=absent, lower=sphere(0.1, kind="visual"))
    page = tmp_path / "motion.html"
    assert "gone.dae" in record_motion(robot, motion(), page)
    assert drawn(page) == {"lower"}


def test_a_robot_without_a_file_is_not_recorded(tmp_path: Path) -> None:
    note = record_motion(imi_scara(), motion(), tmp_path / "motion.html")
    assert note.startswith("no recording")
    assert not (tmp_path / "motion.html").exists()


def test_a_robot_without_shapes_gets_no_empty_page(tmp_path: Path) -> None:
    page = tmp_path / "motion.html"
    assert record_motion(planar_arm(tmp_path), motion(), page).startswith("no recording")
    absent = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    assert "gone.dae" in record_motion(planar_arm(tmp_path, upper=absent), motion(), page)
    assert not page.exists()


def test_a_meshcat_that_cannot_start_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_port() -> None:
        raise RuntimeError("no free port")

    monkeypatch.setattr("oed.report.motion_recording.Meshcat", no_port)
    note = record_motion(arm_and_post(tmp_path), motion(), tmp_path / "motion.html")
    assert "no free port" in note
    assert not (tmp_path / "motion.html").exists()


def test_the_camera_looks_at_what_moves(tmp_path: Path) -> None:
    record_motion(arm_and_post(tmp_path), motion(), tmp_path / "motion.html")
    aimed = [c for c in commands(tmp_path / "motion.html") if "/Cameras" in c.get("path", "")]
    (stand,) = [c["value"] for c in aimed if c["type"] == "set_property"]
    assert LENGTH / 2 < np.linalg.norm(stand) < 10 * LENGTH
