"""`oed demo`: from nothing to pages, and what it finds is what was hidden."""

import re
from pathlib import Path

import jsonschema
import msgspec

from oed.report.json_file import read_json
from tests.running import oed, recorded


def test_the_demo_finds_the_cable_and_links_every_page(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    assert oed("demo", "--smoke", "--quiet", "--out", out) == 0
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
