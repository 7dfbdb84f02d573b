"""What `simulate_many` refuses, one thing wrong at a time."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import TWO, made, nominal, plant
from many_scenes import NOISY, fuzzy, guarded, many

ONE: dict[str, tuple[Any, str]] = {
    "threads of 0": ({"threads": 0}, r"threads: got 0, wants a whole number >= 1"),
    "threads of 1.5": ({"threads": 1.5}, r"threads: got 1.5, wants a whole number >= 1"),
    "record": ({"record": "some"}, r"record: got 'some', wants 'motion', 'all' or None"),
    "band": ({"band": 0.0}, r"band: got 0.0, wants a number > 0"),
    "window behind": ({"window": (1, 2)}, r"window: got \(1, 2\), wants \(from, to\) within 0 to"),
    "window turned": ({"window": (0.05, 0.01)}, r"window: got .*, wants \(from, to\) within"),
    "window of NaN": ({"window": (math.nan, 1.0)}, r"window: got .*, wants \(from, to\) within"),
    "no runs": ({"changes": []}, r"changes: got no runs, wants at least 1"),
    "no plants": ({"plant": []}, r"plant: got no runs, wants at least 1"),
    "two lengths": (
        {"plant": [plant(TWO)] * 3, "q0": np.zeros((2, 2))},
        r"q0: got 2 runs, wants 3, as plant has",
    ),
    "seeds and changes": (
        {"seeds": [1, 2], "effects": sa.Effects(), "changes": [{}]},
        r"seeds: got 2 runs, wants 1, as changes has",
    ),
    "seeds twice": (
        {"seeds": [1], "effects": sa.Effects(), "changes": [{"effects.seed": 3}]},
        r"seeds: got changes of 'effects.seed' beside them",
    ),
    "seeds of nothing": ({"seeds": [1]}, r"seeds: got effects=None, wants Effects"),
    "a seed below 0": (
        {"seeds": [1, -1], "effects": sa.Effects()},
        r"seeds: got -1 for run 1, wants whole numbers",
    ),
    "a seed of half": (
        {"seeds": [0.5], "effects": sa.Effects()},
        r"seeds: got 0.5 for run 0, wants whole numbers",
    ),
    "changes of what is the same": (
        {"changes": [{}, {"dt": 1e-4}]},
        r"changes: got 'dt' for run 1, wants one of plant, tracker, reference, effects, q0, dq0",
    ),
    "changes of no argument": (
        {"changes": [{"plant.arm.weight": 3.0}]},
        r"changes: got 'plant.arm.weight' for run 0; plant.arm is a TwoLink, which has mass, len",
    ),
    "changes of a law without its name": (
        {"tracker": made("pid", TWO), "changes": [{"tracker.kp": 3.0}]},
        r"changes: got 'tracker.kp' for run 0; .* an argument of its law is 'tracker.law.kp'",
    ),
    "changes of no law": (
        {"tracker": made("pid", TWO), "changes": [{"tracker.law.kq": 3.0}]},
        r"law: unknown field `kq`, .*\nsteadyarm: for run 0, changes of tracker: law",
    ),
    "changes of None": (
        {"changes": [{"effects.noise": 3.0}]},
        r"changes: got 'effects.noise' for run 0; effects is None, wants all of it",
    ),
    "changes within a guard": (
        {"tracker": guarded(), "changes": [{"tracker.slack": 3.0}]},
        r"changes: got 'tracker.slack' for run 0; tracker is a Guard, wants all of it",
    ),
    "changes within a chain": (
        {
            "plant": sa.Plant(sa.Serial.shipped("panda")),
            "changes": [{"plant.arm.mass": 3.0}],
        },
        r"changes: got 'plant.arm.mass' for run 0; plant.arm is a Serial, wants all of it, by the "
        "name 'plant.arm'",
    ),
    "changes to what cannot be": (
        {"changes": [{"plant.arm.mass": -3.0}]},
        r"mass\[0\]: got -3, wants a number > 0\nsteadyarm: for run 0, changes of plant.arm: mass",
    ),
    "joints of plants": (
        {"plant": [plant(TWO), sa.Plant(sa.Serial.shipped("panda"))]},
        r"plant: got one of 7 joints for run 1, wants 2, as run 0 has",
    ),
    "joints of the tracker": (
        {"plant": sa.Plant(sa.Serial.shipped("panda"))},
        r"plant: got one of 7 joints, wants 2, as the tracker has",
    ),
    "a start of three": ({"q0": np.zeros((4, 3))}, r"q0: got shape \(3,\), wants a scalar or \(2,"),
    "a start that is no number": (
        {"q0": [[0.1, 0.2], [0.3, math.nan]]},
        r"q0\[1\]: got NaN, wants a finite number \(run 1\)$",
    ),
    "starts of three": ({"q0": np.zeros((1, 1, 2))}, r"q0: got shape .*, wants \(n,\) or \(M, n\)"),
    "dt": ({"dt": -1e-3}, r"dt: got "),
    "effects without a period": (
        {"effects": sa.Effects(delay=1), "control_period": None},
        r"control_period: got None, wants a period",
    ),
}


def told(caught: pytest.ExceptionInfo[BaseException]) -> str:
    return "\n".join([str(caught.value), *getattr(caught.value, "__notes__", ())])


@pytest.mark.parametrize(("options", "message"), ONE.values(), ids=ONE)
def test_what_makes_no_sense_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError) as caught:
        many(**options)
    assert re.match(message, told(caught)), told(caught)


OF_TYPE: dict[str, tuple[Any, str]] = {
    "plant": ({"plant": [plant(TWO), nominal(TWO)]}, r"plant: got TwoLink for run 1, wants a Plan"),
    "tracker": (
        {"tracker": [fuzzy(), 3]},
        r"tracker: got int for run 1, wants a Controller, such as a ComputedTorque, or a Guard$",
    ),
    "effects of a run": ({"effects": [None, {}]}, r"effects: got dict, .* \(run 1\)$"),
    "reference": ({"reference": "sines"}, r"reference: got str"),
    "effects": ({"effects": [{}]}, r"effects: got dict"),
    "changes": ({"changes": {"q0": 1}}, r"changes: got .*, wants a list with one a run"),
    "changes of a run": ({"changes": [3]}, r"changes: got 3 for run 0, wants a dict"),
    "seeds": ({"seeds": 3, "effects": NOISY}, r"seeds: got 3, wants a list with one a run"),
    "seeds of one number": (
        {"seeds": np.array(3), "effects": NOISY},
        r"seeds: got array\(3\), wants a list with one a run",
    ),
    "window": ({"window": 3.0}, r"window: got 3.0, wants \(from, to\)"),
    "band": ({"band": "wide"}, r"band: got str, wants real numbers"),
    "duration": ({"duration": "long"}, r"duration: got str, wants real numbers"),
    "q0": ({"q0": "home"}, r"q0: got str, wants real numbers"),
    "q0 of other lengths": ({"q0": [[1.0, 2.0], [3.0]]}, r"q0: got list, wants real numbers"),
}


@pytest.mark.parametrize(("options", "message"), OF_TYPE.values(), ids=OF_TYPE)
def test_what_is_of_another_type_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError, match=f"^{message}"):
        many(**options)
