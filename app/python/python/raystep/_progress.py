"""Progress of a run: told to a function, or shown as a bar."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, NamedTuple, TypeAlias


class Progress(NamedTuple):
    """How far a run is.

    >>> from raystep import Progress
    >>> Progress(passes=3, rays_decided=50, rays=100, samples=1, samples_wanted=4).done
    0.375
    """

    passes: int
    """Passes so far."""
    rays_decided: int
    """Rays whose hit is known, of the sample that is being taken."""
    rays: int
    """Rays of a sample."""
    samples: int
    """Complete samples per pixel."""
    samples_wanted: int
    """Samples per pixel at the end."""

    @property
    def done(self) -> float:
        """Share of the work, from 0 to 1.

        >>> from raystep import Progress
        >>> Progress(9, 100, 100, 1, 1).done
        1.0
        """
        if self.samples >= self.samples_wanted:
            return 1.0
        return (self.samples + self.rays_decided / max(self.rays, 1)) / self.samples_wanted


Watching: TypeAlias = Callable[[Progress], object] | bool | None
"""A function that is called with the progress about twenty times a second, and at the end; True for a bar, False for
none. None shows a bar in a notebook if it takes long."""

PATIENCE_S = 0.5
WIDTH = 30


class Watched:
    """Tells the extension's progress to a function or a bar."""

    def __init__(self, watching: Watching) -> None:
        self._begin = time.monotonic()
        self._patience = PATIENCE_S if watching is None else 0.0
        self._bar: _Bar | None = None
        self._tell: Callable[[Progress], object] | None = watching if callable(watching) else None
        is_shown = watching is True or (watching is None and in_notebook())
        self.call: Callable[..., None] | None = self._told if self._tell or is_shown else None

    def _told(self, *progress: int) -> None:
        now = Progress(*progress)
        if self._tell:
            self._tell(now)
        elif self._bar:
            self._bar.show(now)
        elif time.monotonic() - self._begin >= self._patience:
            self._bar = _bar()
            self._bar.show(now)

    def __enter__(self) -> Callable[..., None] | None:
        return self.call

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar:
            self._bar.close()


def in_notebook() -> bool:
    """Whether a notebook's kernel runs this."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return hasattr(shell, "kernel")


def _words(now: Progress) -> str:
    if now.samples_wanted > 1:
        return f"sample {min(now.samples + 1, now.samples_wanted)} of {now.samples_wanted}"
    return f"pass {now.passes}"


class _Bar:
    """A line on a terminal; nothing elsewhere."""

    def show(self, now: Progress) -> None:
        if sys.stderr.isatty():
            filled = "=" * round(WIDTH * now.done)
            sys.stderr.write(f"\r{_words(now):<24} [{filled:<{WIDTH}}] {now.done:4.0%}")
            sys.stderr.flush()

    def close(self) -> None:
        if sys.stderr.isatty():
            sys.stderr.write("\r\033[K")


class _TqdmBar(_Bar):
    """A line on a terminal, by tqdm."""

    def __init__(self, tqdm: Any) -> None:
        self._bar = tqdm(total=100, leave=False, bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}")

    def show(self, now: Progress) -> None:
        self._bar.set_description(_words(now), refresh=False)
        self._bar.update(round(100 * now.done) - self._bar.n)

    def close(self) -> None:
        self._bar.close()


class _NotebookBar(_Bar):
    """An element of the page, which needs no widgets."""

    def __init__(self) -> None:
        display: Any = importlib.import_module("IPython.display")
        self._html = display.HTML
        self._handle = display.display(self._html(""), display_id=True)

    def show(self, now: Progress) -> None:
        bar = f'<progress value="{now.done:.3f}" style="width: 20em"></progress>'
        self._handle.update(self._html(f"{bar} {_words(now)}, {now.rays_decided:,} of {now.rays:,} rays"))

    def close(self) -> None:
        self._handle.update(self._html(""))


def _bar() -> _Bar:
    if in_notebook():
        return _NotebookBar()
    if importlib.util.find_spec("tqdm") is not None:
        return _TqdmBar(importlib.import_module("tqdm").tqdm)
    return _Bar()
