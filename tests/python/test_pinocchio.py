"""Any serial chain against Pinocchio: robots that others use, and a thousand random ones."""

import itertools
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa

pin = pytest.importorskip("pinocchio")

TOL = 1e-10
"""Relative to the largest entry: both compute in double precision, along 12 joints at most."""

MOST_JOINTS = 12
MOVING = ("revolute", "continuous", "prismatic")
GRAVITY = (0.3, -0.2, -9.81)

ROBOTS = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"


class Tree:
    """The links and joints of a URDF, to cut chains from."""

    def __init__(self, path):
        self.root = ElementTree.parse(path).getroot()
        self.links = {link.get("name"): link for link in self.root.findall("link")}
        self.into = {joint.find("child").get("link"): joint for joint in self.root.findall("joint")}

    def chains(self):
        """Yield (base, tip, joints) of every path that moves, its last joints if it is long."""
        parents = {joint.find("parent").get("link") for joint in self.into.values()}
        for tip in sorted(set(self.into) - parents):
            joints, link = [], tip
            while link in self.into:
                joint = self.into[link]
                if joint.get("type") not in (*MOVING, "fixed"):
                    break
                if joint.get("type") in MOVING and moving(joints) == MOST_JOINTS:
                    break
                joints.insert(0, joint)
                link = joint.find("parent").get("link")
            if moving(joints):
                yield link, tip, joints

    def cut(self, base, joints):
        """Return the URDF of one chain, with free joints within wide limits."""
        robot = ElementTree.Element("robot", name="chain")
        for name in (base, *(joint.find("child").get("link") for joint in joints)):
            link = ElementTree.SubElement(robot, "link", name=name)
            if (inertial := self.links[name].find("inertial")) is not None:
                link.append(inertial)
        for joint in joints:
            copy = ElementTree.SubElement(robot, "joint", joint.attrib)
            for part in joint:
                if part.tag in ("parent", "child", "origin", "axis"):
                    copy.append(part)
            if copy.get("type") == "continuous":
                copy.set("type", "revolute")
            if copy.get("type") in MOVING:
                limit = {"lower": "-9", "upper": "9", "effort": "99", "velocity": "9"}
                ElementTree.SubElement(copy, "limit", limit)
        return ElementTree.tostring(robot, encoding="unicode")


def moving(joints):
    """Return how many of the joints move."""
    return sum(joint.get("type") in MOVING for joint in joints)


def robot_chains():
    """Return (name, URDF, tip) of every different chain in the robots."""
    found = {}
    for path in sorted(ROBOTS.rglob("*.urdf")):
        tree = Tree(path)
        for base, tip, joints in tree.chains():
            found.setdefault(tree.cut(base, joints), (f"{path.stem}:{tip}", tip))
    return [(name, urdf, tip) for urdf, (name, tip) in found.items()]


def random_chain(seed):
    """Return the URDF of a random chain of 1 to 12 joints, some links fixed to others."""
    random = np.random.default_rng(seed)
    robot = ['<robot name="random"><link name="base"/>']
    parent, count = "base", random.integers(1, MOST_JOINTS + 1)
    kinds = [random.choice(["revolute", "revolute", "prismatic"]) for _ in range(count)]
    for _ in range(random.integers(0, 3)):
        kinds.insert(random.integers(0, len(kinds) + 1), "fixed")
    for k, kind in enumerate(kinds):
        name = f"link{k}"
        robot.append(f'<link name="{name}">{random_inertial(random)}</link>')
        axis = random.normal(size=3)
        place, turn = vector(0.3 * random.normal(size=3)), vector(random.uniform(-3, 3, 3))
        robot.append(
            f'<joint name="joint{k}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="{place}" rpy="{turn}"/>'
            f'<axis xyz="{vector(axis / np.linalg.norm(axis))}"/>'
            '<limit lower="-9" upper="9" effort="99" velocity="9"/></joint>'
        )
        parent = name
    return "".join([*robot, "</robot>"]), parent


def random_inertial(random):
    """Return the inertia of a random box."""
    mass, sides = random.uniform(0.2, 5.0), random.uniform(0.05, 0.5, 3)
    ixx, iyy, izz = (float(x) for x in mass / 12 * (np.sum(sides**2) - sides**2))
    place, turn = vector(0.1 * random.normal(size=3)), vector(random.uniform(-3, 3, 3))
    return (
        f'<inertial><origin xyz="{place}" rpy="{turn}"/><mass value="{float(mass)!r}"/>'
        f'<inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def vector(values):
    """Write numbers with all their digits."""
    return " ".join(repr(float(value)) for value in values)


def close(ours, theirs, what):
    """Assert agreement relative to the largest entry."""
    theirs = np.reshape(theirs, np.shape(ours))  # Pinocchio's bindings drop axes of length 1
    scale = max(np.abs(theirs).max(initial=0.0), 1e-3)
    error = np.abs(ours - theirs).max(initial=0.0) / scale
    assert error <= TOL, f"{what}: {error:.2e}"


def compare(urdf, tip, seed, states=3, unphysical="refuse"):
    """Compare everything with Pinocchio at random states."""
    ours = sa.Serial.from_urdf(urdf, tip=tip, gravity=GRAVITY, unphysical=unphysical)
    ours = ours.without_friction()
    model = pin.buildModelFromXML(urdf)
    model.gravity.linear = np.array(GRAVITY)
    data, frame = model.createData(), model.getFrameId(tip)
    assert ours.joints == model.nv
    random = np.random.default_rng(seed)
    for _ in range(states):
        q, dq, ddq, tau = random.uniform(-2.0, 2.0, (4, model.nv))
        close(ours.inverse_dynamics(q, dq, ddq), pin.rnea(model, data, q, dq, ddq), "RNEA")
        mass = np.triu(pin.crba(model, data, q))
        close(ours.mass_matrix(q), mass + np.triu(mass, 1).T, "CRBA")
        close(ours.gravity(q), pin.computeGeneralizedGravity(model, data, q), "gravity")
        close(ours.coriolis(q, dq), pin.computeCoriolisMatrix(model, data, q, dq), "Coriolis")
        regressor = pin.computeJointTorqueRegressor(model, data, q, dq, ddq)
        close(ours.regressor(q, dq, ddq), regressor, "regressor")
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        close(ours.jacobian(q), pin.getFrameJacobian(model, data, frame, axes), "Jacobian")
        close(ours.pose(q), data.oMf[frame].homogeneous, "pose")
        # A badly conditioned mass matrix amplifies the rounding of both.
        condition = np.linalg.cond(ours.mass_matrix(q))
        if condition < 1e5:
            close(ours.forward_dynamics(q, dq, tau), pin.aba(model, data, q, dq, tau), "ABA")


IMPOSSIBLE = (
    "triangle inequality",
    "none negative",
    "no <inertial>",
    "<mass value>",
    "mass: got 0",
)
"""What a chain may be refused for: links that no rigid body can be, or that say nothing of it."""

CHAINS = robot_chains() if ROBOTS.is_dir() else []


def refusal(urdf, tip, unphysical="refuse"):
    """Return why a chain is refused, or None."""
    try:
        sa.Serial.from_urdf(urdf, tip=tip, unphysical=unphysical)
    except ValueError as error:
        return str(error)
    return None


def test_most_chains_are_read_and_the_others_refused_for_their_inertia():
    refusals = [why for _, urdf, tip in CHAINS if (why := refusal(urdf, tip))]
    assert len(CHAINS) - len(refusals) > 350
    assert not [why for why in refusals if not any(words in why for words in IMPOSSIBLE)]


@pytest.mark.parametrize(("name", "urdf", "tip"), CHAINS, ids=[name for name, *_ in CHAINS])
def test_chain_of_a_robot_agrees_with_pinocchio(name, urdf, tip):
    """Pinocchio takes every figure as stated, as "note" does."""
    if why := refusal(urdf, tip, "note"):
        pytest.skip(why)
    compare(urdf, tip, seed=1, unphysical="note")


UNPHYSICAL = [
    chain for chain in CHAINS if any(w in (refusal(*chain[1:]) or "") for w in IMPOSSIBLE[:2])
]
"""Chains with links that no rigid body is."""


@pytest.mark.skipif(not CHAINS, reason="no robots here")
def test_chains_that_no_bodies_are_can_be_used_all_the_same():
    names = {name.partition(":")[0] for name, *_ in UNPHYSICAL}
    assert names  # Vendors publish them.
    for policy in ("note", "nearest"):
        for name, urdf, tip in UNPHYSICAL:
            why = refusal(urdf, tip, policy)
            assert why is None or "inertia: got" in why, f"{name}: {why}"


@pytest.mark.parametrize("block", range(10))
def test_random_chains_agree_with_pinocchio(block):
    for seed in itertools.islice(itertools.count(100 * block), 100):
        compare(*random_chain(seed), seed, states=1)


@pytest.mark.parametrize("seed", range(30))
def test_a_wrench_at_the_tip_accelerates_as_pinocchio_says(seed):
    """From rest, over a step so short that the velocity is q̈ times it to 1e-5."""
    urdf, tip = random_chain(seed)
    arm = sa.Serial.from_urdf(urdf, tip=tip, gravity=GRAVITY).without_friction()
    model = pin.buildModelFromXML(urdf)
    model.gravity.linear = np.array(GRAVITY)
    data, frame = model.createData(), model.getFrameId(tip)
    random = np.random.default_rng(seed)
    q, tau, wrench = random.uniform(-2, 2, arm.joints), *np.split(random.normal(size=18), [12])
    tau, zero, h = tau[: arm.joints], np.zeros(arm.joints), 1e-7
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = np.reshape(pin.computeFrameJacobian(model, data, q, frame, axes), (6, -1))
    wanted = pin.aba(model, data, q, zero, tau + jacobian.T @ wrench)
    push = sa.Wrench(wrench[:3], wrench[3:])
    _, dq = sa.Plant(arm, push).step(q, zero, tau, 0.0, h)
    scale = np.abs(wanted).max() * min(np.linalg.cond(arm.mass_matrix(q)), 1e6)
    assert np.abs(dq / h - wanted).max() <= 1e-9 * scale + 1e-5 * np.abs(wanted).max()
