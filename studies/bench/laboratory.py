"""The bench's laboratory: controller, instruments, noise, and how a log becomes a recording."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance
from oed.experiment.observer import HighGainObserver
from oed.experiment.recording import Recording, Role
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import Log, Setup, run
from studies.bench.arm import PERIOD, Arm, Series, least_inertia
from studies.bench.case import NoiseKind

LEAD_IN = 1.5  # [s]
BANDWIDTH = 40.0  # [rad/s] of position control
# A motor on a spring is lighter than the arm: the gains that it bears are lower.
SOFT_BANDWIDTH = 18.0  # [rad/s]
MOST_STIFFENED = 4.0  # times the least inertia that a joint's gains may be made for
RESOLUTIONS = tuple(2 * np.pi / 2**bits for bits in (18, 19, 20))  # [rad]
SHAKEN = 5.0  # times the reference's largest speed, which only an unstable control reaches
# Without jitter the steps of an encoder would fall alike in all repetitions, and look like torque.
JITTER = 0.4  # rms of the reading before it is rounded, in steps
TENTHS = 1  # of a degree, digits that a thermometer shows
# Feedforward knows the arm about this well.
FEEDFORWARD_ERROR = 0.05
FEEDFORWARD_FRICTION = 0.85
FEEDFORWARD_WIDTH = 0.05  # [rad/s]
CORNERS = (8.0, 120.0)  # [rad/s] between which the colour of noise is drawn
# Of what the arm feels, the command shows about as much within the bandwidth.
WHITE_SHARE = 0.3  # of the noise level, on top of coloured or felt noise


@dataclass(frozen=True)
class Noise:
    """What disturbs a recording's torque.

    Attributes:
        kind: Which.
        std: (n,) of the torque signal, or of the torque that the arm feels [N m].
        signal: Noises of the torque signal, which add up.
        felt: Torque that the arm feels, or None.
    """

    kind: NoiseKind
    std: tuple[float, ...]
    signal: tuple[Disturbance, ...]
    felt: Disturbance | None

    @classmethod
    def draw(cls, kind: NoiseKind, std: tuple[float, ...], rng: np.random.Generator) -> Noise:
        """A noise of a kind; the corner of the colour is drawn."""
        white = Disturbance(std, (np.inf,) * len(std))
        if kind == "white":
            return cls(kind, std, (white,), None)
        corner = float(np.exp(rng.uniform(*np.log(CORNERS))))
        little = white.with_std(WHITE_SHARE * np.array(std))
        main = np.sqrt(1 - WHITE_SHARE**2) * np.array(std)
        coloured = Disturbance(tuple(main.tolist()), (corner,) * len(std))
        if kind == "coloured":
            return cls(kind, std, (coloured, little), None)
        return cls(kind, std, (little,), coloured)

    def silent(self) -> Noise:
        """None of it."""
        return dataclasses.replace(self, signal=(), felt=None)


@dataclass(frozen=True)
class Laboratory:
    """Everything that stays the same over the recordings of a case.

    Attributes:
        arm: With whatever is hidden in it.
        known: The arm that the feedforward believes in.
        gains: Position control of the true joints.
        resolution: (n,) of the encoders that are logged [rad].
        noise: Of the torque.
        decimation: Control periods a logged sample.
    """

    arm: Arm
    known: Arm
    gains: Controller
    resolution: tuple[float, ...]
    noise: Noise
    decimation: int

    def log(self, reference: Motion, rng: np.random.Generator, runs: int, start: float) -> Log:
        """Signals of the joints, the torque as an ideal sensor sees it.

        The command holds for a period, so that the torque at a sampling instant is the mean of
        the commands on either side of it.

        Raises:
            OedError: If the position control shakes the arm: no recording of any use.
        """
        n = self.arm.robot.n
        spring = 0 if self.arm.transmission is None else 1
        played = _with_still_joints(reference, spring)
        forward = np.pad(expected_torque(self.known, reference), ((0, 0), (0, spring)))
        raw = run(self._setup(spring), played, rng, runs=runs, feedforward=forward, start=start)
        log = dataclasses.replace(
            raw,
            **{
                name: getattr(raw, name)[:, :n]
                for name in ("q", "dq", "measured", "velocity", "command")
            },
        )
        _check_control(reference, log)
        earlier = np.concatenate([log.command[:1], log.command[:-1]])
        return dataclasses.replace(log, command=(earlier + log.command) / 2)

    def recording(
        self, log: Log, rng: np.random.Generator, *, name: str, role: Role
    ) -> tuple[Recording, Float[ndarray, "rows joints"]]:
        """What is logged, and the torque in it without noise [N m].

        Args:
            log: With the torque as an ideal sensor sees it.
            rng: Source of the noise of the torque signal and the jitter of the encoders.
            name: Of the recording.
            role: Of the recording.
        """
        torque, position = log.command, log.q
        for change in self.arm.torque_changes:
            torque = change(torque, PERIOD)
        for change in self.arm.position_changes:
            position = change(position, PERIOD)
        step = np.array(self.resolution)[:, None]
        jitter = JITTER * rng.standard_normal(position.shape)
        position = (np.floor(position / step + jitter) + 0.5) * step
        noisy = torque.copy()
        for noise in self.noise.signal:
            noisy += noise.sample(len(torque), torque.shape[2], PERIOD, rng)
        kept = slice(log.lead, log.lead + log.samples, self.decimation)
        runs = log.t.shape[1]
        t = np.ascontiguousarray(log.t[kept].T).ravel()
        shown = self.arm.temperature
        recording = Recording(
            name=name,
            role=role,
            t=t,
            q=_stacked(position[kept]),
            tau=_stacked(noisy[kept]),
            repetition=np.repeat(np.arange(runs), len(log.t[kept])) if runs > 1 else None,
            temperature=None if shown is None else np.round(shown(t), TENTHS),
            source="bench",
        )
        return recording, _stacked(torque[kept])

    def _setup(self, spring: int) -> Setup:
        weak = (1e-9,) * spring
        controller = Controller(
            (*self.gains.stiffness, *weak),
            (*self.gains.damping, *weak),
            HighGainObserver.uniform(self.gains.n + spring),
            PERIOD,
        )
        felt = self.noise.felt
        if felt is not None and spring:
            felt = Disturbance((*felt.std, 0.0), (*felt.corner, np.inf))
        # The drive counts on its motor, before the gear: fine enough to be taken for exact.
        return Setup(
            self.arm.plant(),
            controller,
            Sensors(),
            felt,
            lead_in=LEAD_IN,
            substeps=self.arm.substeps,
        )


def _check_control(reference: Motion, log: Log) -> None:
    wanted = np.abs(reference.dq).max(axis=0)
    fastest = np.abs(log.dq).max(axis=(0, 2))
    joint = int(np.argmax(fastest / wanted))
    if fastest[joint] > SHAKEN * wanted[joint]:
        raise OedError(
            f"the position control shakes the arm: joint {joint + 1} reaches "
            f"{fastest[joint]:.3g} rad/s where {wanted[joint]:.3g} are wanted"
        )


def build_laboratory(
    arm: Arm,
    known: Arm,
    noise: Noise,
    decimation: int,
    rng: np.random.Generator,
) -> Laboratory:
    """A laboratory with critically damped position control and encoders of a drawn resolution.

    Args:
        arm: With whatever is hidden in it.
        known: The same arm before anything was hidden.
        noise: Of the torque.
        decimation: Control periods a logged sample.
        rng: Source of every draw.
    """
    least, mean = least_inertia(known.robot, rng)
    # A light wrist gives way behind a heavy elbow: gains for the elbow alone would shake both.
    inertia = np.minimum(mean, MOST_STIFFENED * least)
    bandwidth = BANDWIDTH if arm.transmission is None else SOFT_BANDWIDTH
    gains = Controller(
        tuple((inertia * bandwidth**2).tolist()),
        tuple((2 * inertia * bandwidth).tolist()),
        HighGainObserver.uniform(known.robot.n),
        PERIOD,
    )
    scale = np.repeat(1 + FEEDFORWARD_ERROR * rng.standard_normal(known.robot.n), 10)
    believed = dataclasses.replace(
        known, robot=known.robot.with_parameters(known.robot.parameters * scale)
    )
    resolution = (float(rng.choice(RESOLUTIONS)),) * known.robot.n
    return Laboratory(arm, believed, gains, resolution, noise, decimation)


def expected_torque(arm: Arm, reference: Motion) -> Float[ndarray, "samples joints"]:
    """Torque that a motion needs of an arm without anything hidden, for feedforward [N m]."""
    model = TorqueModel.standard(arm.robot, sign_width=FEEDFORWARD_WIDTH)
    pairs = zip(arm.coulomb, arm.viscous, strict=True)
    friction = FEEDFORWARD_FRICTION * np.array([x for pair in pairs for x in pair])
    return model.torque(np.concatenate([arm.robot.parameters, friction]), reference)


def _with_still_joints(reference: Motion, joints: int) -> Motion:
    if not joints:
        return reference
    return Motion(
        reference.t,
        *(np.pad(x, ((0, 0), (0, joints))) for x in (reference.q, reference.dq, reference.ddq)),
    )


def _stacked(x: Series) -> Float[ndarray, "rows joints"]:
    """Runs one after another."""
    return np.ascontiguousarray(x.transpose(2, 0, 1).reshape(-1, x.shape[1]))
