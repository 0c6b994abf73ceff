"""Sweeps on a local Ray cluster of two workers, one of which is killed, with the driver interrupted and started again:
python test_sweep.py FOLDER-OF-SCENES, in an environment with the wheel and Ray."""

from __future__ import annotations

import importlib
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
import uuid
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

import raystep
from raystep import OptionError, SweepError
from raystep import _sweep

SCENES = Path(sys.argv.pop() if len(sys.argv) > 1 else Path(__file__).parents[3] / "scenes").resolve()

SWEEP: dict[str, Any] = {
    "scenes": [str(SCENES / "cornell-box.gltf"), str(SCENES / "primitives.gltf")],
    "options": {"size": "16x16", "device": "cpu"},
    "each": {"accelerator": ["grid", "bvh"], "spp": list(range(1, 11))},
    "what": "render",
}

DRIVER = """
import json, sys
import ray, raystep
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
raystep.sweep(**json.loads(sys.argv[1]), on="ray", output=sys.argv[2])
"""

TIMES = ("trace_s", "job_s")


def start(folder: Path, token: str) -> subprocess.Popen[str]:
    """Starts the driver, as the leader of a group of processes, as a terminal does."""
    environment = {**os.environ, "RAYSTEP_TEST": token}
    return subprocess.Popen(
        [sys.executable, "-c", DRIVER, json.dumps(SWEEP), str(folder)],
        stderr=subprocess.PIPE, text=True, env=environment, start_new_session=True,
    )


def workers(token: str) -> list[int]:
    """The cluster's processes that run a job."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words, environment = (process / "cmdline").read_bytes(), (process / "environ").read_bytes()
        except OSError:
            continue
        if words.startswith(b"ray::_work") and f"RAYSTEP_TEST={token}".encode() in environment:
            found.append(int(process.name))
    return found


def finished(folder: Path) -> dict[str, bytes]:
    """The finished jobs, and how they ended."""
    return {file.parent.name: file.read_bytes() for file in folder.glob("jobs/*/job.json") if file.parent.name[0] != "."}


def wait(what: str, condition: Any, process: subprocess.Popen[str]) -> Any:
    end = time.monotonic() + 300
    while not (value := condition()):
        if process.poll() is not None or time.monotonic() > end:
            raise AssertionError(f"no {what}: {process.poll()} {process.stderr.read() if process.stderr else ''}")
        time.sleep(0.02)
    return value


def plain(rows: Any) -> list[dict[str, Any]]:
    """Rows without times."""
    rows = rows if isinstance(rows, list) else rows.to_dict("records")
    return [{name: value for name, value in row.items() if name not in TIMES} for row in rows]


class Sweep(unittest.TestCase):
    def test_a_lost_worker_and_an_interruption_cost_no_job(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder, token = Path(name, "ray"), uuid.uuid4().hex
            driver = start(folder, token)
            wait("finished jobs", lambda: len(finished(folder)) >= 3, driver)
            os.kill(wait("worker", lambda: workers(token), driver)[0], signal.SIGKILL)
            wait("finished jobs after the loss", lambda: len(finished(folder)) >= 12, driver)
            os.killpg(driver.pid, signal.SIGINT)
            _, first = driver.communicate(timeout=120)
            self.assertNotEqual(driver.returncode, 0)
            self.assertNotRegex(first, r"(?m)^failed: ")
            before = finished(folder)
            self.assertTrue(12 <= len(before) < 40, f"it was interrupted in the middle: {len(before)} {first}")

            driver = start(folder, token)
            _, second = driver.communicate(timeout=600)
            self.assertEqual(driver.returncode, 0, second)
            self.assertIn(f"{len(before)} of 40 jobs are finished already", second)
            after = finished(folder)
            self.assertEqual((len(after), {job: after[job] for job in before}), (40, before))
            ran = [re.findall(r"^\d+ of 40: ([^,]+),", text, re.MULTILINE) for text in (first, second)]
            # The last lines before the interruption may be lost, but never its results.
            self.assertEqual(sorted(ran[1]), sorted(set(after) - set(before)))
            self.assertTrue(set(ran[0]) <= set(before))
            self.assertEqual([path.name for path in folder.glob("jobs/.*")], [])

            here = raystep.sweep(**SWEEP, output=Path(name, "local"), quiet=True)
            there = raystep.sweep(**SWEEP, output=folder, quiet=True)
            self.assertEqual(len(plain(here)), 40)
            self.assertEqual(plain(there), plain(here))
            pictures = [{file.parent.name: file.read_bytes() for file in Path(name, of).glob("jobs/*/image.png")}
                        for of in ("ray", "local")]
            self.assertEqual(len(pictures[0]), 40)
            self.assertEqual(*pictures)

    def test_scenes_travel_with_their_files_and_jobs_that_measure_are_alone(self) -> None:
        ray: Any = importlib.import_module("ray")
        job: dict[str, Any] = {"inputs": [str(SCENES / "textures.gltf"), str(SCENES / "textures-данные.bin")], "is_timed": True,
               "needs_gpu": True}
        with tempfile.TemporaryDirectory() as folder:
            zipfile.ZipFile(io.BytesIO(_sweep._packed(job["inputs"]))).extractall(folder)
            self.assertEqual({p.name for p in Path(folder).iterdir()}, {"textures.gltf", "textures-данные.bin"})
        self.assertEqual(_sweep._hashes(["/nothing"]), [""])
        # A node's processors; the resource, where there is one; neither: shared.
        self.assertEqual(_sweep._how(dict(job), {"CPU": 8}, [{"CPU": 4}] * 2)["num_cpus"], 4)
        how = _sweep._how(dict(job), {"CPU": 9, "GPU": 2, _sweep.MACHINE: 2}, [{"CPU": 4}, {"CPU": 5}])
        self.assertEqual((how["num_cpus"], how["num_gpus"], how["resources"]), (1, 1, {_sweep.MACHINE: 1}))
        shared = dict(job)
        _sweep._how(shared, {"CPU": 9}, [{"CPU": 4}, {"CPU": 5}])
        self.assertTrue(shared["is_shared"])

        with tempfile.TemporaryDirectory() as name:
            ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
            hidden = _sweep._hashes
            try:
                # As if the workers had no such files.
                _sweep._hashes = lambda files: ["other"] * len(files)
                rows = raystep.sweep([SCENES / "textures.gltf"], {"sizes": "8x8", "repeats": 1, "device": "cpu"},
                                     what="bench", on="ray", output=Path(name, "bench"), quiet=True)
            finally:
                _sweep._hashes = hidden
                ray.shutdown()
            rows = plain(rows)
            self.assertEqual([(row["job"], row["adapter"], row["runs"]) for row in rows], [("textures", "cpu", 1)])
            self.assertIsInstance(rows[0]["is_shared"], bool)

    def test_files_travel_by_the_names_under_which_they_are_found(self) -> None:
        ray: Any = importlib.import_module("ray")
        with tempfile.TemporaryDirectory() as name:
            # A scene and its textures behind links, in a store whose files are as old as can be.
            store, models = Path(name, "models", "store"), Path(name, "models")
            store.mkdir(parents=True)
            for file in ("textures.gltf", "textures-данные.bin", "schach brett ü.png"):
                (store / f"x-{file}").write_bytes((SCENES / file).read_bytes())
                os.utime(store / f"x-{file}", (1, 1))
                (models / file).symlink_to(store / f"x-{file}")
            np.save(Path(name, "x.npy"), np.array([[0, 0, 5, 0, 0, -1]], np.float32))
            Path(name, "rays.npy").symlink_to("x.npy")
            here = os.getcwd()
            ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
            hidden = _sweep._hashes
            try:
                _sweep._hashes = lambda files: ["other"] * len(files)
                os.chdir(models)
                options: dict[str, Any] = {"rays_file": "../rays.npy", "repeats": 1, "device": "cpu"}
                rows = raystep.sweep("textures.gltf", options, what="bench", on="ray", output=Path(name, "out"), quiet=True)
            finally:
                os.chdir(here)
                _sweep._hashes = hidden
                ray.shutdown()
            self.assertEqual({(row["scene"], row["rays"]) for row in plain(rows)}, {("textures", 1)})

    def test_a_cluster_that_cannot_be_reached_is_named(self) -> None:
        with tempfile.TemporaryDirectory() as name, self.assertRaises(SweepError) as failed:
            raystep.sweep("cornell-box", on="ray", address="not an address", output=Path(name, "out"), quiet=True)
        self.assertRegex(str(failed.exception), r"\Acannot start or connect to the Ray cluster \(not an address\): .+\Z")

    def test_numbers_of_numpy_and_vectors_are_options(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            options = {"size": "8x8", "device": "cpu", "eye": np.array([0, 1, 4]), "look_at": (0, 0, 0)}
            rows = raystep.sweep("cornell-box", options, each={"fov": np.linspace(30, 60, 3), "spp": np.arange(1, 3)},
                                 output=Path(name, "out"), quiet=True)
            self.assertEqual([row["option_fov"] for row in plain(rows)], ["30.0", "30.0", "45.0", "45.0", "60.0", "60.0"])

    def test_values_are_the_same_in_toml(self) -> None:
        for value in ("a\x7fb", "\U0001f600 \u00fc", 'quote " and \\', "line\nfeed", True, -3, 2.5, 1e-30, ["a", 1, [False]]):
            self.assertEqual(tomllib.loads(f"value = {_sweep._toml(value)}")["value"], value)

    def test_what_is_wrong_is_said(self) -> None:
        box = SCENES / "cornell-box.gltf"
        with tempfile.TemporaryDirectory() as name:
            right: dict[str, Any] = {"scenes": box, "output": Path(name, "out"), "quiet": True}
            cases: list[tuple[dict[str, Any], str]] = [
                ({"on": "slurm"}, 'on=\'slurm\': expected "local" or "ray"'),
                ({"what": "trace"}, 'what = "trace": expected "bench"'),
                ({"options": {"szie": "1x1"}}, "options.szie: raystep render has no option --szie; did you mean size?"),
                ({"options": {"size": object()}}, "expected text, a number"),
                ({"options": {"szie": 1}, "on": "ray"}, "options.szie: raystep render has no option --szie"),
                ({"scenes": "none*.glb"}, "matches no file"),
            ]
            for wrong, message in cases:
                with self.assertRaises(OptionError) as raised:
                    raystep.sweep(**(right | wrong))
                self.assertIn(message, str(raised.exception))
                self.assertFalse(Path(name, "out").exists())
            with self.assertRaises(SweepError) as failed:
                raystep.sweep(box, {"size": "8x8", "device": "cpu"}, each={"camera": [0, 7]}, output=Path(name, "out"), quiet=True)
            self.assertIn("job cornell-box-camera-7: --camera 7: the scene has one camera", str(failed.exception))
            self.assertEqual(len(plain(failed.exception.rows)), 1)


if __name__ == "__main__":
    # A shell ignores interrupts for what it runs in the background, and so would Python.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    unittest.main()
