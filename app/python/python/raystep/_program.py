"""Stream programs of one's own."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _raystep
from ._options import Vector, size_of, words_of
from ._raystep import OptionError
from ._renderer import Renderer, Streams
from ._scene import Scene


class Program(Renderer):
    """A run of a program of one's own: a folder with `program.toml` and WGSL files, or a zip file of one. It is stepped
    like a `Renderer`. `raystep new NAME --like life` makes a folder.

    `scene`: the scene, for a program that reads one [default: the scene that it names]; `size` and the camera are for
    these programs, too. `starts`: what streams begin with in place of what `program.toml` says, by their names: arrays
    of shape (H, W) or (N,), with a last axis for several components.

    Raises `SceneError` if a file is wrong, with its place.

    >>> import tempfile, pathlib, subprocess, sys
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "sums"
    >>> command = [sys.executable, "-m", "raystep", "new", str(folder), "--like", "prefix-sum"]
    >>> _ = subprocess.run(command, check=True, capture_output=True)
    >>> run = Program(folder)
    >>> run.step().kernel
    'fill'
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        scene: str | os.PathLike[str] | None = None,
        *,
        starts: Mapping[str, ArrayLike] | None = None,
        size: tuple[int, int] | str | None = None,
        width: int | None = None,
        height: int | None = None,
        camera: int | None = None,
        eye: Vector | None = None,
        look_at: Vector | None = None,
        up: Vector | None = None,
        fov: float | None = None,
        timings: bool = False,
        device: str | None = None,
        adapter: str | None = None,
    ) -> None:
        path = os.fspath(path)
        named = path if scene is None else f"{path}@{os.fspath(scene)}"
        arrays = {name: _npy(name, values) for name, values in (starts or {}).items()}
        of = _raystep.Scene.read_program(named, arrays, device or "auto", adapter)
        options = {
            "size": size_of(size, width, height),
            "camera": camera,
            "eye": eye,
            "look_at": look_at,
            "up": up,
            "fov": fov,
            "timings": timings,
        }
        self._path = path
        self._scene = Scene._of(of)
        self._renderer = _raystep.Renderer(of, words_of(options))
        self._streams = Streams(self._renderer)

    def __repr__(self) -> str:
        return f"<raystep.Program {self._path!r} after {self.pass_count} passes>"

    @property
    def result(self) -> np.ndarray[Any, np.dtype[Any]]:
        """What `program.toml` names as the result, as it is now: the component that is shown, or the colour.

        Raises `OptionError` if it names none.

        >>> import pathlib, subprocess, sys, tempfile
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "cells"
        >>> command = [sys.executable, "-m", "raystep", "new", str(folder)]
        >>> _ = subprocess.run(command, check=True, capture_output=True)
        >>> Program(folder).step_to(2).result.shape
        (256, 256)
        """
        result = self._renderer.result()
        if result is None:
            raise OptionError(f"{self._path}: program.toml names no result; 'streams' has all streams")
        stream, layer = result
        values = self.streams[stream]
        return values if layer is None else values[..., layer]


def _npy(name: str, values: ArrayLike) -> bytes:
    file = io.BytesIO()
    try:
        array = np.ascontiguousarray(values)
        np.save(file, array, allow_pickle=False)
    except ValueError as error:
        raise OptionError(f"starts[{name!r}]: {error}") from None
    return file.getvalue()
