"""Two runs compared."""

from __future__ import annotations

import json

from . import _raystep
from ._progress import Watched, Watching
from ._renderer import Renderer
from ._tables import Tables, table


REALS = {"a", "b", "max_difference", "max_t_difference", "max_color_difference"}
"""Columns of numbers that JSON may not have: they come as text if they are not finite."""


def compare(a: Renderer, b: Renderer, progress: Watching = None) -> Tables:
    """Compares two runs of the same size from their starts to their ends; they stay where they are. Three tables:

    - `first`: where they first differ, as long as both run the same kernels: a row for each component that differs after
      that pass, with the first ray (`x`, `y`) and its values. Empty if no pass differs.
    - `streams`: at the end, a row for each component of the streams that both have: rays that differ, units in the last
      place.
    - `runs`: one row, with passes, and rays that hit in one run only, hit another triangle, or hit at another t (in scene
      units).

    Raises `OptionError` if the sizes differ, `DeviceError` if a device fails.

    >>> from raystep import Renderer, compare
    >>> runs = [Renderer("cornell-box", size=(16, 12), numerics=rules, device="cpu") for rules in ("robust", "paper")]
    >>> sorted(compare(*runs))
    ['first', 'runs', 'streams']
    """
    with Watched(progress) as call:
        found = json.loads(_raystep.compare(a._renderer, b._renderer, call))
    for row in (row for rows in found.values() for row in rows):
        for name in REALS & row.keys():
            row[name] = None if row[name] is None else float(row[name]) if isinstance(row[name], str) else row[name]
    run, first = found["runs"][0], found["first"]
    compared = run["compared_passes"]
    if first:
        text = f"the runs differ after pass {first[0]['pass']} ({first[0]['kernel']})"
    elif compared == run["passes_a"] == run["passes_b"]:
        text = f"all {compared} passes agree"
    else:
        text = f"the first {compared} passes agree; then the runs differ in their kernels"
    return Tables({name: table(found[name]) for name in ("first", "streams", "runs")}, text=text)
