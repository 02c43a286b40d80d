"""The command says what it replaced before what it found, and refuses in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.running import oed
from tests.studies.sound_inputs import ROBOTS, URDF


def crossed(folder: Path, text: str, name: str = "robot.urdf") -> tuple[int, Path]:
    """The command's status for a robot file of that text."""
    path = folder / name
    path.write_text(text)
    return oed("cross-check", path, "--out", folder / "out", "--states", 50), path


def test_what_was_replaced_is_said_first_and_all_agree_on_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _ = crossed(tmp_path, URDF.replace('ixx="0.02"', 'ixx="-0.111"'))
    told = capsys.readouterr().out
    replaced = told.index("link 'link_1': no body has principal moments of inertia -0.111")
    assert "a ball of the same mass was taken in its place" in told
    assert replaced < told.index("agrees")
    assert status == 0


@pytest.mark.parametrize("name", ROBOTS)
def test_every_format_agrees(tmp_path: Path, name: str) -> None:
    assert crossed(tmp_path, ROBOTS[name], name)[0] == 0


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('<child link="link_1"/>', '<child link="link_2"/>', "'link_2' is the child of two joints"),
        ('axis xyz="0 0 1"', 'axis xyz="${a}"', "this is xacro, which cannot be expanded"),
        (URDF, "", "this file is empty"),
        ("</robot>", "", "it is truncated"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_before_any_is_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, why: str
) -> None:
    status, path = crossed(tmp_path, URDF.replace(old, new, 1))
    told = capsys.readouterr().err
    assert status == 2
    assert f"{path}: " in told
    assert why in told
    assert not (tmp_path / "out").exists()
