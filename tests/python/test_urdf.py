"""Robot files as they are: what other readers take, ours takes, and says what it did not use."""

from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="3"/>'


def link(name, mass=1.0, moments=(0.02, 0.02, 0.01)):
    xx, yy, zz = moments
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 0.1"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name, parent, child, parts=LIMIT, axis="0 1 0", kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.3"/><axis xyz="{axis}"/>{parts}</joint>'
    )


def robot(body, attributes=""):
    return f'<?xml version="1.0"?><robot name="r"{attributes}>{body}</robot>'


TWO = (
    '<link name="b"/>' + link("l1") + link("l2") + joint("j1", "b", "l1") + joint("j2", "l1", "l2")
)


def noted(arm, *words):
    return any(all(word in note for word in words) for note in arm.notes)


@pytest.mark.parametrize("prefix", ["drake:", ""])
def test_rotor_behind_drakes_gear(prefix):
    """160² · 1.321e-4 = 3.38176 kg m², Drake's default_reflected_inertia, whatever ROS says."""
    actuator = (
        "<mechanicalReduction>1</mechanicalReduction>"
        '<drake:gear_ratio value="160.0"/><drake:rotor_inertia value="0.0001321"/>'
    ).replace("drake:", prefix)
    transmission = (
        '<transmission name="t1"><type>transmission_interface/SimpleTransmission</type>'
        f'<joint name="j1"/><actuator name="m1">{actuator}</actuator></transmission>'
    )
    bare = sa.Serial.from_urdf(robot(TWO))
    geared = sa.Serial.from_urdf(robot(TWO + transmission))
    armature = geared.mass_matrix([0, 0]) - bare.mass_matrix([0, 0])
    np.testing.assert_allclose(armature, [[3.38176, 0], [0, 0]], atol=1e-14)
    assert noted(geared, '"j1"', "<mechanicalReduction>", "not used")
    assert noted(bare, "no rotor inertia") and not noted(geared, "no rotor inertia")


AS_PEERS_READ = {
    "leftover xacro:property": robot(
        '<xacro:property name="width" value="0.2"/>' + TWO,
        ' xmlns:xacro="http://www.ros.org/wiki/xacro"',
    ),
    "prefix that nobody declared": robot(
        TWO + '<gazebo reference="l2"><sensor:camera name="c" a:b="1"/></gazebo>'
    ),
    "line before the declaration": "\n" + robot(TWO),
    "byte order mark": "\ufeff\n" + robot(TWO),
    "dashes in a comment": robot("<!------ links -- and joints ------>" + TWO),
}


@pytest.mark.parametrize("case", AS_PEERS_READ)
def test_xml_is_read_as_peers_read_it(case, tmp_path: Path):
    path = tmp_path / "arm.urdf"
    path.write_text(AS_PEERS_READ[case], encoding="utf-8")
    wanted = sa.Serial.from_urdf(robot(TWO)).mass_matrix([0.1, 0.2])
    for source in (AS_PEERS_READ[case], path):
        arm = sa.Serial.from_urdf(source)
        assert np.array_equal(arm.mass_matrix([0.1, 0.2]), wanted)


@pytest.mark.parametrize("head", ['<?xml version="1.0" encoding="ISO-8859-1"?>', ""])
def test_latin1_is_read(head, tmp_path: Path):
    path = tmp_path / "bras.urdf"
    text = head + robot(TWO).split("?>")[1].replace('"j1"', '"épaule"')
    path.write_bytes(text.encode("latin-1"))
    arm = sa.Serial.from_urdf(path)
    assert arm.joint_names == ["épaule", "j2"]
    assert noted(arm, "Latin-1") != bool(head)


def test_real_xacro_is_told_what_expands_it():
    told = r"pip install xacrodoc.*xacrodoc robot\.urdf\.xacro -o"
    for body in ('<xacro:arm prefix="l"/>', '<xacro:include filename="a.xacro"/>' + TWO):
        with pytest.raises(ValueError, match=told):
            sa.Serial.from_urdf(robot(body))
    with pytest.raises(ValueError, match=r'"\$\{m\}".*xacrodoc'):
        sa.Serial.from_urdf(robot(TWO.replace('mass value="1.0"', 'mass value="${m}"')))


@pytest.mark.parametrize(
    "parts",
    [
        '<limit lower="1" upper="1" effort="1" velocity="1"/>',
        '<limit lower="2.775" upper="-2.775" effort="1" velocity="1"/>',
        '<limit lower="low"/>',
        '<dynamics damping="-1"/>',
        "",
    ],
)
def test_what_is_off_the_chain_refuses_nothing(parts):
    wanted = sa.Serial.from_urdf(robot(TWO)).mass_matrix([0.1, 0.2])
    for pan in (link("pan", 0.1), '<link name="pan"/>', link("pan", "heavy")):
        text = robot(TWO + pan + joint("jp", "b", "pan", parts))
        for base in ("b", None):
            arm = sa.Serial.from_urdf(text, base=base, tip="l2")
            assert np.array_equal(arm.mass_matrix([0.1, 0.2]), wanted)


def test_massless_links_between_joints():
    """Axes x and y through one point, as in a wrist: M is that of the last link alone."""
    wrist = '<link name="b"/><link name="l1"/>' + link("l2")
    crossed = joint("j1", "b", "l1", axis="1 0 0") + joint("j2", "l1", "l2").replace("0.3", "0")
    arm = sa.Serial.from_urdf(robot(wrist + crossed))
    # 0.02 about the centre of mass, 1 kg 0.1 m away.
    np.testing.assert_allclose(arm.mass_matrix([0, 0]), 0.03 * np.eye(2), atol=1e-15)
    assert noted(arm, "massless", '"l1"')
    # About one axis twice, no torque tells the two joints apart.
    with pytest.raises(ValueError, match='joint "j1", link "l1"'):
        sa.Serial.from_urdf(robot(wrist + crossed.replace("1 0 0", "0 1 0")))


def test_gravity_is_given_in_the_axes_of_the_root():
    tilted = joint("tilt", "world", "b", "", kind="fixed").replace(
        "<origin", '<origin rpy="0 0.5 0"'
    )
    text = robot('<link name="world"/>' + TWO + tilted)
    whole = sa.Serial.from_urdf(text, gravity=(0, 0, -9.81))
    cut = sa.Serial.from_urdf(text, base="b", gravity=(0, 0, -9.81))
    q = [0.3, -0.4]
    np.testing.assert_allclose(cut.gravity(q), whole.gravity(q), rtol=1e-14)
    # Leaning by 0.5 rad is turning the first joint by 0.5 rad.
    upright = sa.Serial.from_urdf(robot(TWO)).gravity([0.8, -0.4])
    np.testing.assert_allclose(cut.gravity(q), upright, rtol=1e-13)
    assert noted(cut, "gravity", '"b"', '"world"') and not noted(whole, "gravity")


def test_masses_and_inertials_by_link():
    arm = sa.Serial.from_urdf(robot(TWO))
    heavier = sa.Serial.from_urdf(robot(TWO), masses={"l1": 3.0, "l2": 3})
    q = [0.1, 0.2]
    np.testing.assert_allclose(heavier.mass_matrix(q), 3 * arm.mass_matrix(q), rtol=1e-14)
    assert noted(heavier, '"l1"', "3 kg instead of 1")
    bare = robot('<link name="b"/><link name="l1"/><link name="l2"/>' + TWO[TWO.index("<joint") :])
    with pytest.raises(ValueError, match="inertials"):
        sa.Serial.from_urdf(bare)
    for moments in ((0.02, 0.02, 0.01), np.diag([0.02, 0.02, 0.01])):
        given = {name: (1.0, (0, 0, 0.1), moments) for name in ("l1", "l2")}
        stated = sa.Serial.from_urdf(bare, inertials=given)
        assert np.array_equal(stated.mass_matrix(q), arm.mass_matrix(q))
        assert noted(stated, '"l2"', "file states none")
    ball = sa.Serial.from_urdf(
        bare, inertials={"l1": (1, [0, 0, 0], 0.1), "l2": (2, [0, 0, 0], 0.1)}
    )
    assert ball.mass_matrix(q)[1, 1] == pytest.approx(0.1, rel=1e-14)


@pytest.mark.parametrize(
    ("error", "message", "given"),
    [
        (ValueError, 'masses: got "l3", wants the name of a link', {"masses": {"l3": 1.0}}),
        (ValueError, 'inertials: got "j1"', {"inertials": {"j1": (1, (0, 0, 0), 1)}}),
        (ValueError, 'masses, "l1": got -1 kg', {"masses": {"l1": -1.0}}),
        (ValueError, "not both", {"masses": {"l1": 1}, "inertials": {"l1": (1, (0, 0, 0), 1)}}),
        (ValueError, "wants (mass, com, moments)", {"inertials": {"l1": (1.0, (0, 0, 0))}}),
        (ValueError, 'inertials["l1"], com: got shape', {"inertials": {"l1": (1, 2, 3)}}),
        (ValueError, "triangle", {"inertials": {"l1": (1, (0, 0, 0), (1, 1, 9))}}),
        (
            ValueError,
            "symmetric",
            {"inertials": {"l1": (1, (0, 0, 0), np.eye(3) + np.eye(3, k=1))}},
        ),
        (TypeError, "masses: got list, wants a dict", {"masses": [("l1", 1.0)]}),
        (TypeError, "names of links", {"masses": {1: 1.0}}),
        (TypeError, 'masses["l1"]: got str', {"masses": {"l1": "heavy"}}),
    ],
)
def test_masses_that_are_none_are_refused(error, message, given):
    with pytest.raises(error) as raised:
        sa.Serial.from_urdf(robot(TWO), **given)
    assert message in str(raised.value)
