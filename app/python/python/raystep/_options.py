"""Options of a run as the command line's words, which the extension parses."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

from ._raystep import OptionError

Vector: TypeAlias = Sequence[float]
"""Three numbers: x, y, z."""


def words_of(options: dict[str, Any]) -> list[str]:
    """`steps_per_pass=4` is `--steps-per-pass=4`, `keep_all=True` is `--keep-all`; None and False are left out.

    Several kernels are a list: `kernel=["setup.wgsl", "intersect=my.wgsl"]`.
    """
    words = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif name == "kernel" and isinstance(value, (list, tuple)):
            words += [f"{option}={_text(one, option)}" for one in value]
        elif value is not None and value is not False:
            words.append(f"{option}={_text(value, option)}")
    return words


def _text(value: Any, option: str) -> str:
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, Iterable):
        return ",".join(_text(part, option) for part in value)
    try:
        number = value.item() if hasattr(value, "item") else value
    except ValueError:
        raise OptionError(f"{option}: expected a string, a number or a sequence of these") from None
    if not isinstance(number, (int, float)):
        raise OptionError(f"{option}: expected a string, a number or a sequence of these, not {type(value).__name__}")
    return repr(number)


def size_of(size: tuple[int, int] | str | None, width: int | None, height: int | None) -> str | None:
    """`size`, or `width` and `height`, as WxH."""
    if size is not None:
        if width is not None or height is not None:
            raise OptionError("size cannot be combined with width and height: omit one of them")
        if not isinstance(size, (str, Iterable)):
            raise OptionError(f"size {size!r}: expected width and height, such as (640, 480)")
        return size if isinstance(size, str) else "x".join(str(side) for side in size)
    if (width is None) != (height is None):
        raise OptionError("width requires height as well" if height is None else "height requires width as well")
    return None if width is None else f"{width}x{height}"
