"""Casts: right hits, or a clear exception. Run by tests/python.sh in a clean environment with the wheel."""

import doctest
import os
import resource
import signal
import threading
import time
import unittest
import warnings
from typing import Any

import numpy as np

import raystep
from raystep import DeviceError, OptionError, Scene, SceneError

TRIANGLE = [[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]


def soup(count: int, seed: int = 1) -> Any:
    """Triangles about a unit cube."""
    random = np.random.default_rng(seed)
    return (random.random((count, 1, 3)) + 0.2 * random.random((count, 3, 3))).astype(np.float32)


def brute_force(triangles: Any, origin: Any, direction: Any) -> tuple[float, int]:
    """Möller and Trumbore (1997) in f64."""
    a, b, c = triangles.astype(np.float64).transpose(1, 0, 2)
    p = np.cross(direction, c - a)
    determinant = np.einsum("ij,ij->i", b - a, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("ij,ij->i", origin - a, p) / determinant
        q = np.cross(origin - a, b - a)
        v = q @ direction / determinant
        t = np.einsum("ij,ij->i", c - a, q) / determinant
    t[~((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0))] = np.inf
    nearest = int(np.argmin(t))
    return float(t[nearest]), nearest


class Cast(unittest.TestCase):
    def test_hits_are_those_of_brute_force(self) -> None:
        triangles, random = soup(500), np.random.default_rng(2)
        origins = random.random((300, 3)).astype(np.float32) * 3 - 1
        directions = random.random((300, 3)).astype(np.float32) - origins
        hits = Scene(triangles=triangles, device="cpu").cast(origins, directions)
        some = 0
        for ray in range(300):
            t, triangle = brute_force(triangles, origins[ray].astype(float), directions[ray].astype(float))
            self.assertEqual(bool(hits.is_hit[ray]), np.isfinite(t), ray)
            if np.isfinite(t):
                self.assertEqual(hits.triangle[ray], triangle)
                # A float has 24 bits; the test cancels some of them.
                self.assertAlmostEqual(float(hits.t[ray]) / t, 1.0, delta=1e-4)
                some += 1
        self.assertGreater(some, 150)

    def test_intervals_end_rays(self) -> None:
        scene = Scene(triangles=TRIANGLE, device="cpu")
        down = ([[0, 0, 3]] * 3, [[0, 0, -2]] * 3)
        self.assertEqual(list(scene.cast(*down, t_min=[0, 1.5, 2]).is_hit), [True, False, False])
        self.assertEqual(list(scene.cast(*down, t_max=[1, 1.5, 2]).is_hit), [False, False, True])
        self.assertEqual(list(scene.cast(*down, t_max=[1, 1.5, 2], any_hit=True).is_hit), [False, False, True])

    def test_all_hits_enter_closed_surfaces_as_often_as_they_leave_them(self) -> None:
        corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], np.float32)
        faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        box = corners[[ids for a, b, c, d in faces for ids in ([a, b, c], [a, c, d])]]
        targets = np.array([[x, y, z] for x in (0, 0.5, 1) for y in (0, 0.5, 1) for z in (0, 0.5, 1)], np.float32)
        starts = np.array([[3, 3, 3], [3, 0, 0], [2, 0.5, 0.5], [-1, -1, 2], [0.5, 0.5, -4]], np.float32)
        origins, aims = np.repeat(starts, 27, 0), np.tile(targets, (5, 1))
        for device in ("cpu", "gpu"):
            hits = Scene(triangles=box, device=device).cast(origins, aims - origins, all_hits=True)
            assert hits.ray is not None
            counts = np.bincount(hits.ray.astype(np.int64), minlength=135)
            self.assertEqual(set(counts), {0, 2}, device)
            self.assertTrue(np.all(np.diff(hits.ray.astype(np.int64)) >= 0))
            self.assertTrue(np.all(hits.t[0::2] <= hits.t[1::2]))
        self.assertIsNone(Scene(triangles=box, device="cpu").cast(origins, aims - origins).ray)

    def test_arrays_of_any_layout_are_read_right(self) -> None:
        scene = Scene(triangles=TRIANGLE, device="cpu")
        origins = np.array([[0, 0, 3], [9, 9, 3]], np.float32)
        directions = np.array([[0, 0, -1]] * 2, np.float32)
        fixed = origins.copy()
        fixed.flags.writeable = False
        wide = np.zeros((2, 6), np.float32)
        wide[:, ::2] = origins
        unaligned = np.frombuffer(b"." + origins.tobytes(), np.uint8)[1:].view(np.float32).reshape(2, 3)
        self.assertFalse(unaligned.flags.aligned)
        for other in [fixed, wide[:, ::2], np.asfortranarray(origins), origins.astype(">f4"), origins.astype(np.float64),
                      origins.astype(np.int64), origins[::-1][::-1], origins.tolist(), unaligned]:
            self.assertEqual(list(scene.cast(other, directions).is_hit), [True, False])
        self.assertEqual(len(scene.cast([], [])), 0)
        self.assertEqual(len(scene.cast(np.empty((0, 3)), np.empty((0, 3)))), 0)
        with np.errstate(all="raise"):
            self.assertTrue(scene.cast([[0, 1e-50, 3]], [[0, 0, -1]]).is_hit[0])

    def test_what_is_wrong_is_said(self) -> None:
        scene = Scene(triangles=TRIANGLE, device="cpu")
        rays = ([[0, 0, 3]], [[0, 0, -1]])
        cases: list[tuple[Any, str]] = [
            (lambda: scene.cast([0, 0, 3], [0, 0, -1]), r"origins: expected numbers of shape \(N, 3\), not \(3,\)"),
            (lambda: scene.cast(rays[0], [[0, 0]]), r"directions: expected numbers of shape \(N, 3\)"),
            (lambda: scene.cast(rays[0] * 2, rays[1]), "expected equal lengths, not 2 and 1"),
            (lambda: scene.cast([["a", "b", "c"]], rays[1]), "origins: expected numbers"),
            (lambda: scene.cast([[1j, 0, 0]], rays[1]), "origins: expected numbers .* not complex128"),
            (lambda: scene.cast([[0, 0], [0]], rays[1]), "origins: expected numbers"),
            (lambda: scene.cast(np.empty((5, 0)), np.empty((5, 0))), r"origins: expected .* not \(5, 0\)"),
            (lambda: scene.cast(np.ma.masked_equal(rays[0], 3), rays[1]), "origins: expected an array without a mask"),
            (lambda: scene.cast(*rays, t_min=[1, [2, 3]]), "t_min: expected numbers"),  # type: ignore[arg-type]
            (lambda: scene.cast(*rays, t_min=[0, 0]), "t_min: expected 1 or 1 numbers, not 2"),
            (lambda: scene.cast(*rays, t_min=2, t_max=1), "ray 0 cannot be traced: its t_max is below its t_min"),
            (lambda: scene.cast(*rays, any_hit=True, all_hits=True), "any_hit and all_hits exclude each other"),
            (lambda: scene.cast(*rays, t_max=np.nan), "ray 0 cannot be traced"),
            (lambda: scene.cast([[0, 0, 3]] * 2, [[0, 0, -1], [0, 0, 0]]), "ray 1 cannot be traced: its direction is 0"),
            (lambda: scene.cast([[1e300, 0, 0]], rays[1]), "ray 0 cannot be traced: a component is not finite"),
            (lambda: Scene(), "expected either a file or triangles"),
            (lambda: Scene(triangles=TRIANGLE, device="tpu"), '--device tpu: expected auto, gpu or cpu'),
            (lambda: Scene(triangles=[[1, 2, 3]]), r"triangles: expected numbers of shape \(N, 3, 3\)"),
        ]
        for wrong, message in cases:
            with self.assertRaisesRegex(OptionError, message):
                wrong()
        with self.assertRaisesRegex(SceneError, "nothing.glb: No such file"):
            Scene("nothing.glb")
        with self.assertRaisesRegex(SceneError, "triangles: a coordinate is not finite"):
            Scene(triangles=np.full((1, 3, 3), np.nan))
        # It goes on after all of these.
        self.assertTrue(scene.cast(*rays).is_hit[0])

    @unittest.skipUnless(hasattr(os, "fork"), "no processes are forked")
    def test_a_forked_process_says_that_it_cannot(self) -> None:
        scene = Scene(triangles=soup(100), device="cpu")
        rays = (np.full((20_000, 3), 9, np.float32), np.ones((20_000, 3), np.float32))
        scene.cast(*rays)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if child == 0:
            try:
                scene.cast(*rays)
            except DeviceError as error:
                os._exit(17 if "spawn" in str(error) else 1)
            os._exit(2)
        end = time.monotonic() + 60
        while (ended := os.waitpid(child, os.WNOHANG)) == (0, 0) and time.monotonic() < end:
            time.sleep(0.01)
        if ended == (0, 0):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        self.assertEqual(os.waitstatus_to_exitcode(ended[1]) if ended != (0, 0) else "it hangs", 17)
        self.assertEqual(len(scene.cast(*rays)), 20_000)

    def test_threads_get_the_same_hits(self) -> None:
        scene = Scene(triangles=soup(2000), device="cpu")
        random = np.random.default_rng(3)
        origins, directions = random.random((2, 5000, 3)).astype(np.float32)
        wanted = scene.cast(origins, directions).records
        found: list[Any] = [None] * 8

        def work(thread: int) -> None:
            found[thread] = scene.cast(origins, directions).records

        threads = [threading.Thread(target=work, args=(thread,)) for thread in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for records in found:
            self.assertTrue(np.array_equal(records, wanted))

    def test_scenes_that_are_dropped_leave_no_memory_behind(self) -> None:
        def kib_after(scenes: int) -> int:
            for _ in range(scenes):
                Scene(triangles=TRIANGLE, device="cpu").cast([[0, 0, 3]], [[0, 0, -1]])
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

        first = kib_after(1000)
        # A scene kept alive would take more than a kilobyte.
        self.assertLess(kib_after(4000) - first, 4000)

    def test_the_examples_of_the_module_hold(self) -> None:
        outcome = doctest.testmod(raystep, extraglobs={"np": np})
        self.assertEqual((outcome.failed, outcome.attempted > 5), (0, True))


if __name__ == "__main__":
    unittest.main()
