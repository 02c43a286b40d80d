"""A weighed load is told from a wrong one, and logs that end within a row are read."""

from studies import public_loads
from studies.public_loads import LOGS, OURS, Laboratory, summarise


def row(mass, lower, upper, gains=OURS):
    held = lower <= public_loads.MASS <= upper
    off = 100 * (mass / public_loads.MASS - 1)
    return {"recordings": "a", "gains": gains, "mass [kg]": mass, "off [%]": off, "held": held}


def test_a_claim_falls_by_one_mass_that_is_off_or_outside() -> None:
    good = row(2.79, 2.7, 2.9)
    assert "It stands" in summarise([], [good])
    assert "It stands" in summarise([], [good, row(3.08, 3.0, 3.1, "published")])
    assert "does not stand" in summarise([], [good, row(2.72, 2.6, 2.9)])
    assert "does not stand" in summarise([], [good, row(2.79, 2.78, 2.8)])
    assert "does not stand" in summarise([], [])


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
