"""A run that is stepped, and everything in it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _raystep
from ._display import Image, StreamArray
from ._options import Vector, size_of, words_of
from ._progress import Progress, Watched, Watching
from ._raystep import OptionError
from ._scene import Scene
from ._tables import TableLike, table_of_csv


@dataclass(frozen=True)
class Pass:
    """A pass that has run.

    >>> from raystep import Renderer
    >>> pass_ = Renderer("cornell-box", size=(8, 8), device="cpu").step()
    >>> pass_.index, pass_.kernel, pass_.rays_in
    (0, 'generate', 64)
    """

    index: int
    """Its index in the run, from 0."""
    sample: int
    """The sample of every pixel that it belongs to, from 0."""
    iteration: int
    """Iterations of the walk's loop that have begun in this sample; always 0 where the walk is one kernel."""
    kernel: str
    """Name of its kernel."""
    rays_in: int
    """Rays that it worked on."""
    states: dict[str, int]
    """Rays in each state after it."""
    threads_launched: int
    """Threads, with or without a ray to work on."""
    begin_ns: int | None
    """When it began, on the device's own clock, which starts at any time; None without `timings=True`."""
    duration_ns: int | None
    """How long it took on the device; None without `timings=True`, or if it is not known."""
    below_ns: int | None
    """Upper bound of the duration if the device's clock is too coarse to measure it."""


@dataclass(frozen=True)
class Plan:
    """What a run needs, what it omits, and why, as `raystep plan` prints it.

    >>> from raystep import Renderer
    >>> plan = Renderer("cornell-box", size=(8, 8), device="cpu").plan()
    >>> plan.data["rays"], plan.data["kernels"][0]["name"], "generate" in plan.text
    (64, 'generate', True)
    """

    text: str
    """Formatted for reading."""
    data: dict[str, Any]
    """As the JSON of `raystep plan --json`: kernels with their bindings, streams and buffers with their bytes."""

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return self.text


class Streams(Mapping[str, StreamArray]):
    """The streams of a run by name, after the pass that ran last. Each access reads the stream anew: one read earlier
    stays as it was.

    >>> from raystep import Renderer
    >>> run = Renderer("cornell-box", size=(8, 8), steps_per_pass=1, device="cpu")
    >>> list(run.streams)[:3], len(run.streams) == len(list(run.streams))
    (['ray_origin', 'ray_direction', 'state'], True)
    >>> run.step_to(2).streams["tmax"].shape
    (8, 8, 3)
    >>> run.streams["nothing"]
    Traceback (most recent call last):
        ...
    KeyError: 'nothing'
    """

    def __init__(self, renderer: _raystep.Renderer) -> None:
        self._renderer = renderer
        self._rows = {row[0]: row for row in renderer.streams()}

    def __getitem__(self, name: str) -> StreamArray:
        _, components, meanings, is_float, unit = self._rows[name]
        bits, width, height, count = self._renderer.values(name)
        # As the device has it, a layer a component; nothing is copied. Elements that are no image are a row.
        shape = (len(components), height, width) if count is None else (len(components), height * width)
        bits = bits.reshape(shape)
        if count is not None:
            bits = bits[:, :count]
        values = np.moveaxis(bits.view(np.float32) if is_float else bits, 0, -1).view(StreamArray)
        values.stream, values.unit = name, unit
        values.components, values.meanings = tuple(components), tuple(meanings)
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<raystep.Streams: {', '.join(self._rows)}>"


class Renderer:
    """A run of a scene, between two passes: stepped forwards and backwards, or run to its end.

    `scene`: a `Scene`, or what `Scene` opens, with `device` and `adapter`. All other options are those of `raystep
    render`, with the same values: pixels (`size=(640, 480)`, or `width` and `height`), camera (its index, or `eye`,
    `look_at`, `up`, `fov` in degrees, scene units), samples (`spp`, `sampler`, `seed`), and how rays are traced. As passes
    are stepped, `accelerator` is "grid" and `schedule` "compact" by default.
    `counters` counts cells and tests per ray; `timings` times every pass. `kernel` replaces a kernel by WGSL of your own:
    a file whose `@compute` function has the kernel's name, "NAME=FILE", or several of these.

    Raises `OptionError` for a wrong option, with the command line's words; `SceneError` for a scene that cannot be
    traced; `DeviceError` if the device fails. Other threads run while it works, and calls from several threads take
    turns. Ctrl-C ends a call between two passes, and the run can go on from there.

    >>> from raystep import Renderer
    >>> run = Renderer("cornell-box", size=(32, 24), accelerator="bvh", device="cpu")
    >>> [pass_.kernel for pass_ in run][:3]
    ['generate', 'setup', 'walk']
    >>> run.image().shape
    (24, 32, 4)
    >>> Renderer("cornell-box", accelerator="tree", device="cpu")
    Traceback (most recent call last):
        ...
    raystep.OptionError: --accelerator tree: expected auto, grid, irregular, bvh or none
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        *,
        size: tuple[int, int] | str | None = None,
        width: int | None = None,
        height: int | None = None,
        camera: int | None = None,
        eye: Vector | None = None,
        look_at: Vector | None = None,
        up: Vector | None = None,
        fov: float | None = None,
        spp: int | None = None,
        sampler: str | None = None,
        seed: int | None = None,
        integrator: str | None = None,
        max_depth: int | None = None,
        strategy: str | None = None,
        environment: str | None = None,
        iterations: int | None = None,
        photons: int | None = None,
        photon_map: str | None = None,
        neighbours: str | None = None,
        nearest: int | None = None,
        gather: str | None = None,
        gather_radius: int | None = None,
        accelerator: str | None = None,
        schedule: str | None = None,
        mapping: str | None = None,
        targets: str | None = None,
        update: str | None = None,
        cull: str | None = None,
        until: str | None = None,
        traversal: str | None = None,
        numerics: str | None = None,
        order: str | None = None,
        grid: int | tuple[int, int, int] | str | None = None,
        skip: str | None = None,
        steps_per_pass: int | None = None,
        build: str | None = None,
        keep_all: bool = False,
        kernel: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None = None,
        counters: bool = False,
        timings: bool = False,
        device: str | None = None,
        adapter: str | None = None,
    ) -> None:
        options = {
            name: value
            for name, value in dict(locals()).items()
            if name not in ("self", "scene", "size", "width", "height", "device", "adapter")
        }
        if not isinstance(scene, Scene):
            # Fragment programs need a GPU, if only one in software.
            is_drawn = mapping is not None and mapping != "compute" and adapter is None
            scene = Scene(scene, device=device or ("gpu" if is_drawn else "auto"), adapter=adapter)
        elif device is not None or adapter is not None:
            raise OptionError("device and adapter are already set by the Scene: omit them, or pass a file or a name")
        words = words_of({"size": size_of(size, width, height), **options})
        self._scene = scene
        self._renderer = _raystep.Renderer(scene._scene, words)
        self._streams = Streams(self._renderer)

    def __repr__(self) -> str:
        return f"<raystep.Renderer of {self._scene.name!r} after {self.pass_count} passes>"

    @property
    def scene(self) -> Scene:
        """The scene.

        >>> Renderer("cornell-box", size=(8, 8), device="cpu").scene.name
        'cornell-box'
        """
        return self._scene

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").size
        (8, 6)
        """
        width, height = self._renderer.size
        return width, height

    @property
    def notes(self) -> list[str]:
        """Notes about the chosen options, one string each.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").notes
        []
        """
        return self._renderer.notes

    @property
    def pass_count(self) -> int:
        """Passes so far.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").step_to(3).pass_count
        3
        """
        return self._renderer.pass_count()

    @property
    def is_complete(self) -> bool:
        """Whether no pass is left.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").run().is_complete
        True
        """
        return self._renderer.is_complete()

    @property
    def progress(self) -> Progress:
        """How far the run is.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").progress.rays
        48
        """
        return Progress(*self._renderer.progress())

    @property
    def streams(self) -> Streams:
        """The streams after the pass that ran last.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").run().streams["color"].shape
        (6, 8, 3)
        """
        return self._streams

    def step(self) -> Pass | None:
        """Runs one pass; None if the run is complete.

        >>> Renderer("cornell-box", size=(8, 6), device="cpu").step().kernel
        'generate'
        """
        return _pass(self._renderer.step())

    def back(self) -> Pass | None:
        """Steps back by one pass, to exactly the state before it. Returns the pass that is now the last one, or None at the
        start. Some passes may run again: the first step back can take as long as the run so far, later ones less.

        >>> run = Renderer("cornell-box", size=(8, 6), device="cpu").step_to(3)
        >>> run.back().index, run.pass_count
        (1, 2)
        """
        return _pass(self._renderer.back())

    def step_to(self, passes: int, progress: Watching = None) -> Renderer:
        """Steps forwards or backwards until `passes` passes have run, or to the end if that comes first. `progress`: a
        function called with a `Progress` about 20 times a second, or True for a bar. An exception in it ends the call.

        >>> run = Renderer("cornell-box", size=(8, 6), device="cpu")
        >>> run.step_to(4).pass_count, run.step_to(1).pass_count
        (4, 1)
        """
        if not isinstance(passes, (int, np.integer)) or passes < 0:
            raise OptionError(f"passes {passes!r}: expected an integer of at least 0")
        with Watched(progress) as call:
            self._renderer.go(min(int(passes), END), call)
        return self

    def run(self, progress: Watching = None) -> Renderer:
        """Runs to the end. `progress` as for `step_to`; without it, a notebook shows a bar.

        >>> run = Renderer("cornell-box", size=(8, 6), spp=4, device="cpu")
        >>> run.run(progress=lambda now: print(now.samples) if now.done == 1 else None).is_complete
        4
        True
        """
        return self.step_to(END, progress)

    def __iter__(self) -> Iterator[Pass]:
        """The passes that are left, each run when it is asked for."""
        while (pass_ := self.step()) is not None:
            yield pass_

    def image(self) -> Image:
        """The image so far, shape (H, W, 4): with several samples, their mean.

        >>> float(Renderer("cornell-box", size=(8, 6), device="cpu").run().image()[3, 4, 3])
        1.0
        """
        width, height = self.size
        return self._renderer.image().reshape(height, width, 4).view(Image)

    def history(self, x: int, y: int) -> TableLike:
        """What each pass does to the ray of pixel (x, y), counted from 0 at the top left: a row for every pass that works
        on it, with the reason. Columns are those of `raystep trace --format csv`: names say whether a value is from
        before or after the pass; lengths are in traced units. The run itself stays where it is. Raises `OptionError` if there is no
        such pixel.

        >>> rows = Renderer("cornell-box", size=(8, 6), device="cpu").history(4, 3)
        >>> list(rows["kernel"] if hasattr(rows, "iloc") else rows.column("kernel"))[:2]
        ['generate', 'setup']
        """
        for value in (x, y):
            if not isinstance(value, (int, np.integer)) or not 0 <= value < 1 << 32:
                raise OptionError(f"pixel {x},{y}: expected two integers of at least 0")
        return table_of_csv(self._renderer.history(int(x), int(y)))

    def plan(self) -> Plan:
        """What the run needs, what it omits, and why.

        >>> Renderer("cornell-box", size=(8, 6), accelerator="bvh", device="cpu").plan().data["accelerator"]
        'bvh'
        """
        text, data = self._renderer.plan()
        return Plan(text, json.loads(data))

    def timings(self) -> TableLike:
        """A row for every pass so far, or for every part of one that is drawn; columns as in `raystep render
        --passes-csv`, times in nanoseconds. They are None without `timings=True`, and counters without `counters=True`.

        >>> run = Renderer("cornell-box", size=(8, 6), timings=True, device="cpu").run()
        >>> len(run.timings()) == run.pass_count
        True
        """
        return table_of_csv(self._renderer.timings())


def _pass(parts: _raystep._Pass | None) -> Pass | None:
    return None if parts is None else Pass(*parts[:5], dict(parts[5]), *parts[6:])


END = (1 << 63) - 1
"""More passes than any run has."""
