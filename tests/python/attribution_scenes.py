"""Runs with one planted cause each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import steadyarm as sa

PERIOD = 1e-3


def two_link(**changes: Any) -> sa.TwoLink:
    """The paper's nominal arm, lying flat and without friction."""
    given = {"mass": (4, 4), "length": (0.5, 0.5), "inertia": (0.2, 0.2)}
    return sa.TwoLink(**(given | changes))


def waves(joints: int, size: float, speed: float = 2.0, offset: Any = 0.0) -> sa.Sines:
    return sa.Sines(speed, sin=np.full(joints, size), offset=np.broadcast_to(offset, joints))


def follow(
    nominal: sa.Arm,
    plant: sa.Plant,
    path: Any,
    law: Any = sa.laws.computed_torque,
    duration: float = 4.0,
    bandwidth: float = 15.0,
    **options: Any,
) -> sa.Run:
    """A run that starts on its path."""
    tracker = law(nominal, bandwidth=bandwidth) if callable(law) else law
    q0, dq0, _ = (np.asarray(part, float) for part in path(0.0))
    options = {"control_period": PERIOD, "q0": q0, "dq0": dq0} | options
    return sa.simulate(plant, tracker, path, duration, PERIOD, **options)


def small(**changes: Any) -> tuple[sa.TwoLink, sa.Plant]:
    """The two-link arm, and the same as a plant with changes."""
    return two_link(), sa.Plant(two_link(**changes))


def inertia() -> sa.Run:
    # The moments alone are in no term but M.
    return follow(*small(inertia=(0.6, 0.6)), waves(2, 0.5))


def gravity() -> sa.Run:
    nominal = two_link(gravity=9.81)
    return follow(nominal, sa.Plant(two_link(gravity=9.81, mass=(6, 4))), waves(2, 0.3, 1.0))


def coriolis() -> sa.Run:
    # At constant speed with the elbow bent: no acceleration, centrifugal torque at joint 2.
    def turning(t: float) -> tuple[list[float], list[float], list[float]]:
        return [3.0 * t, 1.5], [3.0, 0.0], [0.0, 0.0]

    return follow(*small(mass=(4, 6)), turning)


def coulomb() -> sa.Run:
    return follow(*small(coulomb=(1.0, 1.0)), waves(2, 0.5))


def viscous() -> sa.Run:
    return follow(*small(viscous=(2.0, 2.0)), waves(2, 0.5))


def disturbance() -> sa.Run:
    push = sa.Pulses((0.5, 2.0), ((2.0, 1.0), (-1.0, 2.0)), (0.7, 1.0))
    return follow(two_link(), sa.Plant(two_link(), push), waves(2, 0.5))


def effort_limit() -> sa.Run:
    return follow(two_link(), sa.Plant(two_link(), effort_limit=(8.0, 3.0)), waves(2, 0.5, 3.0))


def delay() -> sa.Run:
    effects = sa.Effects(delay=4)
    return follow(*small(), waves(2, 0.5, 4.0), control_period=4e-3, effects=effects)


def sampling() -> sa.Run:
    return follow(*small(), waves(2, 0.5, 4.0), control_period=25e-3)


def gain() -> sa.Run:
    return follow(*small(), waves(2, 0.5), effects=sa.Effects(gain=0.8))


def cogging() -> sa.Run:
    return follow(*small(), waves(2, 0.5), effects=sa.Effects(cogging=1.0, cogging_per_turn=20.0))


def lag() -> sa.Run:
    return follow(*small(), waves(2, 0.5, 4.0), effects=sa.Effects(lag=10e-3))


def measurement() -> sa.Run:
    return follow(*small(), waves(2, 0.5), effects=sa.Effects(encoder_bits=9))


def feedforward() -> sa.Run:
    return follow(*small(), waves(2, 0.5), sa.laws.pd_gravity)


def hand_over() -> sa.Run:
    tracker = sa.laws.computed_torque(two_link(), bandwidth=15.0, hand_over=3.0)
    return follow(*small(), waves(2, 0.5), tracker, q0=(0.4, -0.4))


def start() -> sa.Run:
    return follow(*small(), waves(2, 0.5), q0=(0.4, -0.4))


PANDA = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8])
UR5E = np.array([0.0, -1.2, 1.4, -1.6, -1.5, 0.0])


def robot(name: str) -> sa.Serial:
    """A shipped arm without friction, and with rotors."""
    return sa.Serial.shipped(name).without_friction().with_armature(0.1)


def on_panda(change: Callable[[sa.Serial], sa.Serial], push: Any = None, **options: Any) -> sa.Run:
    arm = robot("panda")
    return follow(arm, sa.Plant(change(arm), push), waves(7, 0.2, offset=PANDA), **options)


def heavier(arm: sa.Serial, link: int, share: float) -> sa.Serial:
    """A link with masses and moments so many times as large."""
    scale = np.ones(10 * arm.joints)
    scale[10 * link : 10 * link + 10] = share
    return arm.with_parameters(scale * arm.inertial_parameters())


def panda_payload() -> sa.Run:
    return on_panda(lambda arm: arm.with_payload(2.0, (0.0, 0.0, 0.05)))


def panda_friction() -> sa.Run:
    return on_panda(lambda arm: arm.with_friction(coulomb=0.5, viscous=0.3))


def panda_gravity() -> sa.Run:
    return on_panda(lambda arm: heavier(arm, 2, 1.5))


def panda_wrench() -> sa.Run:
    return on_panda(lambda arm: arm, sa.Wrench(force=(3.0, 5.0, -8.0)))


def panda_delay() -> sa.Run:
    return on_panda(lambda arm: arm, control_period=4e-3, effects=sa.Effects(delay=3))


def panda_contact() -> sa.Run:
    # Joint 4 ends at -0.0698 rad: the motion asks for up to 0.2 rad.
    arm = robot("panda")
    plant = sa.Plant(arm.with_stops(np.full(7, 2e3)))
    offset = PANDA.copy()
    offset[3] = -0.15
    path = sa.Sines(2.0, sin=0.35 * np.eye(7)[3], offset=offset)
    return follow(arm, plant, path)


def ur5e_gain() -> sa.Run:
    arm = robot("ur5e")
    effects = sa.Effects(gain=0.9)
    return follow(arm, sa.Plant(arm), waves(6, 0.2, offset=UR5E), effects=effects)


def ur5e_inertia() -> sa.Run:
    # Rotors are in no term but M.
    arm = robot("ur5e")
    path = waves(6, 0.2, 4.0, offset=UR5E)
    return follow(arm, sa.Plant(arm.with_armature(0.4)), path)


PLANTED: dict[Callable[[], sa.Run], str] = {
    inertia: "inertia",
    gravity: "gravity",
    coriolis: "coriolis",
    coulomb: "friction",
    viscous: "friction",
    disturbance: "disturbance",
    effort_limit: "saturation",
    delay: "delay",
    sampling: "sampling",
    gain: "actuators",
    cogging: "actuators",
    lag: "actuators",
    measurement: "measurement",
    feedforward: "feedforward",
    hand_over: "hand_over",
    panda_payload: "payload_gravity",
    panda_friction: "friction",
    panda_gravity: "gravity",
    panda_wrench: "disturbance",
    panda_delay: "delay",
    panda_contact: "contact",
    ur5e_gain: "actuators",
    ur5e_inertia: "inertia",
}
"""Scenes with the cause that is planted in each."""


def assert_adds_up(found: sa.Attribution, run: sa.Run) -> None:
    """To 1e-9 N·m at every row, with a rest that is rounding; and the error to rounding."""
    assert np.abs(sum(found.torque.values()) - found.whole).max() < 1e-9
    assert np.abs(found.torque["rest"]).max() < 1e-9
    assert np.abs(sum(found.error.values()) - run.e).max() < 1e-12
    for shares in (found.torque_shares, found.error_shares):
        total = sum(shares.values())
        assert np.abs(total[~np.isnan(total)] - 1.0).max(initial=0.0) < 1e-9
