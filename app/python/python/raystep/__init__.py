"""A ray tracer for triangles, on any GPU or on the CPU, of which every pass and every stream can be inspected.

>>> import numpy as np
>>> import raystep
>>> scene = raystep.Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
>>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
>>> hits.t
array([1.5, inf], dtype=float32)
>>> hits.is_hit
array([ True, False])

A run is stepped by a `Renderer`; `compare`, `stability` and `report` return tables, and so does `sweep`, for
many scenes and options, on this machine or on a cluster; `view` shows the inspector in the browser.
"""

from __future__ import annotations

import atexit
import os
import sys

if sys.platform == "linux" and "XDG_RUNTIME_DIR" not in os.environ and "MESA_VK_DEVICE_SELECT" not in os.environ:
    # As in the command: else a layer of Mesa writes to stderr that there is no desktop.
    os.environ.setdefault("NODEVICE_SELECT", "1")

from ._commands import report, stability
from ._compare import compare
from ._display import Image, StreamArray
from ._progress import Progress
from ._program import Program
from ._raystep import DeviceError, OptionError, SceneError, __version__
from ._raystep import after_fork as _after_fork
from ._raystep import end as _end
from ._renderer import Pass, Plan, Renderer, Streams
from ._scene import MISS, Hits, Scene, scene_names
from ._sweep import SweepError, sweep
from ._tables import Table, Tables
from ._view import View, forget, view

if hasattr(os, "register_at_fork"):

    def _forked() -> None:
        _after_fork()
        forget()

    os.register_at_fork(after_in_child=_forked)

atexit.register(_end)

__all__ = [
    "MISS",
    "DeviceError",
    "Hits",
    "Image",
    "OptionError",
    "Pass",
    "Plan",
    "Program",
    "Progress",
    "Renderer",
    "Scene",
    "SceneError",
    "StreamArray",
    "Streams",
    "SweepError",
    "Table",
    "Tables",
    "View",
    "__version__",
    "compare",
    "report",
    "scene_names",
    "stability",
    "sweep",
    "view",
]

for _name in __all__:
    # Where users see them, in messages and in help.
    if isinstance(globals()[_name], type) or callable(globals()[_name]):
        globals()[_name].__module__ = __name__
