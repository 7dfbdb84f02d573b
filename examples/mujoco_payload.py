"""Your robot in MuJoCo: an unknown payload, joint friction, three controllers that know of neither.

    python examples/mujoco_payload.py [ROBOT.urdf --base LINK --tip LINK] [--payload KG] [--out DIR]

MuJoCo moves the robot; the controllers see its joint angles and velocities at 1 kHz, and know the
URDF. Two motions are tracked: a sine in every joint, and point to point and back. Printed is the
RMS error of every joint over the last period; the picture compares the errors.

Needs ``pip install mujoco``; without a URDF also ``pip install pin example-robot-data``, for the
Panda.
"""

import argparse
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import steadyarm as sa

DT = 1e-3
"""Period of the controllers, and step of MuJoCo [s]."""

PERIOD = 6.0
"""Of the motions [s]."""

PERIODS = 6
"""That every run lasts."""

PAYLOAD = 2.0
"""[kg]"""

FRICTION = 0.01
"""Of every joint in MuJoCo, dry [N·m] and viscous [N·m·s/rad], as a part of its largest torque."""

AMPLITUDE = 0.35
"""Of the motions [rad]."""

GAIN, Q_POSITION, Q_VELOCITY = 1e4, 400.0, 40.0
"""Of the law of adaptation: Γ⁻¹ and the diagonal of Q."""

KP, KV = 400.0, 40.0
"""Of the model-based controllers [1/s², 1/s]."""


def bare(path, base, tip):
    """Return the URDF of the chain from base to tip alone, without meshes."""
    try:
        source = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise SystemExit(f"{path}: {error}") from None
    links = {link.get("name"): link for link in source.findall("link")}
    for option, name in (("--base", base), ("--tip", tip)):
        if name not in links:
            raise SystemExit(
                f"{option} {name}: got no link of this robot, wants one of {sorted(links)}"
            )
    into = {joint.find("child").get("link"): joint for joint in source.findall("joint")}
    robot = ElementTree.Element("robot", name=source.get("name"))
    compiler = ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler")
    compiler.attrib = {"fusestatic": "false", "balanceinertia": "false"}
    name = tip
    while True:
        link = ElementTree.SubElement(robot, "link", name=name)
        link.extend(links[name].findall("inertial"))
        if name == base:
            return ElementTree.tostring(robot, encoding="unicode")
        if name not in into:
            raise SystemExit(f"--base {base}: is not on the way from the robot's root to {tip}")
        robot.append(into[name])
        name = into[name].find("parent").get("link")


class World:
    """The robot in MuJoCo, of its URDF or of a model that was made of it."""

    def __init__(self, robot, tip, payload=0.0, friction=0.0):
        made = isinstance(robot, mujoco.MjModel)
        self.model = robot if made else mujoco.MjModel.from_xml_string(robot)
        self.model.opt.timestep = DT
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        self.model.dof_frictionloss[:] = friction
        self.model.dof_damping[:] = friction
        self.tip = self.model.body(tip).id
        if payload:
            self.load(payload)
        self.data = mujoco.MjData(self.model)

    def load(self, mass, at=(0.0, 0.0, 0.0)):
        """Fix a ball of this mass [kg] and 5 cm radius to the tip, its centre there [m]."""
        model, body, at = self.model, self.tip, np.asarray(at)
        own, com = model.body_mass[body], model.body_ipos[body].copy()
        new = (own * com + mass * at) / (own + mass)
        apart = com - at
        shift = own * mass / (own + mass) * (apart @ apart * np.eye(3) - np.outer(apart, apart))
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
        rotation = rotation.reshape(3, 3)
        inertia = rotation @ np.diag(model.body_inertia[body]) @ rotation.T
        inertia += shift + 0.4 * mass * 0.05**2 * np.eye(3)
        moments, axes = np.linalg.eigh(inertia)
        axes[:, 0] *= np.linalg.det(axes)
        mujoco.mju_mat2Quat(model.body_iquat[body], axes.ravel())
        model.body_mass[body], model.body_inertia[body], model.body_ipos[body] = (
            own + mass,
            moments,
            new,
        )
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def start(self, q):
        """Stand still at q."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = q

    def step(self, tau):
        """Apply the torque for one period."""
        self.data.qfrc_applied[:] = tau
        mujoco.mj_step(self.model, self.data)


def sine(middle):
    """Return t -> (q_d, dq_d, ddq_d), a sine in every joint that starts gently."""
    phase = np.arange(len(middle)) * np.pi / len(middle)
    omega = 2 * np.pi / PERIOD

    def at(t):
        angle = omega * t + phase
        return (
            middle + AMPLITUDE * (np.sin(angle) - np.sin(phase)),
            AMPLITUDE * omega * np.cos(angle),
            -AMPLITUDE * omega**2 * np.sin(angle),
        )

    return at


def point_to_point(middle):
    """Return t -> (q_d, dq_d, ddq_d), quintic motions there and back with a rest at each end."""
    half, travel = PERIOD / 2, PERIOD / 3

    def at(t):
        t = t % PERIOD
        sign, start, t = (1.0, 0.0, t) if t < half else (-1.0, 1.0, t - half)
        x = min(t / travel, 1.0)
        s = x**3 * (10 - 15 * x + 6 * x**2)
        ds = 30 * x**2 * (1 - x) ** 2 / travel
        dds = 60 * x * (1 - x) * (1 - 2 * x) / travel**2
        one = np.ones_like(middle)
        return (
            middle + AMPLITUDE * (start + sign * s),
            AMPLITUDE * sign * ds * one,
            AMPLITUDE * sign * dds * one,
        )

    return at


class GravityPd:
    """PD with the model's gravity, stiff in proportion to the inertia that each joint carries."""

    def __init__(self, arm, middle):
        self.arm, self.inertia = arm, np.diag(arm.mass_matrix(middle)).copy()

    def step(self, q, dq, q_d, dq_d, ddq_d, dt):
        """Return the torque."""
        return self.inertia * (KP * (q_d - q) + KV * (dq_d - dq)) + self.arm.gravity(q)


def compensator(motion, joints):
    """Return a fuzzy compensator that learns what is missing along the desired motion."""
    sets = sa.centers_for(motion, "reference", sets=(9, 15), duration=PERIOD)
    basis = sa.FuzzyBasis(form="per_joint", **sets)
    q = [Q_POSITION] * joints + [Q_VELOCITY] * joints
    return sa.FuzzyCompensator(basis, q=q, gain=GAIN)


def controllers(arm, middle, motion):
    """Return the three rivals."""
    return {
        "PD + gravity": GravityPd(arm, middle),
        "computed torque": sa.ComputedTorque(arm, kp=KP, kv=KV),
        "computed torque + fuzzy": sa.ComputedTorque(
            arm, kp=KP, kv=KV, compensator=compensator(motion, arm.joints)
        ),
    }


def track(world, tracker, motion, periods=PERIODS):
    """Return errors and torques, a row every period of the controller; it starts on the motion."""
    world.start(motion(0.0)[0])
    steps = round(periods * PERIOD / DT)
    e, tau = np.empty((2, steps, world.model.nv))
    for k in range(steps):
        q, dq = world.data.qpos.copy(), world.data.qvel.copy()
        q_d, dq_d, ddq_d = motion(k * DT)
        tau[k] = tracker.step(q, dq, q_d, dq_d, ddq_d, DT)
        e[k] = q - q_d
        world.step(tau[k])
    return e, tau


def rms(e):
    """Return the RMS of every joint over the last period."""
    return np.sqrt(np.mean(e[-round(PERIOD / DT) :] ** 2, axis=0))


def total(e):
    """Return the RMS of |e| over the last period."""
    return float(np.linalg.norm(rms(e)))


def picture(results, path):
    """Draw the error of the worst joint of every controller, a panel a motion."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.4 * len(results)), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(results), 1, squeeze=False)[:, 0]
    for axes, (motion, runs) in zip(panels, results.items(), strict=True):
        for (name, (e, _)), colour in zip(
            runs.items(), ("#767676", "#D55E00", "#0072B2"), strict=True
        ):
            t = np.arange(len(e)) * DT
            axes.plot(t, np.linalg.norm(e, axis=1), label=name, color=colour, linewidth=1.2)
        axes.set(title=motion, ylabel="error, |q − q_d| [rad]", xlim=(0, t[-1]), yscale="log")
        axes.set_ylim(1e-4, 1)
        axes.grid(color="#E6E6E6")
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1.08))
    panels[-1].set_xlabel("time [s]")
    figure.savefig(path)


def panda():
    """Return the URDF of the Panda that `example-robot-data` installs."""
    try:
        import pinocchio
    except ImportError:
        sys.exit("no URDF given: name one, or pip install example-robot-data pin for the Panda")
    share = Path(pinocchio.__file__).parents[4] / "share" / "example-robot-data"
    return share / "robots" / "panda_description" / "urdf" / "panda.urdf"


PANDA = {
    "base": "panda_link0",
    "tip": "panda_link8",
    "middle": (0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8),
}


def scene(urdf, tip, payload=PAYLOAD):
    """Return what the controllers believe, and the world as it is."""
    arm = sa.Serial.from_urdf(urdf, tip=tip)
    effort = np.where(np.isfinite(arm.limits["effort"]), arm.limits["effort"], 50.0)
    return arm.without_friction(), World(urdf, tip, payload, FRICTION * effort)


def main():
    """Run every controller on both motions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("urdf", nargs="?", type=Path, help="the robot (the Panda)")
    parser.add_argument("--base", help="first link")
    parser.add_argument("--tip", help="last link, which holds the payload")
    parser.add_argument("--payload", type=float, default=PAYLOAD, help=f"[kg] ({PAYLOAD:g})")
    parser.add_argument("--out", type=Path, default=Path(), help="folder of payload.png (.)")
    options = parser.parse_args()
    if options.urdf is None:
        options.urdf, options.base, options.tip = panda(), PANDA["base"], PANDA["tip"]
    elif not (options.base and options.tip):
        parser.error("a robot of your own wants --base and --tip, names of its links")
    urdf = bare(options.urdf, options.base, options.tip)
    arm, world = scene(urdf, options.tip, options.payload)
    middle = np.array(PANDA["middle"]) if options.tip == PANDA["tip"] else np.full(arm.joints, 0.3)
    results = {}
    for motion, at in (("sine", sine(middle)), ("point to point", point_to_point(middle))):
        print(f"{motion}: RMS of the last {PERIOD:g} s by joint [mrad], largest torque [N·m]")
        results[motion] = {}
        for name, tracker in controllers(arm, middle, at).items():
            e, tau = results[motion][name] = track(world, tracker, at)
            joints = " ".join(f"{1e3 * x:7.2f}" for x in rms(e))
            print(f"  {name:<24} {joints}   {np.abs(tau).max():6.1f}")
        tracker.freeze()
        frozen = rms(track(world, tracker, at, periods=1)[0])
        print(f"  {'the same, learning off':<24} {' '.join(f'{1e3 * x:7.2f}' for x in frozen)}")
    options.out.mkdir(parents=True, exist_ok=True)
    picture(results, options.out / "payload.png")
    print(f"see {options.out / 'payload.png'}")


if __name__ == "__main__":
    main()
