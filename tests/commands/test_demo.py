"""`oed demo`: from nothing to pages, and what it finds is what was hidden."""

import re
from pathlib import Path

import jsonschema
import msgspec
import numpy as np
import pytest

from oed.commands import design
from oed.commands.configurations import Design
from oed.commands.demo import PAGES
from oed.dynamics.effects.position import JointSpring
from oed.export.model_file import load_model
from oed.report.json_file import read_json
from tests.browser import Browser
from tests.running import oed, recorded

LARGEST = 6_000_000  # [B] of a page


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demo") / "demo"
    assert oed("demo", "--smoke", "--quiet", "--out", folder) == 0
    return folder


def test_the_demo_finds_the_cable_and_links_every_page(out: Path) -> None:
    (effect,) = read_json(out / "diagnosis" / "diagnosis.json")["effects"]
    assert (effect["name"], effect["joint"]) == ("joint_spring", 1)
    # 1.2 N m/rad is hidden.
    found = next(v for k, v in effect["parameters"].items() if k.startswith("spring"))
    assert abs(found["value"] - 1.2) < 4 * found["std"]
    assert read_json(out / "check" / "check.json")["level"] != "red"
    page = (out / "index.html").read_text(encoding="utf-8")
    linked = re.findall(r'<a href="([^"#]+)"', page)
    assert len(linked) >= 6
    assert all((out / address).is_file() for address in linked)
    schema = {name: msgspec.json.schema(record) for name, record in recorded(out)}
    assert len(schema) >= 12
    for file, expected in schema.items():
        jsonschema.validate(read_json(file), expected)
    assert {path.name for path in (out / "export").glob("*.py")} == {"simulate_mujoco.py"}


def test_what_was_found_is_in_the_model_that_leaves(out: Path) -> None:
    found = read_json(out / "diagnosis" / "diagnosis.json")["rms"]["after"]["test"]
    rows = read_json(out / "feasible" / "estimate.json")["validation"]
    left = [row["feasible rms"] for row in rows if row["recordings"] == "test"]
    np.testing.assert_allclose(left[:2], found, rtol=0.1)  # the price of bodies that can exist
    effects = load_model(out / "export" / "model.json").torque_model.effects
    assert any(isinstance(effect, JointSpring) for effect in effects)


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize(
    "page", ["index.html", *(page for _, page, _ in PAGES if page.endswith(".html"))]
)
def test_a_browser_shows_every_page_whole(
    out: Path, page: str, width: int, browser: Browser
) -> None:
    seen = browser.look(out / page, width)
    assert (out / page).stat().st_size < LARGEST
    assert seen.errors == ()
    assert seen.requests == ()
    assert seen.width <= width
    assert seen.overlapping == ()


@pytest.mark.parametrize("width", [1280, 400])
def test_the_arm_fills_the_frame_in_which_it_moves(out: Path, width: int, browser: Browser) -> None:
    (moving,) = browser.look(out / "design" / "report.html", width).moving
    assert moving.canvas == (1.0, 1.0)
    assert moving.width > 0.6 * width
    assert min(moving.filled) > 0.8


def test_a_motion_without_its_bound_is_the_same_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    config = Design(robot="builtin:imi_scara", out=Path("none"), smoke=True, seed=1, quiet=True)
    robot = design.robot_of(config)
    whole = design.find(config, robot)
    monkeypatch.setattr(design, "d_efficiency", None)  # which is not asked
    alone = design.find(config, robot, bounded=False)
    assert whole.efficiency is not None
    assert alone.efficiency is None
    np.testing.assert_array_equal(alone.design.z, whole.design.z)
