"""What MJCF cannot say, as C for a plug-in of MuJoCo: the force of `mujoco_force` without Python."""

from __future__ import annotations

import json
import re
from pathlib import Path
from string import Template
from xml.etree import ElementTree

from oed.export.c_code import generated_code
from oed.export.effect_torque import SIGN_WIDTH, EffectTorque
from oed.export.model import Model
from oed.export.mujoco_force import NATIVE
from oed.export.xml_text import number, write_xml
from oed.in_comment import in_comment
from oed.report.json_file import write_atomically

SOURCE = Template(
    """/* Passive force of $robot as a plug-in of MuJoCo, written by oed.

   DIR=$$(python -c "import mujoco; print(mujoco.__path__[0])")
   cc -O2 -shared -fPIC -I"$$DIR/include" $source -o lib$stem.so "$$DIR"/libmujoco.so* -lm

   Load it before the model: mujoco.mj_loadPluginLibrary("lib$stem.so"), or from
   MuJoCo's own folder of plug-ins. Friction under load takes the acceleration of the step before.
   Plugin state: whether it has begun, what effects remember, and what they do at the next step. */
#include <math.h>
#include <string.h>

#include <mujoco/mujoco.h>

$generated
enum { JOINTS = $joints, MEMORY = $memory, STATE = 1 + 2 * MEMORY };
static const double STEP = $step; /* [s] that effects with a memory go on by */
static const char *const NAMES[JOINTS] = {$names};

static int nstate(const mjModel *m, int instance) { return STATE; }

static int init(const mjModel *m, mjData *d, int instance) {
  for (int j = 0; j < JOINTS; j++) {
    if (mj_name2id(m, mjOBJ_JOINT, NAMES[j]) < 0) {
      mju_warning("$plugin: the model has no joint %s", NAMES[j]);
      return -1;
    }
  }
  if (MEMORY > 0 && m->opt.integrator == mjINT_RK4) {
    mju_warning("$plugin: effects with a memory go on once a step: choose another integrator than RK4");
    return -1;
  }
  if (MEMORY > 0 && fabs(m->opt.timestep - STEP) > 1e-9 * STEP) {
    mju_warning("$plugin: effects with a memory go on by %g s: set that timestep", STEP);
    return -1;
  }
  return 0;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance) {
  memset(state, 0, STATE * sizeof(mjtNum));
}

static void compute(const mjModel *m, mjData *d, int instance, int capability) {
  mjtNum *state = d->plugin_state + m->plugin_stateadr[instance];
  mjtNum *memory = state + 1, *next = memory + MEMORY;
  double q[JOINTS], dq[JOINTS], ddq[JOINTS], still[JOINTS] = {0}, tau[JOINTS];
  int dof[JOINTS], iw[$iw];
  double w[$w];
  for (int j = 0; j < JOINTS; j++) {
    int id = mj_name2id(m, mjOBJ_JOINT, NAMES[j]);
    dof[j] = m->jnt_dofadr[id];
    q[j] = d->qpos[m->jnt_qposadr[id]];
    dq[j] = d->qvel[dof[j]];
    ddq[j] = d->qacc[dof[j]];
  }
  if (state[0] == 0) {
    const double *arg[$arg] = {q, dq, still};
    double *res[$res] = {memory};
    begin(arg, res, iw, w, 0);
    state[0] = 1;
  }
  const double *arg[$arg] = {q, dq, ddq, memory};
  double *res[$res] = {tau, next};
  torque(arg, res, iw, w, 0);
  for (int j = 0; j < JOINTS; j++) d->qfrc_passive[dof[j]] -= tau[j];
}

static void advance(const mjModel *m, mjData *d, int instance) {
  mjtNum *memory = d->plugin_state + m->plugin_stateadr[instance] + 1;
  memcpy(memory, memory + MEMORY, MEMORY * sizeof(mjtNum));
}

mjPLUGIN_LIB_INIT($symbol) {
  mjpPlugin plugin;
  mjp_defaultPlugin(&plugin);
  plugin.name = "$plugin";
  plugin.capabilityflags |= mjPLUGIN_PASSIVE;
  plugin.nstate = nstate;
  plugin.init = init;
  plugin.reset = reset;
  plugin.compute = compute;
  plugin.advance = advance;
  mjp_registerPlugin(&plugin);
}
"""
)


def write_plugin(
    model: Model,
    folder: Path,
    *,
    step: float,
    name: str | None = None,
    robot_file: str = "robot_mujoco.xml",
    sign_width: float = SIGN_WIDTH,
) -> tuple[Path, Path]:
    """Write the source of a plug-in, and an MJCF file that includes the robot's and has it.

    Args:
        model: The torque model.
        folder: That is there, with the robot's MJCF file.
        step: Of the simulation [s].
        name: Of the plug-in behind "oed.", no other of which may be loaded; the robot's if None.
        robot_file: The robot's MJCF file, without dry friction.
        sign_width: Velocity over which signs turn at least [rad/s]; 0 for the model's own.

    Returns:
        Source and MJCF file.
    """
    own = re.sub(r"\W", "_", name or model.robot.name, flags=re.ASCII)
    source = folder / "oed_passive.c"
    effects = EffectTorque.of(model, NATIVE, step, sign_width=sign_width)
    functions = (effects.dynamics.torque, effects.dynamics.begin)
    text = SOURCE.substitute(
        robot=in_comment(model.robot.name),
        source=source.name,
        stem=source.stem,
        plugin=f"oed.{own}",
        symbol=f"oed_{own}",
        generated=generated_code(functions),
        joints=model.robot.n,
        memory=len(effects.keeps),
        step=repr(step),
        names=", ".join(json.dumps(x, ensure_ascii=False) for x in model.robot.joint_names),
        arg=max(f.sz_arg() for f in functions),
        res=max(f.sz_res() for f in functions),
        iw=max(1, *(f.sz_iw() for f in functions)),
        w=max(1, *(f.sz_w() for f in functions)),
    )
    write_atomically(source, text)
    root = ElementTree.Element("mujoco", model=model.robot.name)
    ElementTree.SubElement(root, "include", file=robot_file)
    ElementTree.SubElement(root, "option", timestep=number(step))
    plugin = ElementTree.SubElement(
        ElementTree.SubElement(root, "extension"), "plugin", plugin=f"oed.{own}"
    )
    ElementTree.SubElement(plugin, "instance", name="effects")
    scene = folder / "robot_plugin.xml"
    write_xml(scene, root)
    return source, scene
