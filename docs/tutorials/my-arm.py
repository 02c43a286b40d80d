# %% [markdown]
# # My arm, from a log to a report
#
# You have the robot's file and a log of joint positions and torques or motor currents. On the command line three lines lead to a report:
#
# ```bash
# oed import log.mcap --robot arm.urdf --out mydata/
# oed check mydata/ --out check/
# oed identify mydata/ --out estimate/
# ```
#
# `oed import` says what it concluded about columns, joints, units and roles, and writes it to `mydata/dataset.toml`: read that text
# and correct what is wrong ([its format](../reference/dataset.md)). `oed check` looks at units, signs,
# ranges, noise and at what the log cannot determine. If the fit is bad, it tries what may be wrong with the log, such as a reversed sign, and
# names a cause only if undoing that one thing repairs the fit. Begin with what is red on `check/report.html`. `oed identify` leaves
# `estimate/report.html`. A log of another kind than a ROS bag is read the same way: CSV, Excel's text, Parquet, `.mat`, `.npz`, HDF5.
#
# The rest of this page does the same in Python, on a log that it makes itself, of the two-link arm of the paper.
#
# ## A log

# %%
import numpy as np
import pandas as pd

import oed
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS

robot = oed.load_arm("builtin:imi_scara")
rng = np.random.default_rng(1)


def recorded() -> pd.DataFrame:
    """Twenty seconds of a random motion, with torque noise, as a logger would write them."""
    t = np.arange(0.0, 20.0, 0.004)
    rates = 2 * np.pi * rng.uniform(0.1, 0.8, (3, 2))  # [rad/s]
    phases = t[:, None, None] * rates
    q = 0.4 * np.sin(phases).sum(axis=1)
    dq = 0.4 * (rates * np.cos(phases)).sum(axis=1)
    ddq = -0.4 * (rates**2 * np.sin(phases)).sum(axis=1)
    friction = [x for pair in zip(IMI_COULOMB, IMI_VISCOUS, strict=True) for x in pair]
    model = build_model("standard", robot)
    tau = model.torque(np.concatenate([robot.parameters, friction]), Motion(t, q, dq, ddq))
    tau = tau + rng.normal(size=tau.shape) * (0.05, 0.02)  # [N m]
    columns = {"t": t, "q_1": q[:, 0], "q_2": q[:, 1], "tau_1": tau[:, 0], "tau_2": tau[:, 1]}
    return pd.DataFrame(columns)


# %% [markdown]
# ## A data set
#
# One recording is for estimation, another, of a different motion, for validation. All checks that a file goes through are made here too.

# %%
dataset = oed.DataSet.from_frame(
    robot, [recorded(), recorded()], roles=["estimation", "validation"], name="first arm"
)
print(dataset.notes or "nothing is doubtful")

# %% [markdown]
# ## Parameters
#
# This arm declares no gears, so its model is `standard`: rigid body with Coulomb and viscous friction. Where `[drive]` in dataset.toml
# declares `gear_ratio` and the data determine rotor inertias, the model is `rotor`.

# %%
calibration = oed.identify(dataset, model="standard")
estimate = calibration.estimate
for name, value, std, unit in zip(
    estimate.names, estimate.parameters, estimate.std, estimate.units, strict=True
):
    print(f"{name:8s} {value:8.3f} ± {1.96 * std:.3f} {unit}")

# %% [markdown]
# The names are base parameters: combinations of masses, first moments and inertias that torque can show
# ([why](../theory/base-parameters.md)). What this log cannot determine is listed instead of guessed:

# %%
print(list(estimate.unidentifiable) or "everything is determined")

# %% [markdown]
# ## How good is it?
#
# The error on the validation recording counts, over the torque's root mean square. Here noise alone is left. On measured geared arms
# expect several per cent on recordings that were not fitted.

# %%
print(np.round(calibration.validation["validation"].relative_rms, 4))

# %%
held_out = calibration.validation["validation"]
prepared = calibration.recordings["validation"][0]
t, predicted = prepared.motion.t, prepared.tau - held_out.residual
oed.plot_torques(t, prepared.tau, predicted, robot.joint_names)

# %%
oed.plot_residuals(t, held_out.residual, robot.joint_names, held_out.rms)

# %% [markdown]
# What was recorded, in three dimensions: a motion in which a joint hardly moves cannot tell its parameters.

# %%
oed.show_motion(robot, prepared.motion)

# %% [markdown]
# A residual that looks like noise is as good as it gets. Waves that follow the motion mean that the model lacks something:
# [find out what](lacks.md).
