"""How loggers name what they log, by quantity, the likelier name first.

Sources: sensor_msgs/JointState and control_msgs (ROS 2), the field list of Universal Robots' RTDE,
`franka::logToCSV` of libfranka, LeRobot's feature names, pyfri for the KUKA LBR, Kinova's Kortex,
MuJoCo's arrays, KUKA's system variables and RobotSensorInterface (AIPos, MACur, IPOC). Words of other
languages stand as `spelling` writes them, without accents.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.experiment.drive import TorqueKind
from oed.experiment.units import Quantity

# Words before a quantity that say that it is of the joints: of what turns the joint, ahead of the
# gear and its elasticity, or of the joint itself.
OF_MOTORS = (
    "motor",
    "motors",
    "drive",
    "drives",
    "servo",
    "servos",
    "actuator",
    "actuators",
    "moteur",
    "motore",
)
OF_JOINTS = (
    *("joint", "joints", "jnt", "axis", "axes", "axe", "link", "links", "gelenk", "achse", "achs"),
    *("articulation", "articulaire", "articulacion", "eje", "junta", "giunto", "asse", *OF_MOTORS),
)
AT_THIS_INSTANT = "current"  # as in current_joint_position, where it is no quantity
TIMES = (
    *("t", "time", "stamp", "timestamp", "header.stamp", "time_stamp", "t_s", "seconds", "sec"),
    *("elapsed", "elapsed_time", "duration", "zeit", "zeitstempel", "clock", "received"),
    *("times", "timestamps", "tout", "tiempo", "tempo", "ipoc"),
    "temps",  # French; in English it may be temperatures
)
# Without words on joints and on who says it, such as actual: see `name_words`.
# Where no word tells a quantity, numbers of joints are what their unit says, as in J1 [Nm], and without
# one their positions, as in ABB's joints[0].
JOINTS_ALONE = ("axis", "axes", "joint", "joints", "jnt", "achse", "j")
POSITIONS = (
    *("q", "position", "positions", "pos", "qpos", "angle", "angles", "theta", "mp"),
    *("winkel", "posicion", "angulo", "posicao", "posizione", "angolo", "aipos", "state"),
    *JOINTS_ALONE,
)
VELOCITIES = (
    *("dq", "qd", "velocity", "velocities", "vel", "qvel", "speed", "omega", "velo"),
    *("qdot", "q_dot", "theta_dot", "geschwindigkeit", "drehzahl", "vitesse", "vitesses"),
    *("velocidad", "velocidade", "velocita", *JOINTS_ALONE),
)
ACCELERATIONS = (
    *("ddq", "qdd", "acceleration", "accelerations", "acc", "qddot", "q_ddot", "theta_ddot"),
    *JOINTS_ALONE,
)
TORQUES: Mapping[TorqueKind, Sequence[str]] = {
    "measured": (
        *("tau", "tau_j", "effort", "efforts", "torque", "torques", "moment", "mt", "drehmoment"),
        *("trq", "trqs", "couple", "couples", "coppia", "par", *JOINTS_ALONE),
    ),
    "current": (
        *("current_as_torque", "current", "currents", "cur", "curr"),
        *("i", "iq", "i_q", "current_motor", "strom", "motorstrom", "courant"),
        *("corriente", "corrente", "macur"),
    ),
    # These say so without a word of their own.
    "commanded": ("tau_d", "tau_j_d", "qfrc_actuator", "ctrl"),
}
TEMPERATURES = ("temperature", "temperatures", "temp")
# Words that are of a quantity only where its unit stands beside them: par is Spanish for torque, and
# short for a parameter.
ONLY_WITH_A_UNIT = frozenset({"par"})
STEMS: Mapping[Quantity, Sequence[str]] = {
    "t": TIMES,
    "q": POSITIONS,
    "dq": VELOCITIES,
    "ddq": ACCELERATIONS,
    "temperature": TEMPERATURES,
}
EPISODES = ("episode_index", "episode", "run")
# Words that tell nothing of whose a quantity is.
OF_THE_ROBOT = frozenset({
    *("robot", "state", "states", AT_THIS_INSTANT, *OF_JOINTS),
    *(*POSITIONS, *VELOCITIES, *ACCELERATIONS, *TEMPERATURES),
    *(stem for stems in TORQUES.values() for stem in stems),
})  # fmt: skip
