"""Headers as makers of robots, loggers and laboratories of several languages write them."""

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.column_names import find_columns
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.propose_columns import propose_columns
from oed.experiment.log_format import LogFormat
from oed.experiment.logs import Log, table_of
from oed.robot import load_robot

JOINTS = ("shoulder", "elbow")


def log_of(names):
    return Log("log.csv", (table_of({name: np.arange(5.0) for name in names}, "log.csv"),))


def each(pattern, first=1):
    return tuple(pattern.format(first + j) for j in range(2))


def proposal(*patterns, first=1, **stated):
    time, *others = patterns
    names = [time, *(name for pattern in others for name in each(pattern, first))]
    return propose_columns(log_of(names), RobotJoints(JOINTS, JOINTS), stated)


RIGHT = {
    "KUKA trace": ("t", "$AXIS_ACT[{}]", "$VEL_AXIS_ACT[{}]", "$TORQUE_AXIS_ACT[{}]"),
    "KUKA RSI": ("IPOC", "AIPos.A{}", "", "MACur.A{}", "ASPos.A{}"),
    "KUKA WorkVisual": (
        *("Zeit [s]", "Istposition A{} [Grad]", "Istgeschwindigkeit A{} [Grad/s]"),
        *("Istdrehmoment A{} [Nm]", "Sollposition A{} [Grad]"),
    ),
    "KUKA Sunrise": (
        *("t", "axisQMsr_LBR_iiwa_7_R800[{}]", "", "axisTauMsr_LBR_iiwa_7_R800[{}]"),
        *("axisQCmd_LBR_iiwa_7_R800[{}]", "axisTauExtMsr_LBR_iiwa_7_R800[{}]"),
    ),
    "ABB EGM": ("time", "feedBack.joints.joints[{}]", "", "feedBack.torque[{}]", "planned.joints.joints[{}]"),
    "Fanuc": ("Time[ms]", "J{} Actual Angle[deg]", "", "J{} Motor Current[A]", "J{} Disturbance Torque[Nm]"),
    "Staubli": ("time", "JntPosFbk{}", "JntVelFbk{}", "JntTorqueFbk{}", "JntPosCmd{}"),
    "Franka": ("time", "state.q[{}]", "state.dq[{}]", "state.tau_J[{}]", "state.q_d[{}]", "state.tau_J_d[{}]"),
    "Dynamixel": ("time_ms", "dxl_{}_pos_ticks", "dxl_{}_vel_rpm", "dxl_{}_cur_mA"),
    "rostopic": ("%time", "field.position{}", "field.velocity{}", "field.effort{}"),
    "MATLAB variables": ("time", "joint{}Position", "joint{}Velocity", "joint{}Torque"),
    "MATLAB units": ("t_s", "q{}_deg", "dq{}_deg_per_s", "tau{}_Nm"),
    "MATLAB columns": ("t", "q(:,{})", "dq(:,{})", "tau(:,{})"),
    "Simulink Data": ("out.tout", "out.q.Data[{}]", "out.dq.Data[{}]", "out.tau.Data[{}]"),
    "Simulink signals": ("out.time", "out.q.signals.values[{}]", "", "out.tau.signals.values[{}]"),
    "Simulink scope": ("time", "q:{}", "dq:{}", "tau:{}"),
    "MuJoCo": ("time", "qpos[{}]", "qvel[{}]", "qfrc_actuator[{}]", "ctrl[{}]"),
    "pandas": ("t", "('q', {})", "('dq', {})", "('tau', {})"),
    "TeX": ("t", "$q_{{{}}}$ [rad]", "", r"$\tau_{{{}}}$ [Nm]"),
    "Greek": ("t", "θ{} [rad]", "θ\u0307{} [rad/s]", "τ{} [Nm]"),
    "units alone": ("Time (s)", "J{} [deg]", "J{} [deg/s]", "J{} [A]"),
    "torques beside currents": ("t", "J{} [deg]", "", "J{} [Nm]", "J{} [A]"),
    "actual": ("t", "q_a[{}]", "dq_a[{}]", "tau_a[{}]", "q_d[{}]", "tau_d[{}]"),
    "actual behind": ("t", "q_{}_a", "dq_{}_a", "tau_{}_a", "q_{}_d", "tau_{}_d"),
    "desired": ("t", "q_m{}", "", "tau_m{}", "q_d{}"),
    "German": ("Zeit in ms", "Gelenkwinkel {} [Grad]", "Gelenkgeschwindigkeit {} [Grad/s]", "Gelenkmoment {} [Nm]"),
    "German values": ("Zeit", "Achse {} Istwert [Grad]", "", "Achse {} Motorstrom [A]", "Achse {} Sollwert [Grad]"),
    "French": ("Temps [s]", "Angle articulaire {} [°]", "Vitesse {} [tr/min]", "Courant moteur {} [A]"),
    "Spanish": ("Tiempo [s]", "Posición {} [rad]", "Velocidad {} [rad/s]", "Par {} [N·m]"),
    "Portuguese": ("tempo (s)", "posição {} (rad)", "velocidade {} (rad/s)", "torque {} (N.m)"),
    "Italian": ("tempo_s", "angolo_giunto_{}_gradi", "", "coppia_giunto_{}_Nm", "corrente_giunto_{}_A"),
}  # fmt: skip


@pytest.mark.parametrize("name", RIGHT)
@pytest.mark.parametrize("order", [1, -1])
def test_headers_are_read_in_whatever_order(name, order):
    time, q, dq, tau, *others = RIGHT[name]
    found = proposal(time, *filter(None, (q, dq, tau, *others)[::order]))
    assert found.columns["q"] == each(q)
    assert found.columns.get("dq", ()) == (each(dq) if dq else ())
    assert found.columns["tau"] == each(tau)
    assert found.columns["t"] == (time,)


@pytest.mark.parametrize(
    "columns",
    [
        ("t", "status.joint_{}", "tau_{}"),
        ("t", "joint_mode_{}", "tau_{}"),
        ("t", "position_tcp[{}]", "tau[{}]"),
        ("t", "q_dot[{}]", "effort[{}]"),
        ("t", "q[{}]", "tau_limit[{}]"),
        ("t", "q{}", "par_{}"),
        ("t", "q_m[{}]", "q_l[{}]", "tau_m[{}]", "tau_l[{}]"),
        ("t", "q_a_{}", "q_b_{}", "tau_a_{}", "tau_b_{}"),
        ("t", "q{}", "torque{} [V]"),
        ("t", "q_{}_d", "tau_{}"),
    ],
)
def test_what_is_of_something_else_is_refused(columns):
    with pytest.raises(DataSetError, match="--columns"):
        proposal(*columns)


@pytest.mark.parametrize(
    ("torque", "kind", "unit"),
    [
        ("tau_{}_a", "measured", ""),
        ("torque{} [A]", "current", "A"),
        ("torque{} [mA]", "current", "mA"),
        ("i{}_a", "current", "A"),
        ("torque{}_Nm", "measured", "N m"),
    ],
)
def test_a_torque_in_amperes_is_a_current_and_an_ending_that_contradicts_is_no_unit(
    torque, kind, unit
):
    found = proposal("t", "q_{}_a" if torque.endswith("_a") and "tau" in torque else "q{}", torque)
    assert found.torque == kind
    assert found.units.get("tau", ("",)) == (unit,)


def test_one_joint_may_be_called_a():
    log = log_of(("t", "q_a", "dq_a", "tau_a"))
    found = propose_columns(log, RobotJoints(("a",), ("a",)), {})
    assert found.units == {}
    assert found.torque == "measured"


@pytest.mark.parametrize("names", ["Motorstrom {}", "load {} [A]"])
def test_named_columns_are_what_their_names_say(names):
    assert proposal("t", "q{}", names, tau=each(names)).torque == "current"


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("dq{}_rad_s", "rad/s"),
        ("dq{}_degps", "deg/s"),
        ("dq{} [Deg/s]", "deg/s"),
        ("dq{}_rpm", "rpm"),
        ("dq{} in rad/s", "rad/s"),
    ],
)
def test_units_of_velocities_in_names_of_variables(name, unit):
    assert proposal("t", "q{}", name, "tau{}").units["dq"] == (unit,)


def test_a_unit_that_is_not_known_is_not_taken_for_si():
    robot = load_robot("builtin:imi_scara")
    stated = {"q": each("q{}"), "tau": each("torque {} [kgf.cm]")}
    log = log_of(("t", *stated["q"], *stated["tau"]))
    with pytest.raises(DataSetError, match=r"'kgf.cm' is none of the units of tau .*--units tau="):
        find_columns(log, robot, LogFormat(columns={"t": ("t",), **stated}))
    units = {"tau": ("mNm",)}
    found = find_columns(log, robot, LogFormat(columns={"t": ("t",), **stated}, units=units))
    assert found.fields["tau"] == stated["tau"]


def test_joints_of_another_arm_may_be_of_another_file():
    with pytest.raises(DataSetError, match="the file of the robot that was logged with --robot"):
        propose_columns(
            log_of(("t", "q_hip", "q_knee", "tau_hip", "tau_knee")), RobotJoints(JOINTS, JOINTS), {}
        )
