"""A weighed load is told from a wrong one, and logs that end within a row are read."""

import shutil

import numpy as np
import pytest

from oed.report.table import read_csv
from studies import public_loads
from studies.carrying_arms import ARMS
from studies.data_folders import EXAMPLE_ROBOTS
from studies.payload_arms import TrueArm, draw_load, random_motion_of, record
from studies.public_loads import LOGS, OURS, PUBLISHED, Laboratory, summarise

GAINS = np.array(PUBLISHED) / 1.1  # [N m/A] of the simulated motors


def row(mass, lower, upper, gains=OURS):
    held = lower <= public_loads.MASS <= upper
    off = 100 * (mass / public_loads.MASS - 1)
    return {"recordings": "a", "gains": gains, "mass [kg]": mass, "off [%]": off, "held": held}


def test_a_claim_falls_by_one_mass_that_is_off_or_outside() -> None:
    good = row(2.79, 2.7, 2.9)
    assert "It stands" in summarise([], [good], "c0ffee")
    assert "It stands" in summarise([], [good, row(3.08, 3.0, 3.1, "published")], "c0ffee")
    assert "does not stand" in summarise([], [good, row(2.72, 2.6, 2.9)], "c0ffee")
    assert "does not stand" in summarise([], [good, row(2.79, 2.78, 2.8)], "c0ffee")
    assert "does not stand" in summarise([], [], "c0ffee")


def test_rows_are_those_of_the_authors_without_one_that_is_cut(tmp_path) -> None:
    clone = tmp_path / "clone"
    (clone / LOGS).mkdir(parents=True)
    whole = [",".join([str(k)] * public_loads.COLUMNS) for k in range(1, 10)]
    (clone / LOGS / "log.csv").write_text("\n".join([*whole, "10,1"]), encoding="ascii")
    laboratory = Laboratory(clone, tmp_path)

    def numbers(rows):
        lines = laboratory._cut("log.csv", rows).read_text(encoding="ascii").splitlines()
        return [int(line.split(",")[0]) for line in lines]

    assert numbers(None) == list(range(1, 9))
    assert numbers((3, 6)) == [3, 4, 5]


def write_clone(clone):
    """Logs of a simulated UR10 as the repository has them: amperes, no names, 100 rows a second."""
    rng = np.random.default_rng(2)
    arm = ARMS["ur10"]
    (clone / LOGS).mkdir(parents=True)
    robot = clone / public_loads.ROBOT
    robot.parent.mkdir(parents=True)
    shutil.copyfile(EXAMPLE_ROBOTS / "ur_description/urdf/ur10_robot.urdf", robot)
    bare = TrueArm.draw(arm, rng)
    body = draw_load(rng)
    loaded = bare.another_day(rng).holding(arm.frame, body * public_loads.MASS / body[0])
    for pair in (public_loads.GAINS, public_loads.WEIGHED[0]):
        for name, true in ((pair.bare, bare), (pair.loaded, loaded)):
            motion = random_motion_of(arm, 30.0, rng)
            (log,) = record(arm, true, motion, rng, coloured=False, name="log").recordings
            every = max(1, round(0.01 / (log.t[1] - log.t[0])))
            columns = [
                log.t[:, None],
                log.q,
                motion.dq,
                log.tau / GAINS,
                np.zeros((len(log.t), 12)),
            ]
            table = np.column_stack(columns)[::every]
            np.savetxt(clone / LOGS / name, table, delimiter=",", fmt="%.5f")


def test_a_load_is_weighed_with_gains_from_other_recordings(tmp_path, capsys) -> None:
    write_clone(tmp_path / "clone")
    given = ["--repo", str(tmp_path / "clone"), "--smoke", "--out", str(tmp_path / "out")]
    public_loads.main(given)
    told = capsys.readouterr().out
    assert "It stands" in told
    ours, published = read_csv(tmp_path / "out" / "runs.csv")
    assert abs(ours["off [%]"]) < 2
    # Gains that are a tenth too large make a load that is a tenth too heavy.
    assert published["off [%]"] == pytest.approx(10, abs=4)


def test_a_clone_that_is_not_there_is_told_how_to_fetch(tmp_path) -> None:
    with pytest.raises(ValueError, match="fetch it: git clone"):
        public_loads.main(["--repo", str(tmp_path), "--out", str(tmp_path / "out")])
