"""A record too large is refused before the run, with its size and what makes it smaller."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from run_files import RECORD, ROWS
from scenes import plant, run, tracker
from steadyarm.record import DESIRED, TORQUES


@pytest.mark.parametrize(
    ("options", "size"),
    [
        # t, |W|, V and twelve arrays of two columns: 27 numbers a row. The motion alone: 5.
        ({"duration": 1e5}, r"21\.60 GB \(100000001 rows of 216 bytes\)"),
        ({"duration": 1e8, "dt": 1.0}, r"21\.60 GB \(100000001 rows of 216 bytes\)"),
        ({"duration": 1e5, "record": "motion"}, r"4\.00 GB \(100000001 rows of 40 bytes\)"),
        ({"duration": 1e5, "method": "dp54"}, r"21\.60 GB"),
        ({"duration": 1e5, "control_period": 1e-3}, r"21\.60 GB"),
        ({"duration": 1e5, "record_every": 10}, r"2\.16 GB \(10000001 rows"),
    ],
)
def test_record_too_large_is_refused_with_its_size(options: dict[str, Any], size: str) -> None:
    way = 'take a larger number, or record="motion"'
    with pytest.raises(ValueError, match=rf"^record_every: got \d+, .* {size}.* wants .*{way}"):
        run(tracker(), **options)


def test_row_takes_what_is_said() -> None:
    columns = [getattr(RECORD, name) for name in ("t", "q", "dq", *DESIRED, *TORQUES)]
    flat = [RECORD.weights_norm, RECORD.V]
    assert sum(array.nbytes for array in columns + flat) == 216 * ROWS
    assert sum(array.nbytes for array in columns[:3]) == 40 * ROWS


def test_record_of_a_long_run_can_be_thinned() -> None:
    """The same run is taken, with fewer rows: it is broken off from its reference here."""

    def reference(t: float) -> tuple[np.ndarray, ...]:
        if t > 0.01:
            raise KeyboardInterrupt
        return sa.paper.reference()(t)

    options: dict[str, Any] = {"duration": 1e5, "record_every": 20}
    record = sa.simulate(plant(), tracker(), reference, **options)
    assert record.status.kind == "interrupted"
