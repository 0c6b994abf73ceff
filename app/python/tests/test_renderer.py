"""Runs: the command's results, in any order of steps. Run by tests/python.sh in a clean environment with the wheel."""

import csv
import doctest
import io
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from typing import Any
from unittest import mock

import numpy as np

import raystep
from raystep import OptionError, Renderer, Scene, SceneError
from raystep._progress import Watched
from raystep._tables import Table, table_of_csv

SMALL: dict[str, Any] = {"size": (32, 24), "device": "cpu"}


def command(*arguments: str) -> str:
    """Output of the command."""
    ran = subprocess.run([sys.executable, "-m", "raystep", *arguments], capture_output=True, text=True, check=True)
    return ran.stdout


def everything(run: Renderer) -> dict[str, Any]:
    """All streams, as bits."""
    return {name: np.ascontiguousarray(values).view(np.uint32) for name, values in run.streams.items()}


def rows(table: Any) -> list[dict[str, Any]]:
    """Rows, with pandas or without; missing values are None."""
    if isinstance(table, Table):
        return list(table)
    known = table.astype(object).where(table.notna(), None)
    return [dict(row) for row in known.to_dict("records")]


def shown(value: Any) -> Any:
    """What a notebook shows."""
    return value._repr_html_() if hasattr(value, "_repr_html_") else value._repr_png_()


class Run(unittest.TestCase):
    def same(self, a: dict[str, Any], b: dict[str, Any]) -> None:
        self.assertEqual(list(a), list(b))
        for name in a:
            self.assertTrue(np.array_equal(a[name], b[name]), name)

    def test_a_program_of_ones_own_is_stepped_from_an_array(self) -> None:
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place) / "mine"
            command("new", str(folder), "--like", "life")
            text = (folder / "program.toml").read_text().replace("[256, 256]", "[6, 5]")
            (folder / "program.toml").write_text(text.replace('{ run = "seed" },', ""))
            start = np.zeros((5, 6), np.uint32)
            start[2, 1:4] = 1
            run = raystep.Program(folder, starts={"cell": start})
            self.assertTrue(np.array_equal(run.result, start))
            run.step()
            turned = np.zeros((5, 6), np.uint32)
            turned[1:4, 2] = 1
            self.assertTrue(np.array_equal(run.result, turned))
            self.assertEqual(run.streams["cell"].shape, (5, 6, 1))
            run.back()
            self.assertTrue(np.array_equal(run.result, start))
            for starts, message in [({"cells": start}, "no stream is named cells"), ({"cell": start[1:]}, "shape")]:
                with self.assertRaisesRegex(SceneError, message):
                    raystep.Program(folder, starts=starts)
            command("new", str(folder / "walk"), "--like", "grid-walk")
            rays = raystep.Program(folder / "walk", "teapot", size=(20, 10))
            rays.run()
            self.assertEqual(rays.result.shape, (10, 20, 3))
            self.assertGreater(float(rays.result.max()), 0.3)

    def test_scenes_that_come_along_open_by_name(self) -> None:
        for name in raystep.scene_names():
            self.assertGreater(Scene(name, device="cpu").triangles, 0, name)
        with tempfile.TemporaryDirectory() as folder:
            here = os.getcwd()
            os.chdir(folder)
            try:
                picture = os.path.join(folder, "c.png")
                command("render", "cornell-box", "-o", picture, "--size", "8x8", "--device", "cpu")
                self.assertTrue(os.path.exists(picture))
                with self.assertRaisesRegex(SceneError, "teapt: no such file.*did you mean teapot.*cornell-box"):
                    Scene("teapt")
                # A file comes first.
                os.mkdir("teapot")
                with self.assertRaisesRegex(SceneError, "it is a folder"):
                    Scene("teapot")
            finally:
                os.chdir(here)

    def test_streams_are_those_that_the_command_dumps(self) -> None:
        run = Renderer("cornell-box", steps_per_pass=1, **SMALL).step_to(5)
        with tempfile.TemporaryDirectory() as folder:
            command("dump", "cornell-box", "--pass", "4", "-o", f"{folder}/d", "--size", "32x24", "--device", "cpu")
            for name, values in run.streams.items():
                dumped = np.moveaxis(np.load(f"{folder}/d/pass-000004.{name}.npy"), 0, 2)
                self.assertEqual(dumped.dtype, values.dtype)
                self.assertTrue(np.array_equal(dumped.view(np.uint32), np.asarray(values).view(np.uint32)), name)
                for index, component in enumerate(values.components):
                    bits = values.component(component).view(np.uint32)
                    self.assertTrue(np.array_equal(dumped[..., index].view(np.uint32), bits), component)
            self.assertEqual(len(run.streams), len(os.listdir(f"{folder}/d")) - 1)

    def test_the_picture_is_that_of_the_command(self) -> None:
        image = Renderer("textures", spp=3, seed=5, accelerator="bvh", **SMALL).run().image()
        with tempfile.TemporaryDirectory() as folder:
            options = "--spp 3 --seed 5 --accelerator bvh --size 32x24 --device cpu".split()
            command("render", "textures", "-o", f"{folder}/t.png", *options)
            with open(f"{folder}/t.png", "rb") as file:
                self.assertEqual(file.read(), image.png())
            image.save(f"{folder}/u.png")
            self.assertEqual(os.path.getsize(f"{folder}/u.png"), os.path.getsize(f"{folder}/t.png"))

    def test_a_picture_with_shadows_is_that_of_the_command(self) -> None:
        lit = Renderer("lights", integrator="shadows", **SMALL).run()
        local = Renderer("lights", **SMALL).run()
        color, everywhere = (np.asarray(run.streams["color"]) for run in (lit, local))
        darker = (color < everywhere).any(axis=2)
        self.assertTrue((color <= everywhere * (1 + 1e-6)).all(), "shadows take light away")
        self.assertTrue(20 < darker.sum() < darker.size, f"{darker.sum()} of {darker.size} pixels are darker")
        self.assertTrue(any(row["kernel"].startswith("shadow") for row in rows(lit.timings())))
        words = "--integrator shadows --size 32x24 --device cpu".split()
        with tempfile.TemporaryDirectory() as folder:
            command("render", "lights", "-o", f"{folder}/l.png", *words)
            with open(f"{folder}/l.png", "rb") as file:
                self.assertEqual(file.read(), lit.image().png())
            command("dump", "lights", "--pass", "last", "-o", f"{folder}/d", *words)
            (name,) = (name for name in os.listdir(f"{folder}/d") if name.endswith(".color.npy"))
            dumped = np.moveaxis(np.load(f"{folder}/d/{name}"), 0, 2)
            self.assertTrue(np.array_equal(dumped.view(np.uint32), color.view(np.uint32)))

    def test_paths_have_the_options_of_the_command(self) -> None:
        words = "--integrator path --max-depth 2 --strategy light --spp 2 --size 32x24 --device cpu".split()
        path = Renderer("cornell-box", integrator="path", max_depth=2, strategy="light", spp=2, **SMALL).run()
        with tempfile.TemporaryDirectory() as folder:
            command("render", "cornell-box", "-o", f"{folder}/p.png", *words)
            with open(f"{folder}/p.png", "rb") as file:
                self.assertEqual(file.read(), path.image().png())
        with self.assertRaisesRegex(OptionError, "at most 8 with --integrator whitted"):
            Renderer("cornell-box", integrator="whitted", max_depth=9, **SMALL)

    def test_photons_have_the_options_and_sets_of_the_command(self) -> None:
        words = "--integrator photons --photons 100 --photon-map bitonic --nearest 9 --size 32x24 --device cpu".split()
        run = Renderer(
            "cornell-box", integrator="photons", photons=100, photon_map="bitonic", nearest=9, **SMALL
        ).run()
        # Elements that are no pixels are a row: whole rows of the texture have 16.
        self.assertEqual(run.streams["photon_bounce"].shape[0], 112)
        self.assertEqual(run.streams["photon_key"].shape[0] % 112, 0)
        with tempfile.TemporaryDirectory() as folder:
            command("render", "cornell-box", "-o", f"{folder}/p.png", *words)
            with open(f"{folder}/p.png", "rb") as file:
                self.assertEqual(file.read(), run.image().png())
        with self.assertRaisesRegex(OptionError, "--photons 100 applies to --integrator photons, not to path"):
            Renderer("cornell-box", integrator="path", photons=100, **SMALL)

    def test_a_kernel_of_ones_own_runs_in_place_of_the_built_in_one(self) -> None:
        kernels = pathlib.Path(__file__).parents[3] / "kernels/src/programs/closest_hit"
        own = Renderer("cornell-box", kernel=[kernels / "intersect.wgsl", f"setup={kernels / 'setup.wgsl'}"], **SMALL)
        run = Renderer("cornell-box", steps_per_pass=1, **SMALL).run()
        self.assertEqual(own.run().image().png(), run.image().png())
        with tempfile.TemporaryDirectory() as folder:
            wrong = pathlib.Path(folder, "wrong.wgsl")
            text = (kernels / "intersect.wgsl").read_text()
            wrong.write_text(text.replace("item += 1u", "item += one"))
            line = text[: text.index("item += 1u")].count("\n") + 1
            with self.assertRaisesRegex(SceneError, f"wrong.wgsl:{line}:17: no definition in scope"):
                Renderer("cornell-box", kernel=wrong, **SMALL)

    def test_steps_forwards_and_backwards_pass_the_same_places(self) -> None:
        scene = Scene("teapot", device="cpu")
        run = Renderer(scene, size=(24, 16), schedule="second")
        places = [everything(run)]
        passes = []
        for pass_ in run:
            passes.append(pass_)
            places.append(everything(run))
        self.assertTrue(run.is_complete)
        self.assertIsNone(run.step())
        self.assertEqual([pass_.index for pass_ in passes], list(range(len(passes))))
        self.assertEqual(sum(passes[-1].states.values()), 24 * 16)
        for place in range(len(passes) - 1, -1, -1):
            back = run.back()
            self.assertEqual(back, passes[place - 1] if place else None)
            self.same(everything(run), places[place])
        self.assertIsNone(run.back())
        for place in [7, 3, len(passes), 0, 12, 11]:
            self.assertEqual(run.step_to(place).pass_count, place)
            self.same(everything(run), places[place])

    def test_a_ray_has_the_history_that_the_command_prints(self) -> None:
        run = Renderer("cornell-box", steps_per_pass=1, **SMALL).step_to(3)
        before = everything(run)
        found = rows(run.history(17, 12))
        text = command("trace", "cornell-box", "--pixel", "17,12", "--format", "csv", "--size", "32x24", "--device", "cpu")
        wanted = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual([row["why"] for row in found], [row["why"] for row in wanted])
        self.assertEqual([str(row["triangle_after"]) for row in found if row["triangle_after"] is not None][-1], wanted[-1]["triangle_after"])
        self.same(everything(run), before)
        self.assertEqual(run.pass_count, 3)

    def test_plan_and_timings_are_those_of_the_command(self) -> None:
        run = Renderer("cornell-box", timings=True, **SMALL)
        self.assertEqual(run.plan().data, json.loads(command("plan", "cornell-box", "--json", "--size", "32x24", "--device", "cpu")))
        self.assertEqual(str(run.plan()), command("plan", "cornell-box", "--size", "32x24", "--device", "cpu"))
        timed = rows(run.run().timings())
        self.assertEqual(len(timed), run.pass_count)
        for row in timed:
            self.assertEqual((row["clock"], row["scene"], row["valid"]), ("cpu_clock", "cornell-box", True))
            self.assertGreater(row["duration_ns"], 0)
        untimed = rows(Renderer("cornell-box", **SMALL).run().timings())
        self.assertEqual({row["duration_ns"] for row in untimed}, {None})

    def test_timings_have_what_each_pass_counted(self) -> None:
        run = Renderer("cornell-box", counters=True, spp=3, **SMALL).run()
        counted = rows(run.timings())
        self.assertEqual({row["sample"] for row in counted}, {0, 1, 2})
        last = [row for row in counted if row["sample"] == 2]
        stream = np.asarray(run.streams["counters"])
        self.assertEqual(sum(row["cells_visited"] for row in last), int(stream[..., 0].sum()))
        self.assertEqual(sum(row["triangles_tested"] for row in last), int(stream[..., 1].sum()))
        before = rows(run.step_to(5).timings())
        self.assertEqual([row["triangles_tested"] for row in before], [row["triangles_tested"] for row in counted[:5]])
        self.assertEqual({row["cells_visited"] for row in rows(Renderer("cornell-box", **SMALL).run().timings())}, {None})

    def test_progress_is_told_and_an_exception_in_it_ends_the_call(self) -> None:
        told: list[raystep.Progress] = []
        run = Renderer("cornell-box", size=(200, 150), spp=8, device="cpu")
        run.run(progress=told.append)
        self.assertEqual((told[-1].samples, told[-1].done), (8, 1.0))
        self.assertEqual([now.passes for now in told], sorted(now.passes for now in told))
        image = run.image()

        def stop(now: raystep.Progress) -> None:
            raise ZeroDivisionError(now.passes)

        run.step_to(0)
        with self.assertRaises(ZeroDivisionError):
            run.run(progress=stop)
        self.assertFalse(run.is_complete)
        with self.assertRaisesRegex(RuntimeError, "callback cannot use the renderer"):
            run.run(progress=lambda now: run.pass_count)
        self.assertTrue(np.array_equal(run.run().image(), image))
        with Watched(True) as call:
            assert call is not None
            call(1, 2, 3, 0, 1)

    def test_an_interrupt_ends_a_run_that_can_go_on(self) -> None:
        run = Renderer("sphere-flake", size=(640, 480), spp=4096, device="cpu")
        timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            run.run()
        # A pass is far shorter.
        self.assertLess(time.monotonic() - begin, 20)
        here = run.pass_count
        self.assertGreater(here, 0)
        self.assertEqual(run.step_to(here + 2).pass_count, here + 2)

    def test_an_exception_in_the_callback_ends_a_comparison(self) -> None:
        a, b = (Renderer("sphere-flake", size=(640, 480), spp=4096, device="cpu") for _ in range(2))
        begin = time.monotonic()

        def stop(now: raystep.Progress) -> None:
            raise ZeroDivisionError(now.passes)

        with self.assertRaises(ZeroDivisionError):
            raystep.compare(a, b, progress=stop)
        # Two samples take a second, all of them an hour.
        self.assertLess(time.monotonic() - begin, 20)

    def test_who_waits_for_a_turn_can_be_interrupted(self) -> None:
        run = Renderer("sphere-flake", size=(640, 480), spp=4096, device="cpu")
        is_over, began = threading.Event(), threading.Event()

        def tell(now: raystep.Progress) -> None:
            began.set()
            if is_over.is_set():
                raise ZeroDivisionError

        def work() -> None:
            with self.assertRaises(ZeroDivisionError):
                run.run(progress=tell)

        worker = threading.Thread(target=work)
        worker.start()
        self.assertTrue(began.wait(60))
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            run.image()
        is_over.set()
        worker.join(60)
        self.assertFalse(worker.is_alive())

    def test_other_threads_run_meanwhile_and_calls_take_turns(self) -> None:
        run = Renderer("teapot", size=(320, 240), spp=16, device="cpu")
        worker = threading.Thread(target=run.run)
        worker.start()
        counted = 0
        while worker.is_alive():
            counted += 1
        self.assertGreater(counted, 1000)
        self.assertTrue(run.is_complete)
        run = Renderer("cornell-box", **SMALL)
        seen: list[int] = []

        def steps() -> None:
            while (pass_ := run.step()) is not None:
                seen.append(pass_.index)

        threads = [threading.Thread(target=steps) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(seen), list(range(run.pass_count)))
        self.assertTrue(run.is_complete)

    def test_what_is_wrong_is_said(self) -> None:
        scene = Scene("cornell-box", device="cpu")
        run = Renderer(scene, size=(8, 6))
        cases: list[tuple[Any, str]] = [
            (lambda: Renderer(scene, accelerator="tree"), "--accelerator tree: expected auto, grid, irregular, bvh or none"),
            (lambda: Renderer(scene, size=(8, -1)), "--size 8x-1: expected 1 to 32768 pixels per side"),
            (lambda: Renderer(scene, size=512), "size 512: expected width and height"),  # type: ignore[arg-type]
            (lambda: Renderer(scene, fov=np.array(40.0)), "--fov requires --eye"),  # type: ignore[arg-type]
            (lambda: Renderer(scene, width=8), "width requires height as well"),
            (lambda: Renderer(scene, size="8x8", width=8, height=8), "size cannot be combined with width and height"),
            (lambda: Renderer(scene, eye=(0, 0, 1)), "--eye requires --look-at"),
            (lambda: Renderer(scene, eye=(0, 0), look_at=(0, 0, 0)), "--eye 0,0: expected three numbers"),
            (lambda: Renderer(scene, seed=3), "--seed requires several samples per pixel"),
            (lambda: Renderer(scene, grid=3, accelerator="bvh"), "--grid applies to a uniform grid"),
            (lambda: Renderer(scene, mapping="fragment"), "--mapping fragment draws on a GPU"),
            (lambda: Renderer(scene, device="cpu"), "device and adapter are already set by the Scene"),
            (lambda: Renderer(scene, fov=object()), "--fov: expected a string, a number or a sequence of these, not object"),  # type: ignore[arg-type]
            (lambda: Renderer(scene, camera=9), "--camera 9: the scene has one camera, number 0"),
            (lambda: run.step_to(-1), "passes -1: expected an integer of at least 0"),
            (lambda: run.history(8, 0), "pixel 8,0: the image has pixels 0,0 to 7,5"),
            (lambda: run.history(-1, 0), "pixel -1,0: expected two integers of at least 0"),
            (lambda: Renderer(scene, schedule="fused", size="8x8").history(0, 0), "--schedule fused traces a ray in one pass"),
            (lambda: run.streams["state"].component("x"), "state has no component 'x'"),
            (lambda: raystep.compare(run, Renderer(scene, size=(9, 6))), "8x6 cannot be compared with one of 9x6"),
            (lambda: raystep.stability("no such case"), "--case no such case: no case has this in its name"),
            (lambda: raystep.report("cornell-box", section="none"), "--section none: expected"),
        ]
        for wrong, message in cases:
            with self.assertRaisesRegex(OptionError, message):
                wrong()
        with self.assertRaises(KeyError):
            run.streams["nothing"]
        with self.assertRaisesRegex(SceneError, "missing.glb: No such file"):
            raystep.report("missing.glb", device="cpu")
        with self.assertRaisesRegex(SceneError, "missing.glb: No such file"):
            Renderer("missing.glb")

    def test_runs_are_compared(self) -> None:
        options: dict[str, Any] = {"size": (32, 24), "steps_per_pass": 1}
        scene = Scene("teapot", device="cpu")
        base = Renderer(scene, **options).step_to(3)
        same = raystep.compare(base, Renderer(scene, **options))
        self.assertEqual((rows(same["first"]), base.pass_count), ([], 3))
        self.assertIn("passes agree", same.text)
        self.assertEqual({row["rays"] for row in rows(same["streams"])}, {0})
        # Another camera: even the first rays differ.
        moved = raystep.compare(base, Renderer(scene, eye=(9, 9, 9), look_at=(0, 0, 0), **options))
        first = rows(moved["first"])[0]
        self.assertEqual((first["pass"], first["kernel"]), (0, "generate"))
        ours, theirs = base.step_to(1), Renderer(scene, eye=(9, 9, 9), look_at=(0, 0, 0), **options).step_to(1)
        for run, key in ((ours, "a"), (theirs, "b")):
            value = run.streams[first["stream"]].component(first["component"])[first["y"], first["x"]]
            self.assertAlmostEqual(float(value), first[key], places=6)
        # Another structure: other passes, the same hits but for ties.
        trees = raystep.compare(base, Renderer(scene, accelerator="bvh", **options))
        [counts] = rows(trees["runs"])
        self.assertLess(counts["other_triangle_rays"] + counts["hit_or_miss_rays"], 5)
        self.assertIn("differ", trees.text)

    def test_commands_return_their_tables(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            found = raystep.stability("axis", quick=True, accelerator="bvh", device="cpu", output=f"{folder}/s")
            with open(f"{folder}/s/stability.csv", newline="") as file:
                wanted = list(csv.DictReader(file))
            self.assertEqual(len(rows(found["stability"])), len(wanted))
            self.assertEqual({row["case"] for row in rows(found["stability"])}, {row["case"] for row in wanted})
            self.assertIsNone(found.failure)
            self.assertEqual(os.listdir(folder), ["s"])
            with self.assertRaisesRegex(raystep.DeviceError, "not empty"):
                raystep.stability("axis", quick=True, device="cpu", output=f"{folder}/s")

    def test_columns_have_types(self) -> None:
        read = rows(table_of_csv('a,b,c,d\r\n1,0.5,true,"x, y"\r\n,2,,\r\n'))
        wanted = [{"a": 1, "b": 0.5, "c": True, "d": "x, y"}, {"a": None, "b": 2.0, "c": None, "d": None}]
        self.assertEqual(read, wanted)
        self.assertEqual([type(value) for value in read[0].values()], [int, float, bool, str])

    def test_numbers_that_json_does_not_have_come_back(self) -> None:
        row = {"pass": 1, "kernel": "setup", "a": "NaN", "b": "-inf", "max_ulps": 3}
        found = {"runs": [{"passes_a": 2, "passes_b": 2, "compared_passes": 2}], "first": [row],
                 "streams": [{"stream": "tmax", "max_difference": "inf", "first_x": None}]}
        run = Renderer("cornell-box", **SMALL)
        with mock.patch("raystep._raystep.compare", return_value=json.dumps(found)):
            tables = raystep.compare(run, run)
        first, streams = rows(tables["first"])[0], rows(tables["streams"])[0]
        # pandas has no other value for what is missing.
        self.assertTrue(first["a"] is None or math.isnan(first["a"]))
        self.assertEqual((first["b"], first["kernel"], streams["max_difference"]), (-math.inf, "setup", math.inf))

    def test_arrays_show_themselves_as_long_as_they_are_whole(self) -> None:
        run = Renderer("cornell-box", counters=True, **SMALL).run()
        hit: Any = run.streams["hit"]
        self.assertEqual(hit[:].component("t" if "t" in hit.components else "u").shape, hit.shape[:2])
        for part in (hit[..., ::-1], hit[..., [2, 1, 0]], hit[::-1], hit + 1, hit[:4]):
            self.assertEqual((part.components, part.stream, shown(part)), ((), "", None))
        for name, stream in run.streams.items():
            page = shown(stream)
            self.assertEqual(page.count("data:image/png"), len(stream.components) + (name == "color"), name)
        # Triangles have no order, and so no scale.
        self.assertEqual(shown(run.streams["hit"]).count("linear-gradient"), 2)
        counted = run.streams["counters"]
        page = shown(counted)
        for name, figure in zip(counted.components, page.split("<figure")[1:]):
            values = counted.component(name)
            self.assertIn(f"counters.{name}<br>{float(values.min()):.5g} <span", figure)
            self.assertIn(f"</span> {float(values.max()):.5g}", figure)
        self.assertIsNone(shown(counted[..., 0]))
        self.assertIsNone(shown(counted + 1.5))
        self.assertIsNone(shown(run.image()[..., 0]))
        self.assertEqual(shown(run.image())[:4], b"\x89PNG")
        self.assertIn("<td>&lt;</td>", shown(Table([{"a": "<", "b": None}])))

    def test_every_public_name_has_an_example_that_holds(self) -> None:
        finder, runner = doctest.DocTestFinder(exclude_empty=False), doctest.DocTestRunner()
        for name in raystep.__all__:
            value = getattr(raystep, name)
            if not callable(value):
                continue
            for test in finder.find(value, name, module=False, globs={**vars(raystep), "np": np}):
                if not test.name.rpartition(".")[2].startswith("_"):
                    self.assertTrue(test.examples, f"{test.name} has no example")
                runner.run(test)
        self.assertEqual(runner.summarize().failed, 0)


if __name__ == "__main__":
    # A shell ignores interrupts for what it runs in the background, and so would Python.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    unittest.main()
