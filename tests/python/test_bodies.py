"""Links that no rigid body is, arms that come of an arm, and a reference against limits."""

import copy
import pickle

import numpy as np
import pytest
import steadyarm as sa
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

POLICIES = ("refuse", "note", "nearest")

LINK = (
    '<link name="{name}"><inertial><origin xyz="0 0 0.1"/><mass value="{mass}"/>'
    '<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial></link>'
)
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>'
    '<limit lower="-2" upper="2" effort="50" velocity="3"/></joint>'
)


def link(name, mass=1.0, moments=(0.02, 0.02, 0.01)):
    xx, yy, zz = moments
    return LINK.format(name=name, mass=mass, xx=xx, yy=yy, zz=zz)


def joint(name, parent, child, kind="revolute"):
    return JOINT.format(name=name, kind=kind, parent=parent, child=child)


def two(first=(0.02, 0.02, 0.01), second=(0.02, 0.02, 0.01), more=""):
    """Return an upright URDF of two joints, one of whose links may be no body."""
    body = f'<link name="base"/>{link("arm", moments=first)}{link("hand", moments=second)}'
    joints = joint("shoulder", "base", "arm") + joint("elbow", "arm", "hand")
    return f'<robot name="two">{body}{joints}{more}</robot>'


FLAWED = (0.02, 0.02, 0.05)
"""The largest is 0.01 more than the sum of the other two; Σ = diag(0.025, 0.025, -0.005)."""


def test_tool_frame_that_is_no_body_is_read_as_part_of_one():
    six = "".join(f'{name}="1e-8" ' for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    tool = (
        f'<link name="tool"><inertial><mass value="1e-8"/><inertia {six}/></inertial></link>'
        + joint("glue", "hand", "tool", "fixed")
    )
    arm = sa.Serial.from_urdf(two(more=tool))
    assert [note for note in arm.notes if 'link "tool"' in note and "no body" in note]
    q = [0.3, -0.4]
    without = sa.Serial.from_urdf(two()).mass_matrix(q)
    assert np.abs(arm.mass_matrix(q) - without).max() < 1e-7


def test_policies_of_a_urdf():
    with pytest.raises(ValueError, match="triangle") as refused:
        sa.Serial.from_urdf(two(second=FLAWED))
    assert 'link "hand"' in str(refused.value) and "nearest" in str(refused.value)
    note = sa.Serial.from_urdf(two(second=FLAWED), unphysical="note")
    nearest = sa.Serial.from_urdf(two(second=FLAWED), unphysical="nearest")
    assert (note.unphysical, nearest.unphysical) == ("note", "nearest")
    assert [n for n in note.notes if 'link "hand": taken as stated' in n and "1.000e-2 kg m^2" in n]
    assert [n for n in nearest.notes if "taken as the nearest" in n and "1.000e-2 kg m^2" in n]
    # About y: 0.02 as stated. The nearest leaves out -0.005 of Σ: I = diag(0.025, 0.025, 0.05).
    q = [0.0, 0.0]
    more = nearest.mass_matrix(q) - note.mass_matrix(q)
    assert_allclose(more, 0.005, rtol=1e-12)
    assert_allclose(note.mass_matrix(q)[1, 1], 0.02 + 0.01, rtol=1e-12)


@pytest.mark.parametrize("value", ["ignore", "", "Note"])
def test_policy_is_one_of_three_words(value):
    for build in (
        lambda: sa.Serial.from_urdf(two(), unphysical=value),
        lambda: sa.Serial.from_dh(a=1.0, alpha=0.0, d=0.0, mass=1.0, unphysical=value),
        lambda: sa.Serial.from_toml(sa.Serial.shipped("panda").to_toml(), unphysical=value),
    ):
        with pytest.raises(ValueError, match="unphysical: got"):
            build()


@pytest.mark.parametrize("policy", ["note", "nearest"])
def test_mass_matrix_must_be_positive_for_any_policy(policy):
    thin = (0.02, -0.02, 0.02)
    arm = {"a": 0.0, "alpha": 0.0, "d": 0.0, "mass": 1.0, "com": 0.0, "unphysical": policy}
    with pytest.raises(ValueError, match=r"joint1.*inertia: got"):
        sa.Serial.from_dh(inertia=np.diag([0.1, 0.1, -0.1])[None], **arm)
    assert sa.Serial.from_dh(inertia=np.diag(thin)[None], **arm).unphysical == policy


def test_tensor_that_is_not_symmetric_is_refused():
    tensor = np.diag([0.3, 0.3, 0.3])[None].repeat(2, axis=0)
    tensor[1, 0, 1] = 0.02
    for policy in POLICIES:
        for convention in ("standard", "modified"):
            with pytest.raises(ValueError, match=r"joint2.*moments.*not symmetric"):
                sa.Serial.from_dh(
                    a=0.3,
                    alpha=1.0,
                    d=[0.1, 0.2],
                    mass=1.0,
                    inertia=tensor,
                    convention=convention,
                    unphysical=policy,
                )


def test_corkes_puma_560_is_usable():
    """Robotics Toolbox: link 1 has no mass, link 3 breaks the triangle inequality.

    Weight at qn as `gravload` prints it (Corke, Robotics, Vision and Control, ch. 9).
    """
    table = {
        "a": [0, 0.4318, 0.0203, 0, 0, 0],
        "alpha": np.array([1, 0, -1, 1, -1, 0]) * np.pi / 2,
        "d": [0, 0, 0.15005, 0.4318, 0, 0],
        "mass": [0, 17.4, 4.8, 0.82, 0.34, 0.09],
        "com": [
            [0, 0, 0],
            [-0.3638, 0.006, 0.2275],
            [-0.0203, -0.0141, 0.070],
            [0, 0.019, 0],
            [0, 0, 0],
            [0, 0, 0.032],
        ],
        "inertia": [
            [0, 0.35, 0],
            [0.13, 0.524, 0.539],
            [0.066, 0.086, 0.0125],
            [1.8e-3, 1.3e-3, 1.8e-3],
            [0.3e-3, 0.4e-3, 0.3e-3],
            [0.15e-3, 0.15e-3, 0.04e-3],
        ],
    }
    with pytest.raises(ValueError, match="joint1"):
        sa.Serial.from_dh(**table)
    q = [0, np.pi / 4, np.pi, 0, np.pi / 4, 0]
    for policy, noted in (("note", 2), ("nearest", 2)):
        arm = sa.Serial.from_dh(**table, unphysical=policy)
        assert len(arm.notes) == noted
        assert_allclose(arm.gravity(q), [0, 31.6399, 6.0351, 0, 0.0283, 0], atol=6e-5)
    assert_allclose(arm.mass_matrix(q), arm.mass_matrix(q).T, rtol=1e-12)


XARM6 = [
    # origin of the joint, its rpy, mass, centre of mass, ixx ixy ixz iyy iyz izz
    ("0 0 0.267", "0 0 0", 2.16, "-0.002 0.02692 -0.01332",
     (0.00539427, 1.095e-05, 1.635e-06, 0.0048979, 0.000793, 0.00311573)),
    ("0 0 0", "-1.5708 0 0", 1.71, "0.03531 -0.21398 0.03386",
     (0.0248674, -0.00430651, -0.00067797, 0.00485548, 0.00457245, 0.02387827)),
    ("0.0535 -0.2845 0", "0 0 0", 1.384, "0.06781 0.10749 0.01457",
     (0.0053694, 0.0014185, -0.00092094, 0.0032423, -0.00169178, 0.00501731)),
    ("0.0775 0.3425 0", "-1.5708 0 0", 1.115, "-0.00021 0.02578 -0.02538",
     (0.00439263, 5.028e-05, 1.374e-05, 0.0040077, 0.00045338, 0.00110321)),
    ("0 0 0", "1.5708 0 0", 1.275, "0.05428 0.01781 0.00543",
     (0.001202758, 0.000492428, -0.00039147, 0.0022876, -1.235e-04, 0.0026866)),
    ("0.076 0.097 0", "-1.5708 0 0", 0.1096, "0 0.00064 -0.00952",
     (4.5293e-05, 0, 0, 4.8111e-05, 0, 7.9715e-05)),
]  # fmt: skip
"""The arm of UFACTORY's `xarm6_with_gripper.urdf` (xarm_ros, BSD licence), without its gripper."""


def xarm6():
    parts, names = ['<robot name="xarm6"><link name="base"/>'], ("xx", "xy", "xz", "yy", "yz", "zz")
    for k, (xyz, rpy, mass, com, moments) in enumerate(XARM6, 1):
        inertia = " ".join(f'i{name}="{value}"' for name, value in zip(names, moments, strict=True))
        parent = f"link{k - 1}" if k > 1 else "base"
        parts.append(
            f'<link name="link{k}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>'
            f'<inertia {inertia}/></inertial></link><joint name="joint{k}" type="continuous">'
            f'<parent link="{parent}"/><child link="link{k}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
            '<axis xyz="0 0 1"/><dynamics damping="1.0"/></joint>'
        )
    return "".join(parts) + "</robot>"


@pytest.mark.parametrize("policy", ["note", "nearest"])
def test_arm_of_a_vendor_with_links_that_are_no_bodies_runs(policy):
    with pytest.raises(ValueError, match=r'link "link2", <inertia>.*triangle'):
        sa.Serial.from_urdf(xarm6())
    arm = sa.Serial.from_urdf(xarm6(), unphysical=policy)
    # numpy.linalg.eigvalsh: links 2 and 3 break the triangle inequality by these.
    notes = [note for note in arm.notes if "no body has" in note]
    assert len(notes) == 2
    assert 'link "link2"' in notes[0] and "1.982e-4" in notes[0]
    assert 'link "link3"' in notes[1] and "9.834e-4" in notes[1]
    load = arm.with_payload(1.0).perturb(1, mass=0.1)
    tracker = sa.ComputedTorque(arm.without_friction(), kp=100.0, kv=20.0)
    run = sa.simulate(sa.Plant(load), tracker, sa.Sines(2.0, sin=0.3), duration=0.5, dt=1e-3)
    assert run.status.finished
    assert np.abs(run.e).max() < 0.5


def dynamics(arm):
    q, dq, ddq = np.array([[0.3, -0.7], [0.5, 0.2], [-1.0, 2.0]])
    return np.concatenate([arm.mass_matrix(q).ravel(), arm.inverse_dynamics(q, dq, ddq)])


@settings(max_examples=60, deadline=None)
@given(
    policy=st.sampled_from(POLICIES),
    first=st.tuples(*[st.floats(0.01, 0.2)] * 3),
    second=st.tuples(*[st.floats(0.01, 0.2)] * 3),
    seed=st.integers(0, 2**64 - 1),
    load=st.floats(0.0, 3.0),
)
def test_every_arm_of_an_arm_keeps_its_policy(policy, first, second, seed, load):
    """Payloads, perturbations, changes, TOML, pickles and copies of arms of any policy."""
    try:
        arm = sa.Serial.from_urdf(two(first, second), unphysical=policy)
    except ValueError as error:
        assert policy == "refuse" and "triangle" in str(error)
        return
    arm = arm.with_armature(0.5)
    pi = arm.inertial_parameters()
    for other in (
        arm,
        arm.with_payload(load),
        arm.perturb(seed),
        arm.with_payload(load).perturb(seed, mass=0.1),
        arm.with_parameters(pi),
        arm.with_gravity((0.0, -9.81, 0.0)),
        arm.with_friction(viscous=1.0, coulomb=[0.1, 0.2]),
        arm.with_stops(1e3),
        arm.without_friction(),
    ):
        assert other.unphysical == policy
        for again in (
            sa.Serial.from_toml(other.to_toml()),
            pickle.loads(pickle.dumps(other)),
            copy.deepcopy(other),
        ):
            assert again.unphysical == policy
            assert again.notes == other.notes
            assert again.to_toml() == other.to_toml()
            assert_array_equal(dynamics(again), dynamics(other))
    assert_allclose(arm.with_parameters(pi).inertial_parameters(), pi, rtol=0, atol=1e-15)
    assert len(set(arm.notes)) == len(arm.notes)


def test_parameters_there_and_back_on_every_shipped_arm():
    for name in ("panda", "puma560", "ur5e"):
        arm = sa.Serial.shipped(name)
        pi = arm.inertial_parameters()
        back = arm.with_parameters(pi)
        assert_allclose(back.inertial_parameters(), pi, rtol=0, atol=1e-14)
        assert back.joint_names == arm.joint_names
        # Twice the parameters weigh twice as much.
        q = np.full(arm.joints, 0.3)
        assert_allclose(arm.with_parameters(2 * pi).gravity(q), 2 * arm.gravity(q), atol=1e-11)


def test_parameters_that_no_body_has_get_what_the_policy_says():
    pi = sa.Serial.from_urdf(two()).inertial_parameters()
    pi[19] += 0.05  # I_zz of the hand: 0.06 > 0.02 + 0.02
    with pytest.raises(ValueError, match=r'joint "elbow", moments.*triangle'):
        sa.Serial.from_urdf(two()).with_parameters(pi)
    note = sa.Serial.from_urdf(two(), unphysical="note").with_parameters(pi)
    assert_allclose(note.inertial_parameters(), pi, atol=1e-15)
    assert [text for text in note.notes if "taken as stated" in text]
    # A note goes with what it was about.
    body = note.with_parameters(sa.Serial.from_urdf(two()).inertial_parameters())
    assert not [text for text in body.notes if "taken as stated" in text]
    nearest = sa.Serial.from_urdf(two(), unphysical="nearest").with_parameters(pi)
    assert [text for text in nearest.notes if "taken as the nearest" in text]
    # Σ = diag(0.03, 0.03, -0.01) keeps what is positive: I = diag(0.03, 0.03, 0.06).
    assert_allclose(
        nearest.inertial_parameters() - pi, np.eye(20)[[14, 16]].sum(0) * 0.01, atol=1e-14
    )


def test_changes_do_what_they_say():
    arm = sa.Serial.shipped("ur5e")
    q, dq = np.full(6, 0.3), np.linspace(-1, 1, 6)
    armature = np.arange(1.0, 7.0)
    rotors = arm.with_armature(armature)
    bare = arm.with_armature(0.0)
    assert_allclose(rotors.mass_matrix(q) - bare.mass_matrix(q), np.diag(armature), atol=1e-14)
    rough = arm.with_friction(viscous=2.0, coulomb=np.arange(6.0), smoothing=0.1)
    assert_allclose(rough.friction(dq), 2 * dq + np.arange(6) * np.tanh(dq / 0.1), atol=1e-14)
    sticky = arm.with_friction(coulomb=1.0, stribeck=0.5, stribeck_speed=0.2)
    dry = (1.0 + 0.5 * np.exp(-((dq / 0.2) ** 2))) * np.tanh(dq / 0.01)
    assert_allclose(sticky.friction(dq), dry, atol=1e-14)
    assert_array_equal(rough.with_friction().friction(dq), np.zeros(6))
    assert_allclose(arm.with_gravity((0, 0, 9.81)).gravity(q), -arm.gravity(q), atol=1e-12)
    assert_array_equal(arm.with_gravity((0, 0, 0)).gravity(q), np.zeros(6))
    flat = sa.TwoLink(mass=1.0, length=0.5, inertia=0.1, viscous=0.3)
    upright = flat.with_gravity(9.81).with_friction(coulomb=(0.1, 0.2))
    assert upright.parameters == (
        [1, 1],
        [0.5, 0.5],
        [0.1, 0.1],
        9.81,
        [0, 0],
        [0.1, 0.2],
        [0.01, 0.01],
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda arm: arm.with_armature([0.1, -1.0]), r"armature\[1\]: got -1"),
        (lambda arm: arm.with_armature(np.zeros(3)), r"armature: got shape \(3,\)"),
        (lambda arm: arm.with_armature(np.nan), r"armature\[0\]: got NaN"),
        (lambda arm: arm.with_friction(viscous=-1.0), r"viscous\[0\]: got -1"),
        (lambda arm: arm.with_friction(coulomb=[0, -2.0]), r"coulomb\[1\]: got -2"),
        (lambda arm: arm.with_friction(stribeck_speed=0.0), r"^stribeck_speed\[0\]: got 0"),
        (lambda arm: arm.with_friction(smoothing=-0.1), r"^smoothing\[0\]: got -0.1"),
        (lambda arm: arm.with_gravity((0, 0, np.inf)), r"gravity\[2\]: got inf"),
        (lambda arm: arm.with_gravity(9.81), r"gravity: got shape \(\), wants \(3,\)"),
        (
            lambda arm: arm.with_parameters(np.zeros(19)),
            r"parameters: got shape \(19,\), wants \(20,\)",
        ),
        (lambda arm: arm.with_parameters(np.zeros((2, 10))), r"parameters: got shape \(2, 10\)"),
        (lambda arm: arm.with_parameters(np.full(20, np.nan)), r"parameters\[0\]: got NaN"),
        (
            lambda arm: arm.with_parameters(np.zeros(20)),
            r'joint "elbow", link "hand".*, inertia: got 0',
        ),
        (lambda arm: arm.with_parameters(np.eye(20)[1]), 'joint "shoulder", com'),
    ],
)
def test_changes_that_cannot_be_are_refused_by_name(change, words):
    with pytest.raises(ValueError, match=words):
        change(sa.Serial.from_urdf(two()))


def test_reference_is_checked_against_limits():
    """The quintic over D in T peaks at 15/8 D/T in the middle (Flash and Hogan 1985)."""
    arm = sa.Serial.from_urdf(two())
    fast = sa.Quintic(start=(0.0, 0.0), goal=(1.0, 2.5), duration=0.1)
    found = {(excess.name, excess.bound): excess for excess in arm.check(fast, duration=0.2)}
    assert set(found) >= {
        ("shoulder", "velocity"),
        ("elbow", "velocity"),
        ("elbow", "position"),
        ("shoulder", "effort"),
    }
    elbow = found["elbow", "velocity"]
    assert (elbow.joint, elbow.limit) == (1, 3.0)
    assert_allclose([elbow.value, elbow.time, elbow.by], [46.875, 0.05, 43.875], rtol=1e-12)
    assert 0 < elbow.first < elbow.time
    assert 'joint "elbow": velocity 46.8750 rad/s at t = 0.0500 s' in str(elbow)
    position = found["elbow", "position"]
    assert (position.value, position.limit, position.time) == (2.5, 2.0, 0.1)
    slow = sa.Quintic(start=(0.0, 0.0), goal=(1.0, 1.5), duration=2.0)
    assert arm.check(slow, 3.0) == []
    again = pickle.loads(pickle.dumps(elbow))
    assert (str(again), again.by) == (str(elbow), elbow.by)


def test_effort_of_a_reference_is_the_inverse_dynamics():
    arm = sa.Serial.shipped("panda")
    swing = sa.Sines(frequency=3.0, sin=0.8, offset=np.array([0, 0, 0, -1.5, 0, 1.5, 0]))
    found = {e.joint: e for e in arm.check(swing, 4.0, dt=0.01) if e.bound == "effort"}
    times = np.linspace(0.0, 4.0, 401)
    tau = np.array([arm.inverse_dynamics(*swing(t)) for t in times])
    limit = arm.limits["effort"]
    assert set(found) == set(np.flatnonzero((np.abs(tau) > limit).any(axis=0)))
    for joint, excess in found.items():
        worst = np.abs(tau[:, joint]).argmax()
        assert_allclose([abs(excess.value), excess.time], [np.abs(tau[worst, joint]), times[worst]])


def test_what_a_callable_raises_comes_out_of_a_check():
    arm = sa.Serial.from_urdf(two())

    def broken(t):
        if t > 0.5:
            raise KeyError("mine")
        return np.zeros(2), np.zeros(2), np.zeros(2)

    with pytest.raises(KeyError, match="mine"):
        arm.check(broken, 1.0)
    with pytest.raises(ValueError, match="reference"):
        arm.check(lambda t: (np.full(2, np.nan),) * 3, 1.0)
    with pytest.raises(ValueError, match="dt: got 0"):
        arm.check(sa.Sines(1.0), 1.0, dt=0.0)
    with pytest.raises(ValueError, match="duration: got -1"):
        arm.check(sa.Sines(1.0), -1.0)
    with pytest.raises(ValueError, match="reference"):
        arm.check(sa.Quintic(start=np.zeros(3), goal=np.ones(3), duration=1.0), 1.0)
