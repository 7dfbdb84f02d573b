"""Robots for MuJoCo, and every controller for them, each by one rule.

`ROBOTS` have a file, a pose to move about, a payload and rotors; `machine` gives what the
controllers believe and the machine as it is. `controllers` are those of the scenario
``panda_payload`` with its bandwidths, those of mujoco_payload.py, and the recommended one.
"""

import tomllib
from dataclasses import dataclass
from functools import partial

import mujoco
import mujoco_payload as example
import numpy as np
import steadyarm as sa
from mujoco_machine import CUTOFF, Machine, add_gears

BIG, WRIST = 0.05, 0.02
"""Rotors seen through their gears [kg·m²]: of the last three joints, and of those before."""

EXACT = 32
"""Bits of an encoder that is as good as exact."""

HAND_OVER = 3.0
"""Of every controller [1/s]."""


@dataclass(frozen=True)
class Robot:
    """A robot to run."""

    file: str
    """Under example-robot-data's robots, or the name of an arm that steadyarm ships."""
    tip: str
    middle: tuple[float, ...]
    """Pose about which it moves [rad]."""
    base: str = ""
    payload: float = 2.0
    """[kg]; the recommended controller alone is told that no load is heavier."""
    rotors: str = "known"
    """Where they are by default; see `mujoco_machine.ROTORS`."""
    rotor: float | None = None
    """Of every joint [kg·m²]; None: `BIG` and `WRIST`."""

    def read(self):
        """Return the arm, and MuJoCo's description of it."""
        if not self.base:
            arm = sa.Serial.shipped(self.file)
            return arm.without_friction(), described(arm)
        path = example.panda().parents[2] / self.file
        urdf = example.bare(path, self.base, self.tip)
        arm = sa.Serial.from_urdf(urdf, tip=self.tip)
        return arm.without_friction(), mujoco.MjSpec.from_string(urdf)

    def armature(self):
        """Return the rotors of all joints [kg·m²]."""
        n = len(self.middle)
        sizes = np.where(np.arange(n) < n - 3, BIG, WRIST)
        return sizes if self.rotor is None else np.full(n, self.rotor)


ROBOTS = {
    "panda": Robot(
        "panda_description/urdf/panda.urdf",
        base=example.PANDA["base"],
        tip=example.PANDA["tip"],
        middle=example.PANDA["middle"],
        rotors="none",
        rotor=0.1,
    ),
    "ur5e": Robot("ur5e", tip="tip", middle=(0.0, -1.2, 1.4, -1.0, -1.4, 0.3)),
    "xarm7": Robot(
        "xarm_description/urdf/xarm7.urdf",
        base="link_base",
        tip="link_eef",
        middle=(0.0, -0.4, 0.2, 1.2, 0.2, 1.0, 0.3),
    ),
    "z1": Robot(
        "z1_description/urdf/z1.urdf",
        base="link00",
        tip="link06",
        middle=(0.0, 1.2, -1.4, 0.3, 0.2, 0.3),
    ),
    "kinova": Robot(
        "kinova_description/robots/kinova.urdf",
        base="j2s6s200_link_base",
        tip="j2s6s200_end_effector",
        middle=(4.8, 2.9, 1.3, 4.2, 1.6, 1.3),
    ),
}


def described(arm):
    """Return MuJoCo's description of an arm that steadyarm ships; its last body is the "tip"."""
    spec = mujoco.MjSpec()
    body, said = spec.worldbody, tomllib.loads(arm.to_toml())
    for joint in [*said["joint"], {"link": "tip", **said["tip"]}]:
        body = body.add_body(name=joint["link"], pos=joint["translation"])
        mujoco.mju_mat2Quat(body.quat, np.ravel(joint.get("rotation", np.eye(3))))
        if "mass" in joint:
            (xx, xy, xz), (_, yy, yz), (*_, zz) = joint["moments"]
            body.mass, body.ipos, body.explicitinertial = joint["mass"], joint["com"], True
            body.fullinertia = [xx, yy, zz, xy, xz, yz]
            hinge = mujoco.mjtJoint.mjJNT_HINGE
            body.add_joint(name=joint["name"], type=hinge, axis=joint["axis"])
    return spec


def machine(robot, conditions, seed=0):
    """Return the arm that controllers believe in, the efforts they may take, and the machine."""
    arm, spec = robot.read()
    rotors = conditions.rotors or robot.rotors
    middle = np.array(robot.middle)
    rotor = robot.armature() * (rotors != "none")
    if rotors == "matched":
        rotor = np.diag(arm.mass_matrix(middle)).copy()
    effort = arm.limits["effort"]
    friction = example.FRICTION * effort
    if conditions.twist:
        add_gears(spec, effort / conditions.twist, rotor)
    world = example.World(spec.compile(), robot.tip)
    model, motors = world.model, slice(-arm.joints, None)
    model.dof_frictionloss[motors] = model.dof_damping[motors] = friction
    if not conditions.twist:
        model.dof_armature[:] = rotor
    pick_up = partial(world.load, robot.payload, (conditions.offset, 0.0, 0.0))
    made = Machine(world, effort, conditions, arm.gravity(middle), pick_up, seed)
    made.start(middle)
    return arm if rotors == "unstated" else arm.with_armature(rotor), effort, made


def controllers(robot, arm, effort, conditions, motion):
    """Return a function without arguments for every controller, by name; ``motion`` gives sets."""
    middle = np.array(robot.middle)
    common = {"effort_limit": effort, "hand_over": HAND_OVER, "delay": conditions.delay}
    if conditions.encoder_bits is not None:
        common["velocity_filter"] = CUTOFF
    sampled = common | {"control_period": 1.0 / conditions.rate}
    laws = dict(sa.Scenario.read("panda_payload").controllers)
    laws["momentum_observer_fast"] = {
        "law": "momentum_observer",
        "kp": example.KP,
        "kv": example.KV,
        "pole": 50.0,
    }
    made = {name: partial(sa.Controller, arm, law, **sampled) for name, law in laws.items()}
    made["example_pd_gravity"] = partial(
        sa.Controller, arm, example.GravityPd(arm, middle), **common
    )
    learning = example.compensator(motion, arm.joints)
    made["example_fuzzy"] = partial(
        sa.ComputedTorque, arm, example.KP, example.KV, compensator=learning, **common
    )
    made["passive_fuzzy"] = partial(sa.laws.passive_fuzzy, arm, learning, bandwidth=20.0, **sampled)
    made["recommended"] = partial(
        sa.recommended,
        arm,
        loop_rate=conditions.rate,
        encoder_bits=conditions.encoder_bits or EXACT,
        delay=conditions.delay,
        effort_limit=effort,
        payload=robot.payload,
        noise=conditions.noise,
        path=motion,
        duration=example.PERIOD,
        light_joints=(conditions.rotors or robot.rotors) == "none",
    )
    return made
