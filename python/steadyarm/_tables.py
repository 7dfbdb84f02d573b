"""A run as CSV, as a table of pandas or a dataset of xarray.

The packages are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._extras import imported

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]
    import xarray  # type: ignore[import-untyped, import-not-found, unused-ignore]

    from .run import Run


PART = 10_000
"""Rows that are made into text at once."""


def to_csv(run: Run, names: Sequence[str] | None) -> Iterator[str]:
    """Make the text of `Run.to_csv`, part by part."""
    if isinstance(names, str):
        raise TypeError(f"names: got the text {names!r}, wants a list of signals")
    known = run.channels
    for name in names or ():
        if name not in known:
            raise ValueError(f"names: got {name!r}, wants some of {', '.join(known)}")
    wanted = dict.fromkeys(name for name in (known if names is None else names) if name != "t")
    heads, columns = ["t"], [run.t]
    for name in wanted:
        array = getattr(run, name)
        heads += [name] if array.ndim == 1 else [f"{name}_{n + 1}" for n in range(array.shape[1])]
        columns += [array] if array.ndim == 1 else list(array.T)
    yield ",".join(heads) + "\n"
    for start in range(0, len(run.t), PART):
        rows = np.stack([column[start : start + PART] for column in columns], axis=1).tolist()
        yield "".join(f"{','.join(map(repr, row))}\n" for row in rows)


def to_pandas(run: Run) -> pandas.DataFrame:
    """Make the table of `Run.to_pandas`."""
    pandas = imported("pandas", "to_pandas")
    columns: dict[tuple[str, str], Any] = {}
    for name, array in run.to_dict().items():
        if array.ndim == 1:
            columns[name, ""] = array
        else:
            columns |= {(name, joint): array[:, n] for n, joint in enumerate(run.joint_names)}
    del columns["t", ""]
    names = pandas.MultiIndex.from_tuples(list(columns), names=("signal", "joint"))
    frame = pandas.DataFrame(dict(enumerate(columns.values())), index=pandas.Index(run.t, name="t"))
    frame.columns = names
    channels = run.channels.values()
    frame.attrs = {
        "units": {channel.name: channel.unit for channel in channels},
        "docs": {channel.name: channel.doc for channel in channels},
        "status": str(run.status),
    }
    return frame


def to_xarray(run: Run) -> xarray.Dataset:
    """Make the dataset of `Run.to_xarray`."""
    xarray = imported("xarray", "to_xarray")
    variables = {}
    for name, channel in run.channels.items():
        array, words = getattr(run, name), {"units": channel.unit, "long_name": channel.doc}
        variables[name] = (("t", "joint")[: array.ndim], array, words)
    coordinates = {"t": variables.pop("t"), "joint": ("joint", run.joint_names)}
    return xarray.Dataset(variables, coordinates, {"status": str(run.status)})
