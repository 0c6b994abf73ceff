"""The inspector in the browser: the page that the wheel includes, served to this machine only."""

from __future__ import annotations

import hmac
import html
import importlib.util
import os
import posixpath
import secrets
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path, PurePosixPath
from typing import Any, Union
from urllib.parse import unquote, urlsplit

from . import _raystep
from ._raystep import OptionError
from ._scene import Scene

PAGE = Path(__file__).parent / "page"
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".png": "image/png",
    ".gltf": "model/gltf+json",
    ".glb": "model/gltf-binary",
}

Content = Union[Path, bytes]


class _Server(ThreadingHTTPServer):
    """Files of all views, each behind its token, on a port of the loopback address."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.views: dict[str, dict[str, Content]] = {}
        threading.Thread(target=self.serve_forever, name="raystep view", daemon=True).start()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Reports an error, unless the browser has only gone away."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def find(self, path: str) -> Content | None:
        """What is at `/TOKEN/NAME`: nothing but the files that a view lists."""
        token, _, name = unquote(path).lstrip("/").partition("/")
        files = {}
        for known, of_view in list(self.views.items()):
            # Takes as long for a wrong token as for a right one.
            if hmac.compare_digest(known.encode(), token.encode()):
                files = of_view
        return files.get(name or "index.html")


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    server_version = "raystep"
    sys_version = ""

    def do_GET(self) -> None:
        try:
            path = urlsplit(self.path).path
        except ValueError:
            self.send_error(HTTPStatus.BAD_REQUEST)
            return
        content = self.server.find(path)
        try:
            body = content.read_bytes() if isinstance(content, Path) else content
        except OSError:
            body = None
        if body is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        suffix = PurePosixPath(path).suffix or ".html"
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", TYPES.get(suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(body)))
        # A view's address is its key: it goes nowhere else.
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        pass


_lock = threading.Lock()
_server: _Server | None = None


def forget() -> None:
    """In a forked process, where the server's thread does not run."""
    global _lock, _server
    _lock, _server = threading.Lock(), None


def _serve() -> _Server:
    global _server
    with _lock:
        if _server is None:
            _server = _Server()
        return _server


class View:
    """The inspector in the browser, of one scene: made by `view`. In a notebook, it shows itself.

    >>> from raystep import Scene, view
    >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
    >>> shown = view(scene)
    >>> shown.url.startswith("http://127.0.0.1:")
    True
    >>> shown.close()
    """

    def __init__(self, server: _Server, token: str, fragment: str, height: int) -> None:
        self._server, self._token, self._fragment, self._height = server, token, fragment, height

    @property
    def url(self) -> str:
        """Its address on this machine. It contains a random token, since anyone on this machine who has it can read the scene.

        >>> from raystep import Scene, view
        >>> shown = view(Scene(triangles=[], device="cpu"), link="pixel=3,4")
        >>> shown.url.split("#")[1]
        'raystep:1?scene=triangles.glb&pixel=3,4'
        >>> shown.close()
        """
        return f"http://127.0.0.1:{self._server.server_port}/{self._token}/?embed#{self._fragment}"

    def close(self) -> None:
        """Stops serving it.

        >>> from raystep import Scene, view
        >>> shown = view(Scene(triangles=[], device="cpu"))
        >>> shown.close()
        >>> shown.close()
        """
        self._server.views.pop(self._token, None)

    def __repr__(self) -> str:
        return f"View({self.url!r})"

    def _repr_html_(self) -> str:
        source, problem = _address(self.url)
        if problem is not None:
            return f"<p>{html.escape(problem)}</p>"
        return (
            f'<iframe src="{html.escape(source)}" width="100%" height="{self._height}" style="border: 0" '
            'allow="fullscreen; clipboard-write"></iframe>'
        )


def _address(url: str) -> tuple[str, str | None]:
    """Where a notebook's browser reaches an address of this machine; or why it does not."""
    parts = urlsplit(url)
    rest = f"{parts.path}?{parts.query}#{parts.fragment}"
    has_proxy = importlib.util.find_spec("jupyter_server_proxy") is not None
    hub = os.environ.get("JUPYTERHUB_SERVICE_PREFIX")
    if hub is not None and has_proxy:
        return f"{hub.rstrip('/')}/proxy/{parts.port}{rest}", None
    is_remote = hub is not None or "SSH_CONNECTION" in os.environ or "COLAB_RELEASE_TAG" in os.environ
    if is_remote:
        return url, (
            "raystep.view: this kernel seems to run on a different machine from the browser. On JupyterHub, install "
            "jupyter-server-proxy in the kernel's environment and restart the server; otherwise forward the port "
            f"(ssh -L {parts.port}:127.0.0.1:{parts.port} HOST) and open {url}"
        )
    return url, None


def view(scene: Scene, link: str = "", *, height: int = 640) -> View:
    """Shows a scene in the inspector, in an iframe of `height` CSS pixels: every pass and every stream, in the browser.

    `link`: where to start: a link from the inspector's *Copy link*, or part of one, such as
    "pixel=200,260&pass=41&stream=tmax.x". A scene in the link is ignored in favour of `scene`. The page and the scene are served on 127.0.0.1
    only, and the page sends no data anywhere; the scene's files must stay in place. Raises `OptionError` if `link` is not
    a valid link, or if the module was built without the page.

    >>> from raystep import Scene, view
    >>> scene = Scene(triangles=[[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], device="cpu")
    >>> shown = view(scene, "pixel=10,20&pass=3")
    >>> "<iframe" in shown._repr_html_() or "different machine" in shown._repr_html_()
    True
    >>> shown.close()
    """
    if not (PAGE / "index.html").is_file():
        raise OptionError("view: this build of raystep does not include the inspector page: build the wheel with 'sh app/python/build.sh DIR'")
    name, of_scene = _files(scene)
    # What the inspector would say of it, without waiting for the page.
    fragment = _raystep.link_to(name, link)
    files: dict[str, Content] = {
        path.relative_to(PAGE).as_posix(): path for path in PAGE.rglob("*") if path.is_file()
    }
    files.update({f"scenes/{path}": content for path, content in of_scene.items()})
    server, token = _serve(), secrets.token_urlsafe(24)
    server.views[token] = files
    return View(server, token, fragment, height)


def _files(scene: Scene) -> tuple[str, dict[str, Content]]:
    """A scene's name in the page, and what is served of it: its own file and those that it refers to, or a GLB."""
    paths = [Path(path) for path in scene._scene.files]
    if not paths:
        return "triangles.glb", {"triangles.glb": scene._scene.glb()}
    folder = paths[0].parent
    # Others are outside of the scene's folder, where a page has none.
    beside = [path for path in paths if path.is_relative_to(folder)]
    # A browser asks for b, where a file names a/../b. Bytes that are no text are not of a link.
    name = os.fsencode(paths[0].name).decode("utf-8", "replace")
    files: dict[str, Content] = {name: paths[0]}
    return name, files | {posixpath.normpath(path.relative_to(folder).as_posix()): path for path in beside}
