"""The inspector in the browser: what is served, to whom, and what notebooks show of it."""

import contextlib
import http.client
import io
import os
import socket
import struct
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock
from urllib.parse import quote, urlsplit

import raystep

SCENES = Path(raystep.__file__).parent / "scenes"


def get(url: str, path: str, method: str = "GET") -> tuple[int, bytes]:
    """Status and body, with the path as it is: nothing is normalised."""
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(url).port, timeout=10)
    connection.request(method, path)
    response = connection.getresponse()
    return response.status, response.read()


class View(unittest.TestCase):
    def setUp(self) -> None:
        self.scene = raystep.Scene("textures", device="cpu")
        self.shown = raystep.view(self.scene, "raystep:1?scene=other.glb&pixel=3,4&stream=tmax.x")
        self.addCleanup(self.shown.close)
        self.base = urlsplit(self.shown.url).path

    def test_the_page_and_the_scene_are_served(self) -> None:
        status, page = get(self.shown.url, self.base)
        self.assertEqual((status, b"<html" in page), (200, True))
        for name in ("page.js", "worker.js", "raystep_web_bg.wasm.gz"):
            self.assertEqual(get(self.shown.url, f"{self.base}{name}")[0], 200, name)
        status, scene = get(self.shown.url, f"{self.base}scenes/textures.gltf")
        self.assertEqual((status, scene), (200, (SCENES / "textures.gltf").read_bytes()))
        # What it refers to: a name that is percent-encoded.
        beside = [path for path in SCENES.iterdir() if path.suffix in (".bin", ".png")]
        self.assertEqual(len(beside), 2)
        for path in beside:
            status, body = get(self.shown.url, f"{self.base}scenes/{quote(path.name)}")
            self.assertEqual((status, body), (200, path.read_bytes()), path.name)
        self.assertEqual(urlsplit(self.shown.url).fragment, "raystep:1?scene=textures.gltf&pixel=3,4&stream=tmax.x")

    def test_files_are_served_by_the_names_that_the_scene_gives(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            os.makedirs(f"{name}/scene/store")
            Path(name, "scene", "link.gltf").write_bytes((SCENES / "textures.gltf").read_bytes())
            for path in SCENES.iterdir():
                if path.suffix in (".bin", ".png"):
                    Path(name, "scene", "store", "x" + path.name).write_bytes(path.read_bytes())
                    os.symlink(f"store/x{path.name}", f"{name}/scene/{path.name}")
            shown = raystep.view(raystep.Scene(f"{name}/scene/link.gltf", device="cpu"))
            self.addCleanup(shown.close)
            base = urlsplit(shown.url).path
            for path in (path for path in SCENES.iterdir() if path.suffix in (".bin", ".png")):
                status, body = get(shown.url, f"{base}scenes/{quote(path.name)}")
                self.assertEqual((status, body), (200, path.read_bytes()), path.name)

    def test_nothing_else_is(self) -> None:
        for path in (
            "/",
            "/index.html",
            f"{self.base[:-2]}/",
            f"{self.base}../__init__.py",
            f"{self.base}%2e%2e/__init__.py",
            f"{self.base}scenes/../../__init__.py",
            f"{self.base}scenes/teapot.glb",
            f"{self.base}/etc/passwd",
            f"{self.base}scenes",
        ):
            self.assertEqual(get(self.shown.url, path)[0], 404, path)
        self.assertEqual(get(self.shown.url, self.base, "POST")[0], 501)
        with contextlib.redirect_stderr(io.StringIO()) as errors:
            here = ("127.0.0.1", urlsplit(self.shown.url).port)
            with socket.create_connection(here, timeout=10) as wrong:
                wrong.sendall(b"GET http://[ HTTP/1.0\r\n\r\n")
                self.assertIn(b" 400 ", wrong.recv(100))
            # A browser that goes away.
            with socket.create_connection(here, timeout=10) as gone:
                gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                gone.sendall(f"GET {self.base}raystep_web_bg.wasm.gz HTTP/1.0\r\n\r\n".encode())
            time.sleep(0.5)
        self.assertEqual(errors.getvalue(), "")

    def test_each_view_has_a_token_and_ends(self) -> None:
        other = raystep.view(raystep.Scene(triangles=[[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], device="cpu"))
        token = urlsplit(other.url).path
        self.assertGreaterEqual(len(token), 32)
        self.assertNotEqual(token, self.base)
        status, glb = get(other.url, f"{token}scenes/triangles.glb")
        self.assertEqual((status, glb[:4]), (200, b"glTF"))
        self.assertEqual(get(other.url, f"{token}scenes/textures.gltf")[0], 404)
        other.close()
        self.assertEqual(get(other.url, token)[0], 404)
        self.assertEqual(get(self.shown.url, self.base)[0], 200)

    @unittest.skipUnless(sys.platform == "linux", "all of 127.0.0.0/8 is this machine there")
    def test_only_one_address_is_served(self) -> None:
        port = urlsplit(self.shown.url).port
        with socket.create_connection(("127.0.0.1", port), timeout=2):
            pass
        # Another address of this machine, as that of its network would be.
        with self.assertRaises(ConnectionRefusedError), socket.create_connection(("127.0.0.2", port), timeout=2):
            pass

    def test_a_notebook_shows_it_or_says_why_not(self) -> None:
        clean = {k: v for k, v in os.environ.items() if k not in ("SSH_CONNECTION", "JUPYTERHUB_SERVICE_PREFIX")}
        with mock.patch.dict(os.environ, clean, clear=True):
            frame = self.shown._repr_html_()
            self.assertIn(f'<iframe src="{self.shown.url.replace("&", "&amp;")}"', frame)
            os.environ["SSH_CONNECTION"] = "1"
            self.assertIn("different machine", self.shown._repr_html_())
            self.assertNotIn("<iframe", self.shown._repr_html_())
            os.environ["JUPYTERHUB_SERVICE_PREFIX"] = "/user/somebody/"
            with mock.patch("importlib.util.find_spec", return_value=object()):
                port = urlsplit(self.shown.url).port
                self.assertIn(f'src="/user/somebody/proxy/{port}{self.base}?embed#', self.shown._repr_html_())

    def test_a_wrong_link_is_refused(self) -> None:
        for wrong in ("https://example.org/", "raystep:2?pixel=1,2", "pixel", "javascript:alert(1)", "nonsense=yes", "pixel=banana"):
            with self.assertRaises(raystep.OptionError, msg=wrong):
                raystep.view(self.scene, wrong)
        # Of another scene, its place is kept, and nothing else.
        text = "raystep:1?scene=a.glb&scene-index=2&scene-hash=fnv1a64:0123456789abcdef&eye=1e+5,0,0&look-at=0,0,0&pixel=5,6"
        shown = raystep.view(self.scene, f"http://localhost:8000/#{text}")
        self.assertEqual(urlsplit(shown.url).fragment, "raystep:1?scene=textures.gltf&eye=100000,0,0&look-at=0,0,0&pixel=5,6")
        script = raystep.view(self.scene, 'adapter="><script>alert(1)</script>')._repr_html_()
        self.assertNotIn("<script", script)


if __name__ == "__main__":
    unittest.main()
