"""A scene of meshcat that is kept in Python, and shown by a live server only when one is asked for.

Meshcat's own window starts a server process for everything, even for a static page, and puts a
page's animation in front of the objects that it moves. This one takes the window's place under
``meshcat.Visualizer``: it keeps the commands, gives them in the order that a page needs, and passes
them on to a server once it is connected.
"""

from __future__ import annotations

import contextlib
import io
from typing import Any

import meshcat
import umsgpack
import zmq
from meshcat.commands import SetAnimation
from meshcat.visualizer import ViewerWindow

from pinmech.errors import InputError, PinmechError

#: The order in which kinds of commands are replayed; within a kind, the order they came in.
_ORDER = ("delete", "set_object", "set_transform", "set_property", "set_animation")
_PATIENCE = 10_000  # [ms] until a server that does not answer is given up

Key = tuple[str, str, str]


class Recorder:
    """Keeps a scene; stands in for meshcat's window.

    Attributes:
        window: the live window, None as long as there is no server.
    """

    def __init__(self) -> None:
        self.window: ViewerWindow | None = None
        self._commands: dict[Key, dict[str, Any]] = {}

    def send(self, command: Any) -> None:
        """Keep a command of meshcat's, in place of an earlier one that it makes void."""
        data = command.lower()
        kind, path = data["type"], data["path"]
        if kind == "delete":
            inside = path.rstrip("/") + "/"
            gone = [k for k in self._commands if k[1] == path or k[1].startswith(inside)]
            for key in gone:
                del self._commands[key]
        elif kind == "set_object":  # the new object has none of the old one's properties
            for key in [k for k in self._commands if k[:2] == ("set_property", path)]:
                del self._commands[key]
        key = (kind, path, data.get("property", ""))
        if kind == "set_property" and self._commands.get(key) == data:
            return  # meshcat's server would keep every repetition
        if kind in _ORDER:
            self._commands[key] = data
        if self.window is not None:
            self.window.send(command)

    def commands(self) -> list[dict[str, Any]]:
        """The scene as meshcat commands (dicts), in an order that rebuilds it."""
        return sorted(self._commands.values(), key=lambda data: _ORDER.index(data["type"]))

    def packed(self) -> list[bytes]:
        """The same commands as meshcat's browser side reads them (MessagePack)."""
        return [umsgpack.packb(data) for data in self.commands()]

    def find(self, path: str, kind: str = "set_object", prop: str = "") -> dict[str, Any] | None:
        """The command that counts for a node, e.g. its ``set_transform``; None if there is none."""
        return self._commands.get((kind, path, prop))

    def paths(self) -> list[str]:
        """Paths of all nodes that hold an object."""
        return [path for kind, path, _ in self._commands if kind == "set_object"]

    @property
    def animated(self) -> bool:
        """True when the scene holds an animation."""
        return any(kind == "set_animation" for kind, _, _ in self._commands)

    @property
    def web_url(self) -> str | None:
        """Address of the live page; None as long as there is no server."""
        return None if self.window is None else self.window.web_url

    def connect(self, url: str | None = None) -> str:
        """Show the scene on a server, and everything that is sent from now on.

        Args:
            url: ZMQ address of a running ``meshcat-server``; None starts one, which lives as long
                as this Python process.

        Returns:
            Address of the page for a browser.

        Raises:
            InputError: no server answers at ``url``.
            PinmechError: a server cannot be started.
        """
        if self.window is None:
            try:
                # Meshcat prints the address; a library must leave standard output alone.
                with contextlib.redirect_stdout(io.StringIO()) as said:
                    window = _Window(zmq_url=url, start_server=url is None, server_args=[])
                    for command in self.commands():
                        window.send(_Lowered(command))
            except zmq.ZMQError as error:
                raise InputError(f"no meshcat server answers at {url!r}: {error}") from None
            except (OSError, RuntimeError) as error:
                detail = " ".join(said.getvalue().split()) or str(error)
                raise PinmechError(f"the meshcat server does not start: {detail}") from None
            self.window = window
        address: str = self.window.web_url
        return address

    def stop_animation(self) -> None:
        """Stop the animation in the browser, so that poses can be set; the page keeps it."""
        if self.window is not None:
            self.window.send(SetAnimation(_Lowered([]), play=False))

    # What meshcat.Visualizer asks of its window beside send:

    def get_scene(self) -> str:
        """The static page of ``meshcat.Visualizer.static_html()``."""
        from pinmech.show.scene.page import page

        return page(self.packed(), title="pinmech")

    def get_image(self) -> Any:
        """A picture from a connected browser.

        Raises:
            PinmechError: there is no live server.
        """
        if self.window is None:
            raise PinmechError("a picture needs a browser: open the viewer first")
        return self.window.get_image()

    def open(self) -> Recorder:
        """Show the page in a browser."""
        self.connect()
        assert self.window is not None
        self.window.open()
        return self

    def wait(self) -> None:
        """Block until a browser is connected."""
        self.connect()
        assert self.window is not None
        self.window.zmq_socket.setsockopt(zmq.RCVTIMEO, -1)
        self.window.wait()


class _Window(ViewerWindow):
    """Meshcat's window with a limit to its patience."""

    def connect_zmq(self) -> None:
        self.zmq_socket = self.context.socket(zmq.REQ)
        self.zmq_socket.setsockopt(zmq.RCVTIMEO, _PATIENCE)
        self.zmq_socket.setsockopt(zmq.LINGER, 0)
        self.zmq_socket.connect(self.zmq_url)


class _Lowered:
    """Something that meshcat's commands have lowered already."""

    def __init__(self, data: Any) -> None:
        self.data = data

    def lower(self) -> Any:
        return self.data


def new_visualizer() -> tuple[meshcat.Visualizer, Recorder]:
    """A meshcat visualizer on a new scene."""
    recorder = Recorder()
    return meshcat.Visualizer(window=recorder), recorder
