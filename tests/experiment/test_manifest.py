"""The manifest: every key that is missing, unknown or wrong is named."""

import pytest

from tests.experiment.tiny_dataset import MANIFEST, refused, spoil, tiny_files, write_files


@pytest.mark.parametrize(
    "line",
    [*MANIFEST.splitlines()[:8], 'file = "estimation.csv"', 'role = "test"'],
)
def test_missing_key(tmp_path, line):
    error = refused(spoil(tmp_path, "dataset.toml", line, ""))
    assert error.column is not None
    assert error.column.endswith(line.split(" =")[0])
    assert "missing" in str(error)


def test_unknown_key_names_the_nearest(tmp_path):
    error = refused(spoil(tmp_path, "dataset.toml", "licence", "license"))
    assert "did you mean 'licence'" in str(error)


@pytest.mark.parametrize(
    ("old", "new", "column"),
    [
        ("format = 1", "format = 2", "format"),
        ("format = 1", "format = true", "format"),
        ("format = 1", 'format = "1"', "format"),
        ('name = "tiny"', "name = 3", "name"),
        ('licence = "CC0"', 'license = "CC0"', "license"),
        ('["joint_1", "joint_2"]', '["joint_1", "joint_1"]', "joints"),
        ('["joint_1", "joint_2"]', '["joint_1", 2]', "joints"),
        ('["joint_1", "joint_2"]', "[]", "joints"),
        ("-9.81]", "-9.81, 0]", "gravity"),
        ("-9.81]", "nan]", "gravity"),
        ("-9.81]", "1e300]", "gravity"),
        ("-9.81]", "-981]", "gravity"),
        ("-9.81]", "0x" + "f" * 5000 + "]", "gravity"),
        ('"measured"', '"mesured"', "torque"),
        ('role = "test"', 'role = "train"', "recording[2].role"),
        ('file = "test.csv"', 'file = "./estimation.csv"', "recording[2].file"),
        ("repetitions = 3", "repetitions = 0", "recording[1].repetitions"),
        ("repetitions = 3", "repetitions = 3.0", "recording[1].repetitions"),
        ("period = 1.0", "period = -1.0", "recording[1].period"),
        ("period = 1.0", "periode = 1.0", "recording[1].periode"),
        ('torque = "measured"', 'torque = "measured"\nlimits = 3', "limits"),
    ],
)
def test_wrong_value_in_the_manifest(tmp_path, old, new, column):
    assert refused(spoil(tmp_path, "dataset.toml", old, new)).column == column


def test_list_of_another_length_than_joints(tmp_path):
    error = refused(
        spoil(
            tmp_path,
            "dataset.toml",
            '[[recording]]\nfile = "est',
            '[limits]\nvelocity = [1]\n[[recording]]\nfile = "est',
        )
    )
    assert error.column == "limits.velocity"
    assert "1 values for 2 joints" in str(error)


@pytest.mark.parametrize(
    "limits",
    [
        "position = [[1, -1], [-1, 1]]",
        "velocity = [-1, 1]",
        "velocity = [nan, 1]",
        "position = [1, 1]",
        "speed = [1, 1]",
        "torque = [[1, 2, 3], 1]",
    ],
)
def test_wrong_limits(tmp_path, limits):
    old = '[[recording]]\nfile = "est'
    error = refused(spoil(tmp_path, "dataset.toml", old, f"[limits]\n{limits}\n{old}"))
    assert error.column == f"limits.{limits.split(' ')[0]}"


@pytest.mark.parametrize("text", ["a = = 1", "a = [" * 5000, "a = 1\na = 2", "a = " + "9" * 5000])
def test_manifest_that_is_no_toml(tmp_path, text):
    files = tiny_files() | {"dataset.toml": text.encode()}
    assert "TOML" in str(refused(write_files(tmp_path, files)))


def test_manifest_without_recordings(tmp_path):
    text = MANIFEST[: MANIFEST.index("[[rec")]
    files = tiny_files() | {"dataset.toml": text.encode()}
    assert refused(write_files(tmp_path, files)).column == "recording"
