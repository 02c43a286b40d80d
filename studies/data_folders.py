"""Which data sets and example robots there are to work on."""

import sysconfig
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent
# Recordings are too large to commit: they lie beside the checkout where there are any.
SHARED = REPOSITORY.parent / "shared" / "data"
# The URDF files of the package example-robot-data.
EXAMPLE_ROBOTS = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
EXAMPLE_ARMS = (
    "ur_description/urdf/ur3_robot.urdf",
    "ur_description/urdf/ur5_robot.urdf",
    "ur_description/urdf/ur10_robot.urdf",
    "panda_description/urdf/panda.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "z1_description/urdf/z1.urdf",
    "kinova_description/robots/kinova.urdf",
    "so_arm_description/urdf/so101.urdf",
    "tiago_description/robots/tiago.urdf",
    "double_pendulum_description/urdf/double_pendulum.urdf",
)
PANDA = EXAMPLE_ROBOTS / "panda_description/urdf/panda.urdf"


def data_sets(data: Path | None) -> tuple[Path, ...]:
    """The set in the folder named, else the sets in its subfolders; the shared ones if None.

    A folder that holds neither is returned as it is, so that reading it says what is wrong.
    """
    folder = data or SHARED
    if (folder / "dataset.toml").is_file():
        return (folder,)
    inside = tuple(sorted(file.parent for file in folder.glob("*/dataset.toml")))
    return inside or ((folder,) if data else ())
