"""Results never go where inputs lie."""

from pathlib import Path

import pytest

from oed.report.result_folder import ResultFiles
from oed.report.study_files import CLOSE_LOOP, DESIGN, FEASIBLE, IDENTIFY
from tests.report.tried_folder import FILES, fill, listing
from tests.running import oed


def data_set(folder: Path) -> Path:
    """Files of a data set as far as their names go."""
    for name in ("recordings", "urdf", "meshes"):
        (folder / name).mkdir(parents=True)
    (folder / "dataset.toml").write_text(
        f'robot = "urdf/arm.urdf"\nsource = "{"x" * 300}"\n[[recording]]\nfile = "recordings/a.csv"\n'
    )
    (folder / "recordings" / "a.csv").write_text("t,q_1,tau_1\n")
    (folder / "urdf" / "arm.urdf").write_text('<mesh filename="../meshes/link.stl"/>')
    (folder / "meshes" / "link.stl").write_text("solid")
    return folder


@pytest.mark.parametrize("command", [IDENTIFY, FEASIBLE, CLOSE_LOOP, DESIGN])
@pytest.mark.parametrize("inside", ["", "recordings", "urdf", "meshes", "other/../recordings"])
def test_no_results_go_where_inputs_lie(tmp_path: Path, command: ResultFiles, inside: str) -> None:
    data = data_set(tmp_path / "data")
    (data / "other").mkdir()
    before = listing(data)
    with pytest.raises(ValueError, match="choose another folder"):  # noqa: SIM117
        with command.in_folder(data / inside, [data]):
            pass
    assert listing(data) == before
    assert not list(data.rglob(".oed"))


def test_a_link_or_a_robot_s_file_or_its_package_leads_to_the_same_refusal(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    (tmp_path / "link").symlink_to(data, target_is_directory=True)
    arm = tmp_path / "arm.urdf"
    arm.write_text('<mesh filename="package://arm/meshes/link.stl"/>')
    for out, given in (("link", data), ("data/urdf", data / "urdf" / "arm.urdf"), (".", arm)):
        with pytest.raises(ValueError, match="choose another"):  # noqa: SIM117
            with DESIGN.in_folder(tmp_path / out, [given]):
                pass
    with (
        pytest.raises(ValueError, match=r"holds link\.stl"),
        DESIGN.in_folder(data / "meshes", [arm]),
    ):
        pass


def test_a_data_set_that_is_not_read_is_no_place_for_results_either(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    with pytest.raises(ValueError, match="is a data set"), DESIGN.in_folder(data, ["builtin:x"]):
        pass


def test_a_folder_of_its_own_within_the_data_s_is_fine(tmp_path: Path) -> None:
    data = data_set(tmp_path / "data")
    for _ in range(2):
        with FILES.in_folder(data / "results", [data]) as results, results.replaced() as new:
            fill(new, a="1")
    assert listing(data / "results") == {"a.txt": "1"}


def test_no_result_has_a_name_that_a_data_set_has_for_its_own() -> None:
    roles = ("estimation", "validation", "test")
    taken = {"dataset.toml", *(f"{n}.{s}" for n in roles for s in ("csv", "parquet", "toml"))}
    taken |= {f"robot.{s}" for s in ("urdf", "sdf", "xml", "xacro")}
    for command in (IDENTIFY, FEASIBLE, CLOSE_LOOP, DESIGN):
        assert not taken & set(command.names)


@pytest.mark.parametrize("command", ["identify", "feasible", "diagnose"])
def test_a_model_that_is_read_is_not_replaced(
    tmp_path: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not by the next round of the command that left it, either."""
    data, found = data_set(tmp_path / "data"), tmp_path / "found"
    found.mkdir()
    (found / "model.json").write_text("{}")
    for model in (found, found / "model.json"):
        assert oed(command, data, "--model", model, "--out", found) == 2
        assert "choose another folder" in capsys.readouterr().err
    assert listing(found) == {"model.json": "{}"}
