"""Commands that measure, and return their tables. Each runs in a process of its own, so that an interrupt ends it and leaves
nothing behind."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from typing import Any, TypeAlias

from ._options import Vector, size_of, words_of
from ._raystep import DeviceError, OptionError, SceneError
from ._tables import Tables, table_of_csv

PathLike: TypeAlias = str | os.PathLike[str]

USAGE = 2
"""The command's exit code for wrong options."""


def stability(
    case: str | Sequence[str] = (),
    *,
    accelerator: str | Sequence[str] | None = None,
    quick: bool = False,
    cost: bool = False,
    family: str | Sequence[str] | None = None,
    device: str | None = None,
    adapter: str | None = None,
    output: PathLike | None = None,
) -> Tables:
    """Traces extreme cases and compares every ray with brute force in f64, as `raystep stability` does: the tables of its
    CSV files, by name: `stability` with a row for each case and configuration, and `tmax`, `pipelines` and, with `cost`,
    `stiff` and `runs` where they are measured. `case`: only cases whose names contain one of these strings. `output`: a
    folder, new or empty, for all files of the report. Takes seconds for a case and minutes for all, up to 20 with `cost`.

    If a check fails, such as a wrong hit with robust numerics, no exception is raised: `failure` of the returned tables
    describes it. Raises `OptionError` for a wrong option, `DeviceError` if there is no such device.

    >>> import raystep
    >>> tables = raystep.stability("axis", quick=True, accelerator="grid", device="cpu")
    >>> len(tables["stability"]) > 0, tables.failure is None
    (True, True)
    """
    cases = [case] if isinstance(case, str) else list(case)
    options = {"accelerator": accelerator, "quick": quick, "cost": cost, "family": family}
    words = [f"--case={name}" for name in cases] + words_of({**options, "device": device, "adapter": adapter})
    return _tables("stability", words, [], output)


def report(
    scenes: PathLike | Sequence[PathLike],
    *,
    section: str | Sequence[str] | None = None,
    size: tuple[int, int] | str | None = None,
    quick: bool = False,
    seed: int | None = None,
    seeds: int | None = None,
    rays_csv: bool = False,
    methods: PathLike | None = None,
    rays_file: PathLike | None = None,
    strata: PathLike | None = None,
    scene_index: int | None = None,
    grid: int | tuple[int, int, int] | str | None = None,
    camera: int | None = None,
    eye: Vector | None = None,
    look_at: Vector | None = None,
    up: Vector | None = None,
    fov: float | None = None,
    device: str | None = None,
    adapter: str | None = None,
    output: PathLike | None = None,
) -> Tables:
    """Measures error against run time, as `raystep report` does: the tables of its CSV files, by name. `scenes`: files or
    names of scenes, one or several; all options are those of the command. `output`: a folder, new or empty, for the page,
    its plots and its tables. Takes one to three minutes for a scene on two cores; less with `quick` or few sections.

    Raises `SceneError` for a scene that cannot be read, `OptionError` for a wrong option, `DeviceError` for any other
    failure.

    >>> import raystep
    >>> tables = raystep.report("cornell-box", section="grid", quick=True, size=(16, 16), device="cpu")
    >>> "grid" in tables
    True
    """
    options: dict[str, Any] = {
        name: value for name, value in dict(locals()).items() if name not in ("scenes", "size", "output")
    }
    options.update((name, os.fspath(options[name])) for name in ("methods", "rays_file", "strata") if options[name])
    files = [scenes] if isinstance(scenes, (str, os.PathLike)) else list(scenes)
    paths = [os.fspath(file) for file in files]
    if not paths:
        raise OptionError("scenes: expected at least one")
    return _tables("report", words_of({"size": size_of(size, None, None), **options}), paths, output)


def _tables(command: str, words: list[str], scenes: list[str], output: PathLike | None) -> Tables:
    with tempfile.TemporaryDirectory(prefix="raystep-") as temporary:
        folder = os.path.join(temporary, command) if output is None else os.fspath(output)
        csv = os.path.join(folder, f"{command}.csv")
        was_there = os.path.exists(csv)
        code, out, lines = _run([command, *words, f"--output={folder}", "--", *scenes])
        errors = [line.removeprefix("error: ") for line in lines if line.startswith("error: ")]
        failure = errors[-1] if errors else None
        # A stability report that found something is written before the command fails.
        is_written = command == "stability" and code == 1 and not was_there and os.path.exists(csv)
        if code != 0 and not is_written:
            raise _exception(code, failure or f"raystep {command} ended with code {code}", scenes)
        names = sorted(name for name in os.listdir(folder) if name.endswith(".csv"))
        tables = {name.removesuffix(".csv"): table_of_csv(_read(os.path.join(folder, name))) for name in names}
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    return Tables(tables, text=out.rstrip(), notes=notes, failure=failure)


def _read(path: str) -> str:
    with open(path, encoding="utf-8", newline="") as file:
        return file.read()


def _exception(code: int, line: str, scenes: list[str]) -> Exception:
    if code == USAGE:
        return OptionError(line)
    is_of_scene = any(line.startswith(f"{scene}: ") for scene in scenes)
    return SceneError(line) if is_of_scene else DeviceError(line)


def _run(arguments: list[str]) -> tuple[int, str, list[str]]:
    """Exit code, output, and lines on stderr of the command, by this interpreter and this package."""
    package = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    process = subprocess.Popen(
        [sys.executable, "-m", "raystep", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    with process:
        try:
            out, err = process.communicate()
        except BaseException:
            # It removes what it has begun to write.
            process.terminate()
            process.wait()
            raise
    return process.returncode, out, err.splitlines()
