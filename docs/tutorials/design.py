# %% [markdown]
# # A motion, designed and sent
#
# Whatever the estimator, it can only find what the motion showed. This page designs a motion for an arm, looks at what is proven of it,
# and writes it for a controller. On the command line the same is
#
# ```bash
# oed design --robot builtin:imi_scara --out design/
# ```
#
# with your robot's file in place of `builtin:imi_scara`, the two-link arm of the paper.

# %%
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import oed
from oed.design.export import SetPoints, write_csv, write_joint_trajectory_yaml

found = oed.design_motion("builtin:imi_scara", evaluations=60, seed=0)
design = found.design
print(design.status)
print(f"J_k = {design.J_k:.3g}, J_d = {design.J_d:.3g}, {design.horizon:g} s")

# %% [markdown]
# `J_k` is the condition number of the information, to be made small; `J_d` the logarithm of its determinant, to be made large
# ([criteria](../theory/criteria.md)). Sixty evaluations are few: the command makes a thousand. The same seed gives the same motion.
#
# ## What was assumed
#
# A robot's file often lacks limits. What was assumed in their place is said:

# %%
for note in found.notes:
    print("-", note)

# %% [markdown]
# ## What is proven
#
# The extremes hold for every instant, not only for samples ([proven limits](../theory/limits.md)). By default a motion uses 90 % of the
# velocity and acceleration limits:

# %%
for j, name in enumerate(design.problem.model.robot.joint_names):
    low, high = design.certificate.velocity[j]
    limit = found.limits.velocity[j, 1]
    print(f"{name}: velocity {low:.3g} to {high:.3g} rad/s, limit ±{limit:.3g} rad/s")

# %% [markdown]
# The arm, as it will move: drag to turn it. An arm whose file has shapes is drawn with them, this one as lines between its joints.

# %%
motion = design.motion(np.linspace(0.0, design.horizon, 250))
oed.show_motion(design.problem.model.robot, motion)

# %% [markdown]
# Position and velocity of every joint, with the position limits:

# %%
figure, panels = plt.subplots(2, 1, sharex=True, layout="constrained")
for j, name in enumerate(design.problem.model.robot.joint_names):
    panels[0].plot(motion.t, motion.q[:, j], label=name)
    panels[1].plot(motion.t, motion.dq[:, j])
for bound in found.limits.position[0]:
    panels[0].axhline(bound, color="grey", linestyle="--")
panels[0].set_ylabel("position [rad]")
panels[1].set(ylabel="velocity [rad/s]", xlabel="time [s]")
panels[0].legend()
plt.show()

# %% [markdown]
# A limit that cannot be kept is named in `status`; then nothing for a controller is written and the command ends with status 3.
#
# ## Send it
#
# The command leaves `motion.csv` and a ROS 2 `JointTrajectory` as YAML and JSON, and URScript or set points for libfranka where the arm has six or
# seven revolute joints. From Python:

# %%
robot = design.problem.model.robot
points = SetPoints.sample(design.problem.trajectory, design.z, robot.joint_names, 100.0)  # Hz
folder = Path(mkdtemp())
write_csv(points, folder / "motion.csv")
write_joint_trajectory_yaml(points, folder / "joint_trajectory.yaml")
print((folder / "motion.csv").read_text().splitlines()[0])

# %% [markdown]
# The motion starts and ends at rest, at one posture: move the arm there slowly first. Run it a first time at reduced speed
# (`oed design --scale 0.3`), watch for cables and for what the robot's file does not know, and then record at least six repetitions: what
# differs between them is noise. Record a second design with another `--seed` for validation.
#
# The motion is a function of time; sample it wherever you need it:

# %%
motion = design.motion(np.linspace(0.0, design.horizon, 5))
print(np.round(motion.q, 3))
