"""What each command leaves in its folder: names that no data set has for its own files."""

from __future__ import annotations

from oed.report.result_folder import ResultFiles

IMPORT = ResultFiles("import")
CHECK = ResultFiles("check", ("check.json", "recorded_motion.json", "report.html"))
IDENTIFY = ResultFiles(
    "identify",
    (
        "model.json",
        "estimate.json",
        "parameters.csv",
        "validation_errors.csv",
        "report.html",
    ),
)
FEASIBLE = ResultFiles(
    "feasible",
    (
        "model.json",
        "estimate.json",
        "changed_masses.csv",
        "links.csv",
        "parameters.csv",
        "validation_errors.csv",
        "parameters.yaml",
        "calibrated_robot.sdf",
        "calibrated_robot.urdf",
        "calibrated_robot.xml",
        "report.html",
    ),
)
PAYLOAD = ResultFiles(
    "payload",
    (
        "payload.json",
        "load.script",
        "load.sdf",
        "load.urdf",
        "load.xml",
        "load_message.yaml",
        "report.html",
    ),
)
GAINS = ResultFiles("gains", ("gains.json", "drive.toml", "report.html"))
CLOSE_LOOP = ResultFiles(
    "close_loop",
    (
        "model.json",
        "diagnosis.json",
        "additions.png",
        "proof.png",
        "next_experiment/design.json",
        "next_experiment/report.html",
        "next_experiment/trajectory.csv",
        "report.html",
    ),
)
DESIGN = ResultFiles(
    "design",
    (
        "design.json",
        "joint_trajectory.json",
        "joint_trajectory.yaml",
        "motion.csv",
        "motion.script",
        "motion_libfranka.csv",
        "poses.csv",
        "provenance.json",
        "report.html",
    ),
)
EXPORT = ResultFiles("export")
MOTION = ResultFiles("export_motion")
CALIBRATE = ResultFiles("calibrate", ("index.html", "calibration.json"))
DEMO = ResultFiles("demo", ("index.html", "provenance.json"))
RECORDINGS = ResultFiles("demo recordings")
