"""Classes that are their arguments: equal, hashed, shown, pickled and replaced by them alone."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

CENTERS = (-1.0, 0.0, 1.0)


def basis(**change: Any) -> sa.FuzzyBasis:
    return sa.FuzzyBasis(**({"form": "grid", "centers": CENTERS, "width": 0.5} | change))


def compensator(**change: Any) -> sa.FuzzyCompensator:
    return sa.FuzzyCompensator(**({"basis": basis(), "gain": (1, 2)} | change))


def sines(**change: Any) -> sa.Sines:
    return sa.Sines(**({"frequency": (1, 3), "sin": ((0, 1), (2, 0))} | change))


def quintic(**change: Any) -> sa.Quintic:
    return sa.Quintic(**({"start": 0, "goal": (1, 2), "duration": 3} | change))


def table(**change: Any) -> sa.Table:
    return sa.Table(**({"t": (0, 1, 2), "q": ((0, 0), (1, 2), (0, 1))} | change))


def waypoints(**change: Any) -> sa.Waypoints:
    given = {"poses": ((0, 0), (1, 2), (0, 1)), "velocity": 1, "acceleration": 2, "jerk": 3}
    return sa.Waypoints(**(given | change))


def pulses(**change: Any) -> sa.Pulses:
    return sa.Pulses(**({"time": (0, 1), "torque": ((0, 1), (2, 0)), "duration": 0.5} | change))


def noise(**change: Any) -> sa.Noise:
    return sa.Noise(**({"deviation": (0, 1), "cutoff": 2} | change))


def wrench(**change: Any) -> sa.Wrench:
    return sa.Wrench(**({"force": (0, 1, 2), "moment": (3, 4, 5)} | change))


def two_link(**change: Any) -> sa.TwoLink:
    return sa.TwoLink(**({"mass": (4, 3), "length": 0.5, "inertia": (0.2, 0.3)} | change))


def plant(**change: Any) -> sa.Plant:
    given = {"arm": two_link(), "disturbance": sines(), "effort_limit": (30, 20)}
    return sa.Plant(**(given | change))


def effects(**change: Any) -> sa.Effects:
    given = {"encoder_bits": 16, "joint_stiffness": 1e4, "rotor_inertia": 0.1}
    return sa.Effects(**(given | change))


def excess(**change: Any) -> sa.Excess:
    given = {"joint": 1, "name": "elbow", "bound": "effort", "limit": 10.0, "value": 12.0}
    given |= {"by": 2.0, "time": 0.5, "first": 0.25, "message": "too much"}
    return sa.Excess(**(given | change))


def tracker(**change: Any) -> sa.ComputedTorque:
    given = {"arm": two_link(), "kp": (8, 9), "kv": 5.5, "compensator": compensator()}
    return sa.ComputedTorque(**(given | change))


CHANGES: list[tuple[Any, dict[str, Any]]] = [
    (basis, {"form": "concat"}),
    (basis, {"centers": (-1.0, 0.0, 2.0)}),
    (basis, {"width": 0.25}),
    (basis, {"normalized": False}),
    (basis, {"inputs": {"de": 1.0, "e": 1.0}}),
    (basis, {"inputs": {"e": 1.0, "de": 0.5}}),
    (basis, {"joints": 2}),
    (compensator, {"basis": basis(width=0.25)}),
    (compensator, {"q": 9.0}),
    (compensator, {"gain": (1, 3)}),
    (compensator, {"gamma": 2.0}),
    (compensator, {"leak_rate": 0.1}),
    (compensator, {"error_modification": 0.1}),
    (compensator, {"projection_radius": 60.0}),
    (compensator, {"dead_zone": 0.1}),
    (compensator, {"normalization": 0.1}),
    (compensator, {"dictionary": 64}),
    (sines, {"frequency": (1, 2)}),
    (sines, {"sin": ((0, 1), (3, 0))}),
    (sines, {"cos": ((0, 1), (3, 0))}),
    (sines, {"offset": 0.5}),
    (quintic, {"start": (0, 0)}),
    (quintic, {"goal": (1, 3)}),
    (quintic, {"duration": 4.0}),
    (quintic, {"start_time": 1.0}),
    (table, {"t": (0, 1, 3)}),
    (table, {"q": ((0, 0), (1, 2), (0, 2))}),
    (table, {"dq": np.zeros((3, 2)), "ddq": np.zeros((3, 2))}),
    (sines, {"start_time": 0.0}),
    (table, {"start_time": 0.0}),
    (waypoints, {"poses": ((0, 0), (1, 2), (0, 2))}),
    (waypoints, {"velocity": 2}),
    (waypoints, {"acceleration": (2, 3)}),
    (waypoints, {"jerk": 4}),
    (waypoints, {"pause": 0.5}),
    (waypoints, {"start_time": 1}),
    (pulses, {"time": (0, 2)}),
    (pulses, {"torque": ((0, 1), (3, 0))}),
    (pulses, {"duration": np.inf}),
    (pulses, {"shape": "half_sine"}),
    (noise, {"deviation": (0, 2)}),
    (noise, {"cutoff": 3}),
    (noise, {"seed": 1}),
    (wrench, {"force": (0, 1, 3)}),
    (wrench, {"moment": None}),
    (wrench, {"force": None, "moment": None, "curve": noise(deviation=1)}),
    (two_link, {"mass": (4, 5)}),
    (two_link, {"length": (0.5, 0.6)}),
    (two_link, {"inertia": 0.2}),
    (two_link, {"gravity": 9.81}),
    (two_link, {"viscous": (0, 0.1)}),
    (two_link, {"coulomb": 0.2}),
    (two_link, {"smoothing": (0.01, 0.02)}),
    (plant, {"arm": two_link(gravity=9.81)}),
    (plant, {"arm": sa.Serial.from_dh((0.5, 0.5), 0, 0, mass=1, inertia=0.1)}),
    (plant, {"disturbance": None}),
    (plant, {"disturbance": sines(offset=0.5)}),
    (plant, {"disturbance": quintic()}),
    (plant, {"disturbance": [sines(), noise()]}),
    (plant, {"disturbance": np.hypot}),
    (plant, {"effort_limit": (30, np.inf)}),
    (effects, {"encoder_bits": (16, 17)}),
    (effects, {"noise": 1e-4}),
    (effects, {"velocity": "difference"}),
    (effects, {"velocity_noise": (1e-3, 0)}),
    (effects, {"velocity_cutoff": 50}),
    (effects, {"velocity_bandwidth": 200}),
    (effects, {"velocity_acceleration": 30}),
    (effects, {"delay": 2}),
    (effects, {"jitter": 0.1}),
    (effects, {"drop": 0.01}),
    (effects, {"effort_rate_limit": 1e3}),
    (effects, {"gain": (0.9, 1)}),
    (effects, {"lag": 1e-3}),
    (effects, {"cogging": 0.1}),
    (effects, {"cogging_per_turn": 50}),
    (effects, {"joint_stiffness": (1e4, 2e4)}),
    (effects, {"joint_damping": 3}),
    (effects, {"rotor_inertia": 0.2}),
    (effects, {"backlash": 1e-3}),
    (effects, {"encoder_side": "link"}),
    (effects, {"seed": 4}),
    (plant, {"effort_limit": None}),
    (plant, {"changes": [(1.0, two_link(gravity=9.81)), (2.0, two_link())]}),
    (excess, {"joint": 0}),
    (excess, {"name": "wrist"}),
    (excess, {"bound": "velocity"}),
    (excess, {"limit": 11.0}),
    (excess, {"value": 13.0}),
    (excess, {"by": 3.0}),
    (excess, {"time": 0.75}),
    (excess, {"first": 0.125}),
    (excess, {"message": "far too much"}),
]
NAMES = [f"{make.__name__}-{'-'.join(change)}" for make, change in CHANGES]
CURVES = [sines, quintic, table, waypoints]
MAKERS = [
    basis,
    compensator,
    *CURVES,
    pulses,
    noise,
    wrench,
    two_link,
    plant,
    effects,
    excess,
]


@pytest.mark.parametrize("make", MAKERS)
def test_the_same_arguments_make_equal_objects_with_one_hash(make: Any) -> None:
    one, other = make(), make()
    assert one == other
    assert hash(one) == hash(other)
    assert repr(one) == repr(other)
    assert {one: "found"}[other] == "found"
    assert one != "a word"
    assert one not in [other_make() for other_make in MAKERS if other_make is not make]


@pytest.mark.parametrize(("make", "change"), CHANGES, ids=NAMES)
def test_every_argument_counts_and_can_be_replaced(make: Any, change: dict[str, Any]) -> None:
    before, changed = make(), make(**change)
    assert before != changed
    assert before.__replace__(**change) == changed
    assert repr(before.__replace__(**change)) == repr(changed) != repr(before)
    assert before == make()


def test_every_argument_of_every_class_is_among_them() -> None:
    for make in MAKERS:
        tried = {name for other, change in CHANGES if other is make for name in change}
        arguments = set(inspect.signature(type(make())).parameters)
        assert arguments - tried <= {"merge_tolerance"}


@pytest.mark.parametrize(("make", "change"), CHANGES, ids=NAMES)
def test_copies_and_pickles_are_equal(make: Any, change: dict[str, Any]) -> None:
    made = make(**change)
    for again in (pickle.loads(pickle.dumps(made)), copy.copy(made), copy.deepcopy(made)):
        assert again == made
        assert hash(again) == hash(made)
        assert type(again) is type(made)


@pytest.mark.parametrize("make", MAKERS)
def test_repr_is_the_call_that_makes_it(make: Any) -> None:
    names = {name: getattr(sa, name) for name in sa.__all__}
    assert eval(repr(make()), names | {"inf": float("inf")}) == make()


def test_a_zero_has_no_sign() -> None:
    one, other = sa.Sines(1.0, sin=0.0), sa.Sines(1.0, sin=-0.0)
    assert one == other
    assert hash(one) == hash(other)


def test_long_lists_are_shown_by_their_ends() -> None:
    assert repr(basis(centers=np.arange(50.0))).count("...") == 1
    assert len(repr(sa.Table(np.arange(1e4), np.zeros((10_000, 3))))) < 200


def test_arrays_lists_and_integers_make_the_same_object() -> None:
    arrays = sines(frequency=np.array([1.0, 3.0]), sin=np.array([[0, 1], [2, 0]]))
    assert arrays == sines(frequency=[1, 3], sin=[[0.0, 1.0], [2.0, 0.0]])
    assert quintic(goal=np.array([1, 2])) == quintic(goal=[1.0, 2.0])
    assert basis(inputs="error") == basis(inputs=["e", "de"]) == basis(inputs={"e": 1, "de": 1})
    assert two_link(length=np.array([0.5, 0.5]), gravity=0) == two_link(viscous=[0, 0])
    assert plant(effort_limit=30) == plant(effort_limit=np.array([30, 30]))
    assert (
        plant(effort_limit=None) == plant(effort_limit=np.inf) == plant(effort_limit=[np.inf] * 2)
    )


def test_a_change_is_checked() -> None:
    with pytest.raises(ValueError, match=r"^gain\[1\]: got -1"):
        compensator().__replace__(gain=(1, -1))
    with pytest.raises(TypeError, match="gian"):
        compensator().__replace__(gian=1)
    with pytest.raises(ValueError, match=r"^coulomb\[1\]: got -1"):
        two_link().__replace__(coulomb=(0, -1))
    with pytest.raises(TypeError, match=r"^arm: got Sines, wants a TwoLink or a Serial"):
        plant().__replace__(arm=sines())
    with pytest.raises(
        ValueError, match=r"^effort_limit: got shape \(2,\), wants a scalar or \(7,\)"
    ):
        plant(disturbance=None).__replace__(arm=sa.Serial.shipped("panda"))
    with pytest.raises(ValueError, match=r"^kv\[0\]: got 0"):
        tracker().__replace__(kv=(0, 1))
    with pytest.raises(ValueError, match=r"^kp: got shape \(2,\), wants a scalar or \(7,\)"):
        tracker().__replace__(arm=sa.Serial.shipped("panda"))
    with pytest.raises(ValueError, match=r"^compensator: got one of 2 joints, wants one of 7"):
        tracker().__replace__(arm=sa.Serial.shipped("panda"), kp=8, kv=5)


def test_another_arm_takes_what_counts_for_all_joints() -> None:
    panda = sa.Serial.shipped("panda")
    push = sa.Sines(1.0, sin=2.0)
    assert sa.Plant(two_link(), push).__replace__(arm=panda) == sa.Plant(panda, push)
    other = tracker(compensator=None).__replace__(arm=panda, kp=8, kv=5)
    assert other.arm == panda
    assert other.kp.tolist() == [8] * 7


def test_a_callable_makes_a_plant_that_is_equal_and_hashed_as_it_is() -> None:
    def push(q: Any, dq: Any, t: float) -> Any:
        return np.zeros(2)

    assert plant(disturbance=push) == plant(disturbance=push)
    assert hash(plant(disturbance=push)) == hash(plant(disturbance=push))
    assert plant(disturbance=push) != plant(disturbance=lambda q, dq, t: push(q, dq, t))


def test_what_a_plant_hands_out_does_not_change_it() -> None:
    held = plant()
    assert isinstance(held.__reduce__()[1][2], tuple)
    held.effort_limit[0] = 1.0
    assert held == plant()


SERIALS = {
    "from_dh": lambda: sa.Serial.from_dh((0.5, 0.4), 0, 0, mass=(1, 2), inertia=0.1),
    "shipped": lambda: sa.Serial.shipped("panda"),
    "payload": lambda: sa.Serial.shipped("panda").with_payload(1.5, (0, 0, 0.1)),
    "lighter": lambda: sa.Serial.shipped("panda").with_payload(1.0, (0, 0, 0.1)),
    "rubbing": lambda: sa.Serial.shipped("panda").with_friction(0.1),
    "gravity": lambda: sa.Serial.shipped("panda").with_gravity((0, 0, -1.62)),
    "geared": lambda: sa.Serial.shipped("panda").with_armature(0.1),
    "stopped": lambda: sa.Serial.shipped("panda").with_stops(1e4),
    "perturbed": lambda: sa.Serial.shipped("panda").perturb(3),
}


@pytest.mark.parametrize("name", SERIALS)
def test_serial_arms_are_equal_when_their_toml_is(name: str) -> None:
    arm = SERIALS[name]()
    copies = [pickle.loads(pickle.dumps(arm)), copy.copy(arm), sa.Serial.from_toml(arm.to_toml())]
    for again in [SERIALS[name](), *copies]:
        assert again == arm
        assert hash(again) == hash(arm)
    assert arm not in [make() for other, make in SERIALS.items() if other != name]
    assert arm != two_link()


def test_an_arm_without_a_list_of_arguments_says_what_changes_it() -> None:
    for change in ({}, {"gravity": (0, 0, 0)}):
        with pytest.raises(
            TypeError, match=r"^Serial: .*with_payload, with_friction, with_gravity"
        ):
            sa.Serial.shipped("ur5e").__replace__(**change)


TRACKERS: list[dict[str, Any]] = [
    {"arm": two_link(gravity=9.81)},
    {"kp": (8, 7)},
    {"kv": (5, 6)},
    {"compensator": compensator(gamma=2.0)},
    {"compensator": None},
    {"effort_limit": (30, 20)},
    {"effort_rate_limit": 1e4},
    {"last_tau": (3, 1)},
    {"hand_over": 3.0},
    {"velocity_filter": 80.0},
    {"bumpless": 20.0},
    {"delay": 2},
]
SAMPLE = ((0.1, -0.2), (0.3, 0.1), (0, 0), (0, 0), (0.1, 0.2), 1e-3)


@pytest.mark.parametrize("change", TRACKERS, ids=lambda change: next(iter(change)))
def test_a_tracker_with_other_arguments_is_a_new_one(change: dict[str, Any]) -> None:
    before, fresh = tracker(), tracker(**change)
    for _ in range(3):
        before.step(*SAMPLE)
    changed = before.__replace__(**change)
    assert (before.steps, changed.steps) == (3, 0)
    assert repr(changed) == repr(fresh) != repr(before)
    for _ in range(2):
        np.testing.assert_array_equal(changed.step(*SAMPLE), fresh.step(*SAMPLE))
    assert before.steps == 3


def test_every_argument_of_a_tracker_is_among_them() -> None:
    tried = {name for change in TRACKERS for name in change}
    assert tried == set(inspect.signature(sa.ComputedTorque).parameters)


def test_a_tracker_is_equal_to_itself_alone() -> None:
    """It has a memory, and two of them may go different ways."""
    one, other = tracker(), tracker()
    assert one == one and one != other
    assert len({one, other, one}) == 2


def test_the_repr_of_a_tracker_is_the_call_that_makes_it() -> None:
    names = {name: getattr(sa, name) for name in sa.__all__}
    again = eval(repr(tracker()), names | {"inf": float("inf")})
    assert repr(again) == repr(tracker())
    assert again.__reduce__()[1] == tracker().__reduce__()[1]


def test_defaults_of_the_signature_are_those_of_the_object() -> None:
    made = sa.FuzzyCompensator(basis())
    parameters = inspect.signature(sa.FuzzyCompensator).parameters
    settings = dict(zip(parameters, made.__reduce__()[1], strict=True))
    for name, parameter in parameters.items():
        if name not in ("basis", "projection_radius", "merge_tolerance"):
            assert settings[name] == parameter.default, name
    assert settings["projection_radius"] == float("inf")
    merge = parameters["merge_tolerance"].default
    assert sa.FuzzyCompensator(basis(), dictionary=8).merge_tolerance == merge


TOML = """
[two_link]
mass = 4
length = [0.5, 0.5]
inertia = 0.2
coulomb = [0.1, 0.2]

[controller]
kp = 8
kv = [5.5, 5]

[compensator]
gain = [1, 2]
q = 9
projection_radius = 60
dictionary = 64
merge_tolerance = 0.01

[compensator.basis]
form = "grid"
centers = [-1, 0, 1]
width = 0.5
normalized = false
inputs = { q = 2.0, dq = 0.5 }

[reference.quintic]
start = 0
goal = [1, 2]
duration = 3

[disturbance.sines]
frequency = [1, 3]
sin = [[0, 1], [2, 0]]

[run]
duration = 0.5
dt = 0.002
control_period = 0.01
q0 = [0.1, -0.1]
"""


def test_a_file_and_keywords_make_the_same_objects() -> None:
    scenario = sa.read_scenario(TOML)
    of_basis = basis(normalized=False, inputs={"q": 2.0, "dq": 0.5})
    robust = {"projection_radius": 60, "dictionary": 64, "merge_tolerance": 0.01}
    arm = sa.TwoLink(4, (0.5, 0.5), 0.2, coulomb=(0.1, 0.2))
    assert scenario["compensator"] == compensator(basis=of_basis, q=9, **robust)
    assert scenario["reference"] == quintic()
    assert scenario["disturbance"] == sines()
    assert scenario["two_link"] == arm
    assert scenario["plant"] is None
    assert (scenario["controller"]["kp"], scenario["controller"]["kv"]) == (8.0, [5.5, 5.0])


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ("gain = [1, 2]", "gian = 1", "compensator.gian: unknown field `gian`"),
        ("q = 9", 'q = "9"', 'compensator.q: invalid type: string "9"'),
        ("gain = [1, 2]", "gain = [1, -2]", "compensator.gain[1]: got -2, wants a number > 0"),
        ("width = 0.5", "width = 0", "compensator.basis.width: got 0, wants widths > 0"),
        ("goal = [1, 2]", 'goal = [1, "2"]', "reference.quintic.goal[1]: invalid type"),
        ("frequency = [1, 3]", "frequency = [1, nan]", "disturbance.sines.frequency[1]: got NaN"),
        ("dt = 0.002", "dt = 0.3", "run.duration: got 0.5, wants a whole number of dt"),
        (
            "dt = 0.002",
            'method = "euler"',
            "run.method: unknown variant `euler`, expected `rk4` or",
        ),
        ("kv = [5.5, 5]", "kv = [-5.5, 5]", "controller.kv[0]: got -5.5, wants a number > 0"),
    ],
)
def test_a_file_is_refused_by_the_path_of_the_key(line: str, instead: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        sa.read_scenario(TOML.replace(line, instead))


def test_the_papers_numbers_are_the_cores() -> None:
    for name, preset in sa.paper.PRESETS.items():
        settings = sa.read_scenario(sa.paper.scenario(3, name))["compensator"]
        np.testing.assert_array_equal(settings.gain, preset["gain"])
    assert sa.paper.CENTERS == (-1.5, -0.5, 0.0, 0.5, 1.5)
    assert sa.paper.WIDTH == 0.5**0.5
    assert sa.paper.PRESETS == {
        "printed": {"form": "shared", "normalized": True, "gain": 1 / 7},
        "claimed": {"form": "grid", "normalized": False, "gain": 7.0},
    }
    assert sa.paper.reference() == sa.Sines(
        (1, 3), ((0, -0.2), (0.2, 0)), ((0.5, -0.5), (0, 0)), offset=(0, 0)
    )
    for arm, mass, inertia in [(sa.paper.nominal(), 4, 0.2), (sa.paper.actual(), 8, 0.4)]:
        assert arm == sa.TwoLink(mass, 0.5, inertia)


def test_a_scene_is_what_its_file_says(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(TOML)
    scene, sections = sa.Scene.read(file), sa.read_scenario(TOML)
    arm = sections["two_link"]
    tracker = sa.ComputedTorque(arm, 8, (5.5, 5), compensator=sections["compensator"])
    run = sa.simulate(
        sa.Plant(arm, sections["disturbance"]),
        tracker,
        sections["reference"],
        0.5,
        0.002,
        control_period=0.01,
        q0=(0.1, -0.1),
    )
    assert scene.run().e.tobytes() == run.e.tobytes()
    other = sa.Scene.read(file, gain=3.0, width=0.7, kp=9, duration=0.2, control_period=None)
    assert (other.duration, other.options["control_period"]) == (0.2, None)
    assert other.tracker.compensator == compensator(
        basis=other.tracker.compensator.basis,
        gain=(3, 3),
        q=9,
        projection_radius=60,
        dictionary=64,
        merge_tolerance=0.01,
    )
    assert other.tracker.compensator.basis == basis(
        width=0.7, normalized=False, inputs={"q": 2.0, "dq": 0.5}
    )
    np.testing.assert_array_equal(other.tracker.kp, 9.0)


@pytest.mark.parametrize(
    ("text", "overrides", "message"),
    [
        (TOML.replace("[controller]", "[contrller]"), {}, "mine.toml: line"),
        ("[run]", {}, r"mine.toml: two_link: wants a section \[two_link\]"),
        (TOML, {"gian": 1}, "mine.toml: gian: this scene has no such setting"),
        (TOML, {"gain": -1}, r"mine.toml: gain\[0\]: got -1, wants a number > 0"),
    ],
)
def test_a_scene_is_refused_by_name(
    tmp_path: Path, text: str, overrides: dict[str, Any], message: str
) -> None:
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ValueError, match=message):
        sa.Scene.read(tmp_path / "mine.toml", **overrides)


@pytest.mark.parametrize("preset", ["printed", "claimed"])
@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_simulation_of_the_paper_is_its_scenario(
    tmp_path: Path, number: Any, preset: Any
) -> None:
    (tmp_path / "paper.toml").write_text(sa.paper.scenario(number, preset))
    scene = sa.paper.simulation(number, preset, duration=0.3)
    read = sa.Scene.read(tmp_path / "paper.toml", duration=0.3)
    assert scene.run().e.tobytes() == read.run().e.tobytes()
    assert (scene.tracker.compensator is None) == (number < 3)
    assert (scene.plant.disturbance is None) == (number == 1)
