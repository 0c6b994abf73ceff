"""Holds what raystep reads of scene files against other readers; see tests/corpus.sh."""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import trimesh

ENDINGS = {".gltf", ".glb", ".obj", ".ply", ".stl"}
LIMIT_S = 60
# Both readers transform in f64 but hold coordinates in f32 at some point, and raystep rounds once to f32 relative to the
# scene's offset: a few units in the last place of the largest coordinate.
BOUNDS = 4e-6
# A triangle's area moves with its corners; of thin ones by a multiple.
AREA = 1e-4


@dataclass
class Shape:
    """What is compared."""

    triangles: int
    bounds: np.ndarray | None
    area: float

    def differs(self, other: Shape) -> str:
        """What differs, in a word; empty if nothing does."""
        if self.triangles != other.triangles:
            return f"{other.triangles} triangles"
        if self.bounds is None or other.bounds is None:
            return "" if self.bounds is other.bounds else "bounds"
        size = max(np.abs(self.bounds).max(), np.abs(other.bounds).max())
        if np.abs(self.bounds - other.bounds).max() > BOUNDS * size:
            return "bounds"
        if not math.isclose(self.area, other.area, rel_tol=AREA, abs_tol=AREA * BOUNDS * size * size):
            return f"area {other.area:.6g}"
        return ""


def shape_of(triangles: np.ndarray) -> Shape:
    """That of corners (N, 3, 3), without triangles that have a corner that is no number."""
    triangles = triangles[np.isfinite(triangles).all(axis=(1, 2))].astype(np.float64)
    if len(triangles) == 0:
        return Shape(0, None, 0.0)
    corners = triangles.reshape(-1, 3)
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    return Shape(len(triangles), np.array([corners.min(axis=0), corners.max(axis=0)]), float(area))


def by_trimesh(path: Path) -> Shape | str:
    """What trimesh reads, or why it reads nothing."""
    try:
        scene = trimesh.load_scene(path, process=False, skip_materials=True)
        parts = [np.zeros((0, 3, 3))]
        for node in scene.graph.nodes_geometry:
            matrix, name = scene.graph[node]
            mesh = scene.geometry[name]
            if isinstance(mesh, trimesh.Trimesh):
                points = np.asarray(mesh.vertices, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
                parts.append(points[mesh.faces])
        return shape_of(np.concatenate(parts))
    except Exception as error:  # Whatever it stumbles over is its own affair.
        return f"{type(error).__name__}: {error}".splitlines()[0][:80]


def by_assimp(path: Path, folder: Path) -> Shape | str:
    """What assimp reads, by way of a binary STL file, or why it reads nothing."""
    out = folder / "assimp.stl"
    out.unlink(missing_ok=True)
    command = ["assimp", "export", str(path), str(out), "-fstlb", "-tri", "-ptv"]
    try:
        run = subprocess.run(command, capture_output=True, timeout=LIMIT_S, text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return "takes more than a minute"
    if run.returncode != 0 or not out.exists():
        return f"exit code {run.returncode}"
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    data = out.read_bytes()
    return shape_of(np.frombuffer(data, kind, offset=84, count=(len(data) - 84) // kind.itemsize)["corners"])


@dataclass
class Ours:
    """What raystep says."""

    shape: Shape | None
    """None if it reads nothing."""
    line: str
    """Its error, or its notes."""
    fault: str
    """What it must never do; empty if it does not."""


def run(binary: str, *words: str) -> tuple[int, str, str]:
    try:
        done = subprocess.run([binary, *words], capture_output=True, timeout=LIMIT_S, text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return 124, "", "takes more than a minute"
    return done.returncode, done.stdout, done.stderr.strip()


def by_raystep(binary: str, path: Path, folder: Path) -> Ours:
    code, out, error = run(binary, "info", str(path), "--json")
    picture = folder / "picture.png"
    picture.unlink(missing_ok=True)
    words = ["render", str(path), "--size", "32x32", "--device", "cpu", "--quiet", "-o", str(picture)]
    drawn, _, draw_error = run(binary, *words)
    fault = ""
    if code not in (0, 1) or drawn not in (0, 1):
        fault = f"exit codes {code} and {drawn}"
    elif code != drawn:
        fault = f"info ends with {code}, render with {drawn}: {draw_error}"
    elif drawn == 0 and not picture.exists():
        fault = "no picture"
    elif code == 1 and len(error.splitlines()) != 1:
        fault = "an error of more than one line"
    if code != 0:
        return Ours(None, error.removeprefix(f"error: {path}: "), fault)
    said = json.loads(out)
    said = said.get("scene", said)
    low, high = said["bounds_min"], said["bounds_max"]
    bounds = None if low is None else np.array([low, high], np.float64)
    return Ours(Shape(said["triangles"], bounds, said["area"]), "; ".join(said["notes"]), fault)


def known_reasons() -> list[tuple[str, str]]:
    """Patterns of paths and why their files may differ."""
    with open(Path(__file__).parent / "known.csv", newline="") as file:
        return [(row["file"], row["reason"]) for row in csv.DictReader(file)]


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--table", type=Path)
    parser.add_argument("folders", nargs="+", type=Path)
    options = parser.parse_args()
    known, rows, wrong = known_reasons(), [], 0
    files = sorted(
        (folder, path)
        for folder in options.folders
        for path in folder.rglob("*")
        if path.suffix.lower() in ENDINGS and path.is_file()
    )
    with tempfile.TemporaryDirectory() as name:
        for folder, path in files:
            shown = os.path.join(folder.name, path.relative_to(folder))
            ours = by_raystep(options.binary, path, Path(name))
            others = {"trimesh": by_trimesh(path), "assimp": by_assimp(path, Path(name))}
            mine = ours.shape or Shape(0, None, 0.0)
            verdicts = {
                reader: other if isinstance(other, str) else mine.differs(other) for reader, other in others.items()
            }
            # Where nobody reads anything, all agree.
            is_nothing = ours.shape is None and all(isinstance(other, str) for other in others.values())
            agrees = [reader for reader, verdict in verdicts.items() if verdict == "" or is_nothing]
            reason = next((reason for pattern, reason in known if fnmatch(shown, pattern)), "")
            is_wrong = bool(ours.fault) or not agrees and not reason
            wrong += is_wrong
            result = "WRONG" if is_wrong else "as " + " and ".join(agrees) if agrees else reason
            rows.append((shown, ours, verdicts, result))
            print(f"{'WRONG' if is_wrong else 'ok':5} {shown}: {mine.triangles} triangles; {result}; {verdicts}", flush=True)
            if is_wrong:
                print(f"      {ours.fault or ours.line}", file=sys.stderr)
    if options.table:
        options.table.write_text(table(rows))
    print(f"{len(rows)} files: {len(rows) - wrong} as expected, {wrong} wrong")
    return int(wrong > 0)


def table(rows: list[tuple[str, Ours, dict[str, str], str]]) -> str:
    """The results as Markdown: files by what agrees, folder by folder, then those on which not both others agree."""
    both = "as trimesh and assimp"
    folders = sorted({shown.split(os.sep)[0] for shown, *_ in rows})
    lines = [f"| folder | files | {both} | as one of them | for a reason | wrong |", "|---|---|---|---|---|---|"]
    for folder in [*folders, None]:
        results = [result for shown, _, _, result in rows if folder in (None, shown.split(os.sep)[0])]
        one, wrong = (sum(result.startswith(start) for result in results) for start in ("as ", "WRONG"))
        counts = [len(results), results.count(both), one - results.count(both), len(results) - one - wrong, wrong]
        lines.append(f"| {folder or 'all'} | {' | '.join(map(str, counts))} |")
    lines += ["", "| file | triangles | area | compared | notes, or why it is refused |", "|---|---|---|---|---|"]
    for shown, ours, _, result in rows:
        if result == both and ours.shape is not None:
            continue
        shape = ours.shape
        sizes = f"{shape.triangles:,} | {shape.area:.6g}" if shape else "refused | "
        # What every scene says that has neither.
        said = [note for note in ours.line.split("; ") if not note.startswith(("no camera in", "no lights in"))]
        lines.append(f"| {shown} | {sizes} | {result} | {'; '.join(said).replace('|', '/')} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
