"""A run as a table of pandas or a dataset of xarray.

The packages are imported when they are asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._extras import imported

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]
    import xarray  # type: ignore[import-untyped, import-not-found, unused-ignore]

    from .run import Run


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
