"""Scenes, and rays through them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _raystep
from ._raystep import OptionError

MISS = 0xFFFFFFFF
"""The index of a triangle or material where a ray hits nothing."""

SCENES = os.path.join(os.path.dirname(__file__), "scenes")
_raystep.set_scenes(SCENES)

HIT = np.dtype([("t", "<f4"), ("u", "<f4"), ("v", "<f4"), ("triangle", "<u4"), ("material", "<u4")])


@dataclass(frozen=True)
class Hits:
    """What rays hit, in their order: arrays of shape (N,), which share one block of memory.

    >>> from raystep import Scene
    >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
    >>> hits = scene.cast([[0, 0, 3]], [[0, 0, -2]])
    >>> len(hits), float(hits.u[0]), float(hits.v[0]), int(hits.triangle[0])
    (1, 0.25, 0.5, 0)
    """

    records: NDArray[Any]
    """All of it, as an array of records."""

    ray: NDArray[np.uint64] | None = None
    """With `all_hits`, the index of each hit's ray: hits are ray after ray. Otherwise None."""

    def __len__(self) -> int:
        return len(self.records)

    @property
    def t(self) -> NDArray[np.float32]:
        """t of the hit, in multiples of the ray's direction; infinite without a hit.
        Otherwise positive and finite: the largest float32 where t is larger, rounded up where it is below 1.2e-38.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.t
        array([1.5, inf], dtype=float32)
        """
        return self.records["t"]

    @property
    def u(self) -> NDArray[np.float32]:
        """Barycentric weight of the triangle's vertex 1.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.u[0]
        np.float32(0.25)
        """
        return self.records["u"]

    @property
    def v(self) -> NDArray[np.float32]:
        """Barycentric weight of the triangle's vertex 2.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.v[0]
        np.float32(0.5)
        """
        return self.records["v"]

    @property
    def triangle(self) -> NDArray[np.uint32]:
        """The triangle's index in the scene; `MISS` without a hit.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.triangle == MISS
        array([False,  True])
        """
        return self.records["triangle"]

    @property
    def material(self) -> NDArray[np.uint32]:
        """The index of its material in the scene; `MISS` without a hit.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.material[0]
        np.uint32(0)
        """
        return self.records["material"]

    @property
    def is_hit(self) -> NDArray[np.bool_]:
        """Whether a ray hits anything.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> hits = scene.cast([[0, 0, 3], [5, 5, 3]], [[0, 0, -2], [0, 0, -1]])
        >>> hits.is_hit
        array([ True, False])
        """
        return np.not_equal(self.triangle, MISS)


def _floats(name: str, values: ArrayLike, shape: str, wanted: tuple[int, ...], least: int = 0) -> NDArray[np.float32]:
    """Values as contiguous, aligned float32: themselves if they are, else a copy. `least`: dimensions that they get."""
    return _single(_numbers(name, values, shape, wanted, least))


def _single(array: NDArray[Any]) -> NDArray[np.float32]:
    """The same in float32."""
    with np.errstate(all="ignore"):
        return np.require(array, np.float32, ["C", "A"])


def _numbers(name: str, values: ArrayLike, shape: str, wanted: tuple[int, ...], least: int = 0) -> NDArray[Any]:
    """Values as an array of this shape, of any type of numbers."""
    if np.ma.isMaskedArray(values):
        raise OptionError(f"{name}: expected an array without a mask")
    try:
        array = np.array(values, copy=None, ndmin=least)
    except (TypeError, ValueError) as error:
        raise OptionError(f"{name}: expected numbers of shape {shape}: {error}") from None
    if array.dtype.kind not in "fiub":
        raise OptionError(f"{name}: expected numbers of shape {shape}, not {array.dtype}")
    if array.shape == (0,):
        array = array.reshape(0, *wanted)
    if array.ndim != len(wanted) + 1 or array.shape[1:] != wanted:
        raise OptionError(f"{name}: expected numbers of shape {shape}, not {array.shape}")
    return array


def _ends(name: str, values: ArrayLike, rays: int) -> NDArray[np.float32]:
    """One value for all rays, or one for each."""
    array = _floats(name, values, f"() or ({rays},)", (), 1)
    if len(array) not in (1, rays):
        raise OptionError(f"{name}: expected 1 or {rays} numbers, not {len(array)}")
    return array


def scene_names() -> list[str]:
    """Names of the scenes included in the package: `Scene("cornell-box")` opens one, as does every command.

    >>> from raystep import scene_names
    >>> "cornell-box" in scene_names(), "teapot" in scene_names()
    (True, True)
    """
    return sorted(name for name, end in map(os.path.splitext, os.listdir(SCENES)) if end in (".gltf", ".glb"))


class Scene:
    """A scene on a device: a file (.gltf, .glb, .obj, .ply or .stl), the name of an included scene, see `scene_names`, or
    triangles of shape (N, 3, 3), corners in scene units. An existing file takes precedence over an included scene of the same name.

    `device`: "auto" is the best GPU, otherwise the CPU; or "gpu", "cpu". `adapter`: the name of a GPU, or part of it.
    Raises `SceneError` for a file that cannot be read, `OptionError` for a wrong argument, `DeviceError` if there is no
    such device.

    >>> Scene("cornell-box", device="cpu").triangles
    26
    >>> Scene(triangles=np.zeros((4, 3, 3)), device="cpu").triangles
    4
    >>> Scene("missing.glb")
    Traceback (most recent call last):
        ...
    raystep.SceneError: missing.glb: No such file or directory
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        triangles: ArrayLike | None = None,
        device: str = "auto",
        adapter: str | None = None,
    ) -> None:
        if (path is None) == (triangles is None):
            raise OptionError("expected either a file or triangles")
        if path is not None:
            self._scene = _raystep.Scene.read(os.fspath(path), device, adapter)
        else:
            corners = _numbers("triangles", triangles, "(N, 3, 3)", (3, 3))  # type: ignore[arg-type]
            self._scene = _raystep.Scene.of_triangles(np.require(corners, np.float64, ["C", "A"]), device, adapter)

    @classmethod
    def _of(cls, scene: _raystep.Scene) -> Scene:
        of = cls.__new__(cls)
        of._scene = scene
        return of

    def __repr__(self) -> str:
        return f"<raystep.Scene {self.name!r}, {self.triangles} triangles, on {self.device}>"

    @property
    def name(self) -> str:
        """The file's name without its extension; empty for triangles.

        >>> Scene(triangles=np.zeros((1, 3, 3)), device="cpu").name
        ''
        """
        return self._scene.name

    @property
    def triangles(self) -> int:
        """Number of triangles.

        >>> Scene(triangles=[], device="cpu").triangles
        0
        """
        return self._scene.triangles

    @property
    def device(self) -> str:
        """Name of the GPU, or "cpu".

        >>> Scene(triangles=[], device="cpu").device
        'cpu'
        """
        return self._scene.device

    @property
    def notes(self) -> list[str]:
        """Features of the file that were ignored or changed, one string each.

        >>> Scene("cornell-box", device="cpu").notes
        []
        """
        return self._scene.notes

    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
        """Lower and upper corner of the box of all triangles, in the file's coordinates; None without triangles.

        >>> Scene(triangles=[[[0, 0, 0], [1, 0, 0], [0, 2, 0]]], device="cpu").bounds
        ((0.0, 0.0, 0.0), (1.0, 2.0, 0.0))
        """
        bounds = self._scene.bounds
        return None if bounds is None else (tuple(bounds[0]), tuple(bounds[1]))  # type: ignore[return-value]

    @property
    def offset(self) -> tuple[float, float, float]:
        """What is subtracted from coordinates before they are rounded to float32: 0 unless all triangles are far from the
        origin for their size. Streams and images of a run are relative to it; arguments and results are not.

        >>> far = np.array([[[0, 0, 0], [1, 0, 0], [0, 2, 0]]]) + [1e7, 0, 0]
        >>> scene = Scene(triangles=far, device="cpu")
        >>> scene.offset[0] > 9e6, scene.bounds
        (True, ((10000000.0, 0.0, 0.0), (10000001.0, 2.0, 0.0)))
        """
        return tuple(self._scene.offset)  # type: ignore[return-value]

    def cast(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        any_hit: bool = False,
        all_hits: bool = False,
    ) -> Hits:
        """The closest hit of each ray, or any hit, or all.

        `origins`, `directions`: shape (N, 3), in the file's coordinates; contiguous float32 arrays are read without copying.
        For a scene with an `offset`, origins should be float64. Directions need not be normalised, but must not be zero. `t_min`, `t_max`: one number or (N,), in multiples of the direction; a hit counts
        if it lies between them. `all_hits`: every surface that a ray crosses, once, ray after ray, and each ray's in the order of
        exact t; `Hits.ray` tells whose a hit is. At edges and corners, a ray is taken to start an infinitesimal beside its
        origin, so that it enters a closed surface as often as it leaves it; t is 0 where it starts on one and leaves it.
        The structure that is fastest for the scene and the device is built at the first call and kept. Raises `OptionError` for arrays of wrong shapes or types, and
        for a ray that cannot be traced, such as one that is not finite; no ray is traced then. Other threads run
        meanwhile; casts of one scene take turns.

        >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
        >>> bool(scene.cast([[0, 0, 3]], [[0, 0, -1]], t_max=2.0).is_hit[0])
        False
        >>> scene.cast([[0, 0, np.nan]], [[0, 0, -1]])
        Traceback (most recent call last):
            ...
        raystep.OptionError: ray 0 cannot be traced: a component is not finite
        >>> walls = np.array([[[-1, -1, z], [1, -1, z], [0, 1, z]] for z in (0, 1, 2)])
        >>> hits = Scene(triangles=walls, device="cpu").cast([[9, 0, 3], [0, 0, 3]], [[0, 0, -1]] * 2, all_hits=True)
        >>> hits.ray, hits.t
        (array([1, 1, 1], dtype=uint64), array([1., 2., 3.], dtype=float32))
        """
        if any_hit and all_hits:
            raise OptionError("any_hit and all_hits exclude each other")
        starts, along = _numbers("origins", origins, "(N, 3)", (3,)), _floats("directions", directions, "(N, 3)", (3,))
        if any(self.offset):
            starts = np.subtract(starts, self.offset, dtype=np.float64)
        from_ = _single(starts)
        if len(from_) != len(along):
            raise OptionError(f"origins and directions: expected equal lengths, not {len(from_)} and {len(along)}")
        near, far = _ends("t_min", t_min, len(from_)), _ends("t_max", t_max, len(from_))
        words, ray = self._scene.cast(from_, along, near, far, 2 if all_hits else int(any_hit))
        return Hits(words.view(HIT), ray if all_hits else None)
