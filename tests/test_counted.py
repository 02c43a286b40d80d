"""Numbers of things in words."""

from oed.counted import counted


def test_one_is_no_plural() -> None:
    assert counted(1, "joint") == "1 joint"
    assert counted(0, "joint") == "0 joints"
    assert counted(2, "joint") == "2 joints"
    assert [counted(n, "mesh", "meshes") for n in (1, 3)] == ["1 mesh", "3 meshes"]
