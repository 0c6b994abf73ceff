"""Fits the cost formula of Purcell et al. (2002) to passes, and checks it in scenes that it was not fitted to.

    python3 fit.py FOLDER RUNS.csv

FOLDER has the passes of each run, SCENE,SIZE,PROGRAM,REPEAT.csv, written by `raystep render --spp 2 --passes-csv`: see
../purcell.md. The first sample compiles and warms up; the second is used, and of its repeats the median. RUNS.csv is written:
a row for each run, with what was measured and predicted.
"""

import csv
import statistics
import sys
from collections import defaultdict
from pathlib import Path

PARTS = {"generate": "r", "setup": "r", "traverse_grid": "v", "intersect": "t"}
LETTERS = "rvts"
PROGRAMS = ["local", "shadows", "whitted", "path"]


def part(kernel):
    """The part of the formula to which a kernel belongs; whatever is not a walk shades."""
    return PARTS.get(kernel.removeprefix("shadow_"), "s")


def read(folder):
    """Of each run: part, rays that the kernel worked on, threads launched, and ns of each pass."""
    files = defaultdict(list)
    for path in sorted(folder.glob("*,*,*,*.csv")):
        with path.open(newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["sample"] == "1" and row["kernel"] != "accumulate"]
        files[tuple(path.stem.split(",")[:3])].append(rows)
    runs = {}
    for run, repeats in files.items():
        passes = []
        for same in zip(*repeats, strict=True):
            first = same[0]
            assert all(row["rays_in"] == first["rays_in"] and row["valid"] == "true" for row in same), run
            ns = statistics.median(float(row["duration_ns"]) for row in same)
            passes.append((part(first["kernel"]), float(first["rays_in"]), float(first["threads_launched"]), ns))
        runs[run] = passes
    return runs


def terms(one, has_start):
    """What the constants are multiplied by: rays of each part, threads, and a pass's start."""
    letter, rays, threads, _ = one
    return [rays * (letter == other) for other in LETTERS] + [threads] + [1.0] * has_start


def solve(matrix, right):
    """Gauss-Jordan elimination with pivots."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for c in range(len(rows)):
        p = max(range(c, len(rows)), key=lambda r: abs(rows[r][c]))
        rows[c], rows[p] = rows[p], rows[c]
        for r in range(len(rows)):
            if r != c:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[c], strict=True)]
    return [row[-1] / row[i] for i, row in enumerate(rows)]


def least_squares(a, b):
    """Non-negative least squares (Lawson and Hanson 1974), by the normal equations of the few unknowns."""
    n = range(len(a[0]))
    gram = [[sum(row[i] * row[j] for row in a) for j in n] for i in n]
    right = [sum(row[i] * y for row, y in zip(a, b, strict=True)) for i in n]
    x, active = [0.0 for _ in n], []
    while True:
        slope = [right[i] - sum(gram[i][j] * x[j] for j in n) for i in n]
        free = [i for i in n if i not in active and slope[i] > 1e-9 * right[i]]
        if not free:
            return x
        active = sorted([*active, max(free, key=lambda i: slope[i] / gram[i][i] ** 0.5)])
        while True:
            found = solve([[gram[i][j] for j in active] for i in active], [right[i] for i in active])
            if min(found) > 0.0:
                break
            back = min(x[i] / (x[i] - v) for i, v in zip(active, found, strict=True) if v <= 0.0)
            for i, v in zip(active, found, strict=True):
                x[i] += back * (v - x[i])
            active = [i for i in active if x[i] > 1e-15]
        x = [0.0 for _ in n]
        for i, v in zip(active, found, strict=True):
            x[i] = v


def fitted(runs, has_start):
    """The constants, with every run of the same weight."""
    a, b = [], []
    for passes in runs.values():
        whole = sum(one[3] for one in passes)
        a.extend([value / whole for value in terms(one, has_start)] for one in passes)
        b.extend(one[3] / whole for one in passes)
    return least_squares(a, b)


def checked(runs, has_start):
    """Fits each half of the scenes, prints the constants, and predicts the runs of the other half."""
    scenes = sorted({run[0] for run in runs})
    predicted = {}
    for half in (scenes[0::2], scenes[1::2]):
        constants = fitted({run: passes for run, passes in runs.items() if run[0] in half}, has_start)
        text = ", ".join(f"C_{k} {1000 * v:.3g}" for k, v in zip([*LETTERS, "stencil"], constants, strict=False))
        print(f"  {', '.join(half)}: {text} ps" + (f", {constants[5] / 1000:.3g} µs a pass" if has_start else ""))
        for run, passes in runs.items():
            if run[0] not in half:
                each = (sum(u * v for u, v in zip(constants, terms(one, has_start), strict=True)) for one in passes)
                predicted[run] = sum(each)
    return predicted


def main():
    runs = read(Path(sys.argv[1]))
    whole = {run: sum(one[3] for one in passes) for run, passes in runs.items()}
    sizes = sorted({run[1] for run in runs}, key=lambda size: int(size.split("x")[0]))
    predictions = {}
    for has_start, some in [(False, [size]) for size in sizes] + [(False, sizes), (True, sizes)]:
        print(f"{' and '.join(some)}, {'with the start of a pass' if has_start else 'the formula as printed'}")
        of_these = {run: passes for run, passes in runs.items() if run[1] in some}
        predicted = checked(of_these, has_start)
        errors = sorted((abs(value / whole[run] - 1), run) for run, value in predicted.items())
        largest = ", ".join(errors[-1][1])
        print(f"  error: median {statistics.median(e for e, _ in errors):.1%}, largest {errors[-1][0]:.0%} ({largest})")
        if len(some) == 1:
            predictions |= predicted
    with Path(sys.argv[2]).open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        head = ["scene", "size", "program", "passes", "rays_r", "rays_v", "rays_t", "rays_s", "threads", "ns", "predicted_ns"]
        table.writerow(head)
        for run in sorted(runs, key=lambda run: (run[0], sizes.index(run[1]), PROGRAMS.index(run[2]))):
            sums = [round(sum(column)) for column in zip(*(terms(one, False) for one in runs[run]), strict=True)]
            table.writerow([*run, len(runs[run]), *sums, round(whole[run]), round(predictions[run])])


main()
