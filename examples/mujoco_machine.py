"""A robot in MuJoCo with a real machine around it: sensors, a loop with its faults, drives, gears.

`Conditions` says what is real about it, `Machine` runs a controller there. A sample goes

    joint, noise, encoder, difference and low-pass, controller, delay, limit, gain, lag, gear, joint

An encoder counts a full turn in 2^bits. The velocity is the difference of two readings through a
low-pass of `CUTOFF`. A torque acts ``delay`` samples after the reading that it was made of. Where
a sample is lost the torque stays as it was. All that is random has a seed.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

CUTOFF = 100.0
"""Of the velocities' filter [Hz]."""

PUSH_SPEED = 2.9
"""Of the push on the last joint [rad/s]: no multiple of the motions' frequencies."""

COARSE, FINE = 1e-3, 0.25e-3
"""Longest step of MuJoCo [s], and where drives lag or gears give."""

FAR = 3.0
"""An error that says that a run has diverged [rad]."""

ROTORS = ("known", "none", "unstated", "matched")
"""Where rotors are: in MuJoCo and in the arm that controllers believe in; nowhere; in MuJoCo alone;
as known, but each as large as the inertia that its joint carries, as gears are chosen."""

GEAR_DAMPING = 0.05
"""Damping ratio of a motor against its gear."""


@dataclass(frozen=True)
class Conditions:
    """What is real about the machine; the defaults are the base that all else compares with."""

    rate: float = 1000.0
    """Of the loop [Hz]."""
    encoder_bits: int | None = 16
    """None: positions and velocities are exact."""
    noise: float = 0.0
    """Standard deviation of the positions, before the encoder [rad]."""
    delay: int = 1
    """Samples between a reading and its torque."""
    jitter: float = 0.0
    """By how much a period may differ from its length, as a share of it."""
    drop: float = 0.0
    """Probability that a sample is lost."""
    gain: float = 0.0
    """By how much every drive gives more or less than it was told, as a share."""
    lag: float = 0.0
    """Time constant of the drives [s]."""
    twist: float = 0.0
    """Of every gear under its joint's largest torque [rad]; 0: gears are stiff."""
    push: float = 0.0
    """Amplitude of a sine at `PUSH_SPEED` on the last joint [N·m]."""
    offset: float = 0.0
    """Of the payload to the side [m]."""
    pick_up: float = 0.0
    """When the payload is picked up [s]."""
    rotors: str = ""
    """One of `ROTORS`; none said: the robot's own."""


def add_gears(spec, stiffness, rotor):
    """Add gears that give to MuJoCo's description of a robot: a motor for each joint, after all.

    Spong's model (1987): a motor turns about an axis of its own and shares
    k (θ - q) + d (dθ - dq) with its joint, in MuJoCo a fixed tendon over both.
    """
    damping = 2.0 * GEAR_DAMPING * np.sqrt(stiffness * rotor)
    for name, k, d, inertia in zip(
        [joint.name for joint in spec.joints], stiffness, damping, rotor, strict=True
    ):
        motor = spec.worldbody.add_body(mass=inertia, inertia=[inertia] * 3, explicitinertial=True)
        motor.add_joint(name=f"{name}_motor", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        gear = spec.add_tendon(stiffness=[k, 0, 0], damping=[d, 0, 0])
        gear.wrap_joint(f"{name}_motor", 1.0)
        gear.wrap_joint(name, -1.0)


class Sensors:
    """Encoders, and velocities by difference."""

    def __init__(self, conditions, joints, random):
        self.bits, self.noise, self.random = conditions.encoder_bits, conditions.noise, random
        self.zero = random.uniform(0.0, 1.0, joints)
        """Where in a count the encoders' zeros are."""
        self.q = self.dq = None

    def read(self, q, dq, elapsed):
        """Return what is measured, ``elapsed`` [s] after the last reading."""
        if self.noise:
            q = q + self.random.normal(0.0, self.noise, len(q))
        if self.bits is None:
            return q.copy(), dq.copy()
        count = 2.0 * np.pi / 2**self.bits
        q = np.round(q / count + self.zero) * count - self.zero * count
        if self.q is None:
            self.dq = np.zeros_like(q)
        else:
            share = 1.0 - np.exp(-2.0 * np.pi * CUTOFF * elapsed)
            self.dq = self.dq + share * ((q - self.q) / elapsed - self.dq)
        self.q = q
        return q, self.dq


class Drives:
    """Torques on their way: late, limited, and not quite what they were told."""

    def __init__(self, conditions, effort, resting, random):
        self.effort, self.lag = effort, conditions.lag
        self.gain = 1.0 + conditions.gain * random.choice([-1.0, 1.0], len(effort))
        self.waiting = [resting] * conditions.delay
        self.sent = self.told = self.arrived = resting

    def send(self, tau):
        """Take the torque of a sample, None for the one before; another begins to act."""
        self.sent = self.sent if tau is None else tau
        self.waiting.append(self.sent)
        self.told = np.clip(self.waiting.pop(0), -self.effort, self.effort)

    def arrive(self, h):
        """Return the torque at the motors over the next ``h`` [s]."""
        share = 1.0 if self.lag == 0.0 else 1.0 - np.exp(-h / self.lag)
        self.arrived = self.arrived + share * (self.gain * self.told - self.arrived)
        return self.arrived


@dataclass
class Record:
    """What happened at every sample, in rows."""

    t: np.ndarray
    e: np.ndarray
    """Of the links [rad]."""
    tau: np.ndarray
    """Commanded [N·m]."""
    note: str = ""
    """Why it ended before its time."""


class Machine:
    """The robot of a `World` with everything around it; ``pick_up()`` gives it its payload."""

    def __init__(self, world, effort, conditions, resting, pick_up, seed=0):
        random = np.random.default_rng(seed)
        self.world, self.conditions, self.n, self.random = world, conditions, len(effort), random
        self.sensors = Sensors(conditions, self.n, random)
        self.drives = Drives(conditions, effort, resting, random)
        self.t, self.pick_up = 0.0, pick_up
        self.acted, self.elapsed = [], 0.0
        """Torques and time since the last reading."""
        world.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET

    def start(self, q):
        """Stand still at q."""
        self.world.start(np.tile(q, self.world.model.nv // self.n))

    def run(self, tracker, motion, seconds):
        """Go on for so many seconds; return the record of them."""
        rows, end, note = [], self.t + seconds, ""
        while self.t < end - 1e-9:
            e = self.world.data.qpos[: self.n] - motion(self.t)[0]
            try:
                if not np.abs(e).max() < FAR:
                    raise ValueError(f"error above {FAR:g} rad")
                self._sample(tracker, motion(self.t))
            except ValueError as error:
                note = f"ended at {self.t:.2f} s: {error}"
                break
            rows.append((self.t, e, self.drives.sent))
            self._move()
        t, e, tau = zip(*rows, strict=True)
        return Record(np.array(t), np.array(e), np.array(tau), note)

    def _sample(self, tracker, desired):
        """Read, decide, send; of a lost sample only the last, and the torque before."""
        if self.acted and self.random.random() < self.conditions.drop:
            self.drives.send(None)
            return
        data, motors = self.world.data, slice(-self.n, None)
        q, dq = self.sensors.read(data.qpos[motors], data.qvel[motors], self.elapsed)
        seen = {}
        if self.acted:
            applied = self.acted[0] if len(self.acted) == 1 else np.mean(self.acted, axis=0)
            seen = {"applied": applied, "elapsed": self.elapsed}
        self.drives.send(tracker.step(q, dq, *desired, 1.0 / self.conditions.rate, **seen))
        self.acted, self.elapsed = [], 0.0

    def _move(self):
        """Let a period pass."""
        conditions, world = self.conditions, self.world
        period = 1.0 / conditions.rate
        if conditions.jitter:
            period *= 1.0 + conditions.jitter * self.random.uniform(-1.0, 1.0)
        step = FINE if conditions.lag or conditions.twist else COARSE
        count = int(np.ceil(period / step - 1e-9))
        world.model.opt.timestep = h = period / count
        if self.pick_up and self.t >= conditions.pick_up:
            self.pick_up()
            self.pick_up = None
        for k in range(count):
            tau = np.zeros(world.model.nv)
            tau[-self.n :] = self.drives.arrive(h)
            tau[self.n - 1] += conditions.push * np.sin(PUSH_SPEED * (self.t + k * h))
            world.step(tau)
        self.acted.append(self.drives.told)
        self.elapsed += period
        self.t += period
