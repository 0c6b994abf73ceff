"""Arrays that show themselves in a notebook."""

from __future__ import annotations

import base64
import html
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _raystep
from ._raystep import OptionError


class Image(np.ndarray[Any, np.dtype[np.float32]]):
    """An image: shape (H, W, 4), float32, rows from the top. r, g and b are linear light; a is the share of samples that
    hit something. A notebook shows it, in sRGB. Parts of it and results of arithmetic are arrays as any other.

    >>> from raystep import Renderer
    >>> image = Renderer("cornell-box", size=(32, 24), device="cpu").run().image()
    >>> image.shape, image.dtype, image.png()[1:4]
    ((24, 32, 4), dtype('float32'), b'PNG')
    """

    def png(self) -> bytes:
        """The image as a PNG: 8 bits a channel, sRGB, without a. Raises `OptionError` if the shape is not (H, W, 4).

        >>> import numpy as np
        >>> from raystep import Image
        >>> np.zeros((2, 3, 4), np.float32).view(Image).png()[:4]
        b'\\x89PNG'
        """
        values = np.ascontiguousarray(self, np.float32)
        if values.ndim != 3 or values.shape[2] != 4 or values.size == 0:
            raise OptionError(f"image: expected shape (H, W, 4), not {self.shape}")
        return _raystep.png_of_image(values)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the image to a .png file. Raises `OSError` if it cannot be written.

        >>> import os, tempfile
        >>> import numpy as np
        >>> from raystep import Image
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     np.ones((2, 3, 4), np.float32).view(Image).save(f"{folder}/white.png")
        ...     os.listdir(folder)
        ['white.png']
        """
        if os.path.splitext(os.fspath(path))[1].lower() != ".png":
            raise OptionError(f"{os.fspath(path)}: expected a name that ends in .png")
        data = self.png()
        with open(path, "wb") as file:
            file.write(data)

    def _repr_png_(self) -> bytes | None:
        return self.png() if self.ndim == 3 and self.shape[2] == 4 and self.size else None


class StreamArray(np.ndarray[Any, np.dtype[Any]]):
    """The values of a stream: shape (H, W, components), rows from the top; float32, or uint32 if the stream has
    integers. In a stream with both, floats are their bits: `component` returns numbers of the right type. A notebook shows
    each component with its range. Parts of it and results of arithmetic are arrays as any other.

    >>> from raystep import Renderer
    >>> hit = Renderer("cornell-box", size=(32, 24), device="cpu").run().streams["hit"]
    >>> hit.shape, hit.dtype, hit.components
    ((24, 32, 3), dtype('uint32'), ('u', 'v', 'triangle'))
    >>> hit.component("u").dtype
    dtype('float32')
    """

    stream: str
    """The stream's name."""
    components: tuple[str, ...]
    """Names of the components."""
    meanings: tuple[str, ...]
    """What each component's numbers are: float, distance (t, or a coordinate along the ray), light, count, id or tag."""
    unit: str
    """Unit of the numbers."""

    def __array_finalize__(self, other: Any) -> None:
        # Only the whole stream knows what its components are: the same values at the same places.
        is_whole = isinstance(other, StreamArray) and _layout(other) == _layout(self)
        for name, none in (("stream", ""), ("components", ()), ("meanings", ()), ("unit", "")):
            setattr(self, name, getattr(other, name, none) if is_whole else none)

    def component(self, name: str) -> NDArray[Any]:
        """A component, shape (H, W), float32 or uint32: a view of this array, not a copy. Raises `OptionError` if there is no
        such component.

        >>> from raystep import Renderer
        >>> state = Renderer("cornell-box", size=(8, 8), device="cpu").run().streams["state"]
        >>> state.component("t").dtype
        dtype('float32')
        """
        if name not in self.components:
            raise OptionError(f"{self.stream or 'array'} has no component {name!r}: it has {list(self.components)}")
        index = self.components.index(name)
        values = np.asarray(self)[..., index]
        is_float = self.meanings[index] in ("float", "distance", "light")
        return values.view(np.float32) if is_float and values.dtype == np.uint32 else values

    def png(self, name: str | None = None) -> bytes:
        """A component as a PNG in the window's colours; without a name, all three of a colour, otherwise the first.
        Raises `OptionError` if there is no such component.

        >>> from raystep import Renderer
        >>> run = Renderer("cornell-box", size=(8, 8), device="cpu").run()
        >>> run.streams["color"].png()[1:4], run.streams["hit"].png("triangle")[1:4]
        (b'PNG', b'PNG')
        """
        if name is None and self.meanings[:3] == ("light",) * 3:
            colour = np.asarray(self)[..., :3]
            return np.concatenate([colour, np.ones_like(colour[..., :1])], axis=2).view(Image).png()
        return self._drawn(name or (self.components[0] if self.components else ""))[0]

    def _drawn(self, name: str) -> tuple[bytes, tuple[float, float] | None, list[str], list[str]]:
        bits = np.ascontiguousarray(self.component(name)).view(np.uint32)
        return _raystep.draw_component(self.stream, self.components.index(name), bits)

    def _repr_html_(self) -> str | None:
        if not self.components:
            return None
        figures = "".join(map(self._figure, self.components))
        if self.meanings[:3] == ("light",) * 3:
            figures = _figure(f"{self.stream}", self.png(), "") + figures
        return f'<div style="display: flex; flex-wrap: wrap; gap: 1em">{figures}</div>'

    def _figure(self, name: str) -> str:
        picture, span, scale, others = self._drawn(name)
        legend = ""
        if span is not None:
            bar = f"background: linear-gradient(to right, {', '.join(scale)}); width: 6em; height: 0.8em"
            legend = f'{span[0]:.5g} <span style="display: inline-block; {bar}"></span> {span[1]:.5g}'
        return _figure(f"{self.stream}.{name}", picture, "<br>".join([legend, *map(html.escape, others)]))


def _layout(array: NDArray[Any]) -> tuple[Any, ...]:
    """Where an array's elements are, and what they are."""
    return array.ctypes.data, array.shape, array.strides, array.dtype


def _figure(title: str, picture: bytes, legend: str) -> str:
    data = base64.b64encode(picture).decode()
    image = f'<img src="data:image/png;base64,{data}" style="image-rendering: pixelated; min-width: 12em">'
    return f'<figure style="margin: 0">{image}<figcaption>{html.escape(title)}<br>{legend}</figcaption></figure>'
