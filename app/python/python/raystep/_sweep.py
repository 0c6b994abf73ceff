"""Sweeps: a command for many scenes and options, on this machine or on a Ray cluster.

What the jobs are, which of them are finished and what their results are, the program decides (`raystep sweep --serve`);
this module only takes jobs to workers and their results back.
"""

from __future__ import annotations

import contextlib
import csv
import hashlib
import importlib
import importlib.util
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import uuid
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from ._raystep import OptionError
from ._scene import scene_names
from ._tables import TableLike, table

MACHINE = "raystep_machine"
"""The Ray resource of which a node may have 1, so that one job that measures times runs there at once."""

RETRIES = 3
"""How often a job runs again whose worker was lost."""

_BUILT_IN = "built-in:"
"""What the names of scenes that are in the program begin with."""

COMMAND = "RAYSTEP_COMMAND"
"""The variable with the words that call the program, as JSON: the program itself reads it, to start its jobs."""


class SweepError(RuntimeError):
    """Some jobs of a sweep failed. `rows` has all results that were written, including those of jobs that failed a check.

    >>> error = SweepError("job a: no such scene", [{"job": "b"}])
    >>> str(error), error.rows
    ('job a: no such scene', [{'job': 'b'}])
    """

    def __init__(self, message: str, rows: Any = None) -> None:
        super().__init__(message)
        self.rows = rows


def sweep(
    scenes: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | None = None,
    options: Mapping[str, Any] | None = None,
    *,
    what: str = "render",
    each: Mapping[str, Iterable[Any]] | None = None,
    on: str = "local",
    output: str | os.PathLike[str],
    format: str | None = None,
    parts: int | None = None,
    retries: int | None = None,
    wait_s: int | None = None,
    jobs: int = 1,
    address: str | None = None,
    quiet: bool = False,
) -> TableLike:
    """Runs a command for every scene and combination of options. Returns the results as a table: a pandas frame where
    pandas is installed, otherwise a list of dicts. `output` also has them as results.csv and as a page, index.html.

    `what`: "bench", "stability" (without scenes), "report" or "render". `scenes`: files, names of included scenes, or
    patterns such as "scenes/*.glb". `options`: long options of the command for all jobs, without the leading hyphens; a
    list for an option that accepts several values or numbers. `each`: a list of values per option; every combination is a job.
    `output`: a folder, new, empty or of the same sweep; in the last case, only jobs that are not finished run. `format`
    ("png" or "exr") and `parts` (number of jobs that share the samples of an image) are for "render". A failed job is
    retried `retries` times (1). A timed job waits up to `wait_s` seconds (300) for the one before it on its machine.
    `jobs`: number of jobs that run in parallel on this machine; must be 1 if they are timed.

    `on`: "local" or "ray". With "ray", jobs run on the cluster at `address` or RAY_ADDRESS, otherwise on a cluster that
    is already running on this machine, or on a new local one. A timed job requests the resource raystep_machine if nodes
    have 1 of it each, otherwise all CPUs of a node.

    Raises `OptionError` for wrong arguments, before any job runs, and `SweepError` if jobs fail, once all others have run.
    Calling it again with the same arguments continues, also after a KeyboardInterrupt.

    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> rows = sweep(what="stability", options={"case": "no-triangle", "quick": True, "device": "cpu"},
    ...              each={"accelerator": ["grid", "bvh"]}, output=folder.name, quiet=True)
    >>> sorted(set(rows["job"] if hasattr(rows, "iloc") else (row["job"] for row in rows)))
    ['stability-accelerator-bvh', 'stability-accelerator-grid']
    >>> folder.cleanup()
    """
    if on not in ("local", "ray"):
        raise OptionError(f'on={on!r}: expected "local" or "ray"')
    if isinstance(scenes, (str, os.PathLike)):
        scenes = [scenes]
    keys: dict[str, Any] = {"what": what, "format": format, "parts": parts, "retries": retries, "wait_s": wait_s}
    if scenes is not None:
        keys["scenes"] = [_scene(os.fspath(scene)) for scene in scenes]
    tables = {
        "options": {name: _placed(name, value) for name, value in (options or {}).items()},
        "each": {name: [_placed(name, value) for value in values] for name, values in (each or {}).items()},
    }
    lines = [f"{name} = {_toml(value)}" for name, value in keys.items() if value is not None]
    for table, values in tables.items():
        lines.append(f"[{table}]")
        lines += [f"{_toml(name.replace('_', '-'))} = {_toml(value)}" for name, value in values.items()]
    before = _written(Path(output))
    with tempfile.TemporaryDirectory(prefix="raystep-") as folder:
        file = Path(folder, "sweep.toml")
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        arguments = ["sweep", str(file), "-o", os.fspath(output), "--jobs", str(jobs), *(["--quiet"] if quiet else [])]
        code, error = _ray(arguments, address) if on == "ray" else _local(arguments)
    # A name that the caller did not choose says nothing.
    error = error.replace(f"{file}: ", "").replace(str(file), "the call")
    if code in (130, -signal.SIGINT):
        raise KeyboardInterrupt
    if code != 0 and _written(Path(output)) == before:
        raise OptionError(error)
    rows = _rows(Path(output))
    if code != 0:
        raise SweepError(error, rows)
    return rows


def _written(output: Path) -> int | None:
    """When the results were written, in nanoseconds; None if they were not."""
    file = output / "results.csv"
    return file.stat().st_mtime_ns if file.exists() else None


def _scene(scene: str) -> str:
    """A file or pattern as seen from any folder; a scene's name as it is."""
    is_name = scene in scene_names() and not os.path.exists(scene)
    return scene if is_name else os.path.abspath(scene)


FILES = ("rays-file", "methods", "strata")
"""Options that name a file."""


def _placed(name: str, value: Any) -> Any:
    """A file's name as seen from any folder; other values as they are."""
    is_file = name.replace("_", "-") in FILES and isinstance(value, (str, os.PathLike))
    return os.path.abspath(value) if is_file else value


def _toml(value: Any) -> str:
    """A value as TOML."""
    if hasattr(value, "tolist"):
        value = value.tolist()  # NumPy's numbers and arrays.
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        # JSON's strings are TOML's, but for DEL.
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_toml, value))}]"
    raise OptionError(f"{value!r}: expected text, a number, True, False or a list of these")


def _rows(output: Path) -> TableLike:
    """The results, with the types that their schema gives."""
    package = json.loads((output / "datapackage.json").read_text(encoding="utf-8"))
    types = {field["name"]: field["type"] for field in package["resources"][0]["schema"]["fields"]}
    convert: dict[str, Callable[[str], Any]] = {"integer": int, "number": float, "boolean": lambda text: text == "true"}
    with open(output / "results.csv", encoding="utf-8", newline="") as file:
        rows = [
            {name: convert.get(types.get(name, ""), str)(text) if text else None for name, text in row.items()}
            for row in csv.DictReader(file)
        ]
    return table(rows)


def _command() -> list[str]:
    """The words that call the program."""
    words = os.environ.get(COMMAND)
    return json.loads(words) if words else [sys.executable, "-m", "raystep"]


class _Program:
    """The program as a process, whose messages are passed on."""

    def __init__(self, arguments: Sequence[str], variables: Mapping[str, str] | None = None, **pipes: Any) -> None:
        words = _command()
        environment = {**os.environ, COMMAND: json.dumps(words), **(variables or {})}
        self.process: subprocess.Popen[str] = subprocess.Popen(
            [*words, *arguments], stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace", env=environment,
            **pipes,
        )
        self.last = ""
        self._reader = threading.Thread(target=self._pass_on, daemon=True)
        self._reader.start()

    def _pass_on(self) -> None:
        errors: IO[str] = self.process.stderr  # type: ignore[assignment]
        for line in errors:
            if line.startswith("error: "):
                self.last = line.removeprefix("error: ").strip()
            else:
                sys.stderr.write(line)

    def end(self) -> tuple[int, str]:
        """Waits for its end; returns the exit code and the error."""
        code = self.process.wait()
        self._close()
        return code, self.last or f"raystep ended with code {code}"

    def stop(self) -> None:
        """Ends it."""
        self.process.terminate()
        self.process.wait()
        self._close()

    def _close(self) -> None:
        self._reader.join()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()


def _local(arguments: Sequence[str]) -> tuple[int, str]:
    program = _Program(arguments, stdin=subprocess.DEVNULL)
    try:
        return program.end()
    except BaseException:
        program.stop()
        raise


def _ray(arguments: Sequence[str], address: str | None) -> tuple[int, str]:
    """Runs the jobs on a cluster."""
    if importlib.util.find_spec("ray") is None:
        raise OptionError("a sweep on Ray needs Ray: install it with 'pip install ray'")
    program = _Program([*arguments, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    to: IO[str] = program.process.stdin  # type: ignore[assignment]
    answers: IO[str] = program.process.stdout  # type: ignore[assignment]
    try:
        hello = answers.readline()
        if hello:
            offer = json.loads(hello)
            if offer["jobs"]:
                _distribute(offer["jobs"], offer["folder"], to, address)
            to.close()
        return program.end()
    except BrokenPipeError:
        return program.end()
    except BaseException:
        program.stop()
        raise


def _distribute(jobs: list[dict[str, Any]], folder: str, to: IO[str], address: str | None) -> None:
    """Takes jobs to workers, and results to the program."""
    ray = importlib.import_module("ray")

    is_ours = not ray.is_initialized()
    if is_ours:
        try:
            ray.init(address=address, include_dashboard=False, log_to_driver=False, logging_level="warning")
        except Exception as refused:  # Ray raises several kinds.
            where = address or os.environ.get("RAY_ADDRESS") or "a local one"
            why = (str(refused).strip().splitlines() or [type(refused).__name__])[-1]
            raise SweepError(f"cannot start or connect to the Ray cluster ({where}): {why}") from None
    work = ray.remote(_work)
    resources = ray.cluster_resources()
    nodes = [node["Resources"] for node in ray.nodes() if node["Alive"]]
    # Enough that no worker waits, and few enough that few scenes are in the cluster's memory.
    most = 2 * max(1, int(resources.get("CPU", 1)))
    waiting = list(reversed(jobs))
    running: dict[Any, tuple[str, tuple[str, ...]]] = {}
    scenes: dict[tuple[str, ...], tuple[list[str], Any]] = {}

    def tell(**line: Any) -> None:
        to.write(json.dumps(line) + "\n")
        to.flush()

    try:
        while waiting or running:
            while waiting and len(running) < most:
                job = waiting.pop()
                files = tuple(_files(job))
                if files not in scenes:
                    # A scene that no job in flight has is not needed again: jobs are in the order of their scenes.
                    scenes = {key: value for key, value in scenes.items() if any(key == k for _, k in running.values())}
                    scenes[files] = (_hashes(files), ray.put(_packed(files)))
                hashes, packed = scenes[files]
                how = _how(job, resources, nodes)
                # In a list, the scene is fetched only by a worker that needs it.
                task = work.options(**how).remote(job, hashes, [packed], int(how["num_cpus"]))
                running[task] = (job["name"], files)
            ended, _ = ray.wait(list(running), num_returns=1, timeout=1.0)
            for task in ended:
                name, _ = running.pop(task)
                try:
                    results, error = ray.get(task)
                except Exception as lost:  # Ray's errors have no common class with those of its workers.
                    results, error = None, str(lost).strip().splitlines()[-1]
                if results is None:
                    tell(failed={"name": name, "message": error})
                    continue
                # A name that the program knows as unfinished, should this process be killed here.
                place = os.path.abspath(os.path.join(folder, f".raystep-{uuid.uuid4().hex}.part"))
                zipfile.ZipFile(io.BytesIO(results)).extractall(place)
                tell(done={"name": name, "folder": place})
    finally:
        for task in running:
            ray.cancel(task, force=True)
        if running:
            # Ray may abort if it ends before it knows what became of them.
            ray.wait(list(running), num_returns=len(running), timeout=10.0)
        if is_ours:
            ray.shutdown()


def _how(job: dict[str, Any], resources: Mapping[str, float], nodes: Sequence[Mapping[str, float]]) -> dict[str, Any]:
    """What a job asks of the cluster. One that measures times owns its machine, or is marked as shared."""
    how: dict[str, Any] = {"num_cpus": 1, "max_retries": RETRIES}
    if job["needs_gpu"] and resources.get("GPU", 0) >= 1:
        how["num_gpus"] = 1
    if job["is_timed"]:
        cores = {node.get("CPU", 0) for node in nodes}
        if resources.get(MACHINE, 0) >= 1:
            how["resources"] = {MACHINE: 1}
        elif len(cores) == 1 and max(cores) >= 1:
            how["num_cpus"] = max(cores)
        else:
            job["is_shared"] = True
    return how


def _base(files: Sequence[str]) -> str:
    return os.path.commonpath([os.path.dirname(os.path.normpath(file)) for file in files]) if files else ""


def _packed(files: Sequence[str]) -> bytes:
    """The files as a ZIP, with names relative to their common folder."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED, strict_timestamps=False) as archive:
        # A scene may name a file twice.
        for file in dict.fromkeys(files):
            archive.write(file, os.path.relpath(file, _base(files)))
    return packed.getvalue()


def _files(job: dict[str, Any]) -> list[str]:
    """The input files of a job: not the scenes that are in the program."""
    return [file for file in job["inputs"] if not file.startswith(_BUILT_IN)]


def _hashes(files: Sequence[str]) -> list[str]:
    """SHA-256 of each file; empty for one that is not there."""
    hashes = []
    for file in files:
        try:
            with open(file, "rb") as opened:
                hashes.append(hashlib.file_digest(opened, "sha256").hexdigest())
        except OSError:
            hashes.append("")
    return hashes


def _work(job: dict[str, Any], hashes: list[str], packed: list[Any], cores: int) -> tuple[bytes | None, str]:
    """Runs a job, on a worker. Returns its folder as a ZIP, or why it failed."""
    ray = importlib.import_module("ray")

    with tempfile.TemporaryDirectory(prefix="raystep-") as folder:
        files = _files(job)
        if _hashes(files) != hashes:
            # Its files are not here, or others are.
            base, here = _base(files), os.path.join(folder, "scene")
            zipfile.ZipFile(io.BytesIO(ray.get(packed[0]))).extractall(here)

            def place(file: str) -> str:
                if file.startswith(_BUILT_IN):
                    return file
                return os.path.join(here, os.path.relpath(file, base))

            named = [{**name, "path": place(name["path"])} for name in job["named"]]
            job = {**job, "inputs": [place(file) for file in job["inputs"]], "named": named}
        file, results = Path(folder, "job.json"), Path(folder, "results")
        file.write_text(json.dumps(job), encoding="utf-8")
        # Other jobs have the other cores.
        threads = {} if job["is_timed"] else {"RAYON_NUM_THREADS": str(cores)}
        # Its standard input closes when this worker is lost: then it ends, too.
        arguments = ["sweep", "--run-job", str(file), "-o", str(results)]
        code, error = _Program(arguments, threads, stdin=subprocess.PIPE).end()
        if code != 0:
            return None, error
        archive = io.BytesIO()
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as into:
            for path in sorted(results.rglob("*")):
                if path.is_file():
                    into.write(path, path.relative_to(results))
        return archive.getvalue(), ""


def takes(arguments: Sequence[str]) -> bool:
    """Whether a command line is a sweep on Ray."""
    pairs = zip(arguments, arguments[1:], strict=False)
    on_ray = "--on=ray" in arguments or ("--on", "ray") in pairs
    return arguments[:1] == ["sweep"] and on_ray and not {"-h", "--help"} & set(arguments)


def main(arguments: Sequence[str]) -> int:
    """Runs the command line of a sweep on Ray; RAY_ADDRESS names its cluster. Returns the exit code."""
    words = [word for word in arguments if word != "--on=ray"]
    if "--on" in words:
        at = words.index("--on")
        del words[at : at + 2]
    try:
        code, error = _ray(words, None)
    except OptionError as wrong:
        code, error = 2, str(wrong)
    except SweepError as lost:
        code, error = 1, str(lost)
    except KeyboardInterrupt:
        return 130
    if code != 0:
        print(f"error: {error}", file=sys.stderr)
    return code
