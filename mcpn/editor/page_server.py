"""A server that shows one page to the browsers of this machine, and hands on what the page asks.

It listens on this machine alone (127.0.0.1). Its address has a token that nobody can guess, and who asks must
not come from a page of another origin: another name of the machine, as in DNS rebinding, is refused too.
"""

from __future__ import annotations

import json
import secrets
import sys
import threading
from collections.abc import Generator, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any

from mcpn.study import Study

if TYPE_CHECKING:
    pass

LOOPBACK = "127.0.0.1"


LOOKS = 0.5
"""Seconds between two looks at whether to end."""

MOST_ASKED = 10_000
"""Bytes of one question."""


Stamps = Mapping[str, tuple[int, int]]
"""By file when it was changed and how long it is; nothing of one that is gone."""


@dataclass(frozen=True)
class ServedPage:
    """What is served of a mission.

    Args:
        number: Counts what has been served.
        text: The page.
        study: The mission; ``None`` where its files are wrong.
        stamps: Of the files that it was made of.
    """

    number: int
    text: str
    study: Study | None
    stamps: Stamps


class Content:
    """What a server shows: a page, and what the page asks for."""

    shown: ServedPage

    def follow(self) -> None:
        """Keeps up with what is shown, on a thread of its own, until :meth:`stop` is called."""

    def stop(self) -> None:
        """Ends :meth:`follow`."""

    def answer(self, formula: str) -> dict[str, Any] | None:
        """The answer to a formula, or what is wrong with it; ``None`` where none is given."""
        return None

    def suppose(self, lost: list[str], ways: dict[str, list[str]]) -> dict[str, Any] | None:
        """What would be with hardware lost and with other alternatives; ``None`` where that is not found."""
        return None

    def fire(self, tokens: list[Any], transition: int) -> dict[str, Any] | None:
        """What is marked after a transition of the net has fired; ``None`` where no net is played."""
        return None

    def stream(self, after: int) -> Generator[str] | None:
        """Server-sent events behind one of some number, as they come; ``None`` where there are none.

        Args:
            after: The number of the last one that is known.
        """
        return None


class PageServer(ThreadingHTTPServer):
    """Serves one page at ``http://127.0.0.1:PORT/TOKEN/``.

    Args:
        content: The page.
        port: The port; 0 for any that is free.
    """

    daemon_threads = True

    def __init__(self, content: Content, port: int = 0) -> None:
        self.content = content
        self.token = secrets.token_urlsafe(24)
        super().__init__((LOOPBACK, port), _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Says nothing of a client that leaves before it has its answer; all else is a fault."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)

    @property
    def hosts(self) -> set[str]:
        """What a browser of this machine calls it."""
        return {f"{name}:{self.server_port}" for name in (LOOPBACK, "localhost")}

    @property
    def address(self) -> str:
        """Where it is."""
        return f"http://{LOOPBACK}:{self.server_port}/{self.token}/"

    def run(self) -> None:
        """Serves until it is interrupted or shut down."""
        following = threading.Thread(target=self.content.follow, daemon=True)
        following.start()
        try:
            self.serve_forever(poll_interval=LOOKS)
        finally:
            self.content.stop()
            self.server_close()


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    server_version = "mcpn"
    sys_version = ""
    timeout = 30

    def do_GET(self) -> None:
        """The page, the number of what is shown, and what happens."""
        shown = self.server.content.shown
        match self._asked_for():
            case "":
                self._send(HTTPStatus.OK, "text/html", shown.text)
            case "number":
                self._send(HTTPStatus.OK, "application/json", json.dumps({"number": shown.number}))
            case "stream" if (events := self.server.content.stream(self._last())) is not None:
                self._stream(events)
            case None:
                self._refuse(HTTPStatus.FORBIDDEN)
            case _:
                self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """An answer to a question."""
        asked_for, content = self._asked_for(), self.server.content
        if asked_for is None or self.headers.get("Content-Type") != "application/json":
            self._refuse(HTTPStatus.FORBIDDEN)
            return
        match asked_for, self._question():
            case "ask", {"formula": str(formula)}:
                answer = content.answer(formula)
            case "suppose", {"lost": list(lost), "ways": dict(ways)} if _names([lost, *ways.values()]):
                answer = content.suppose(lost, ways)
            case "fire", {"tokens": list(tokens), "transition": int(transition)}:
                answer = content.fire(tokens, transition)
            case "ask" | "suppose" | "fire", _:
                self._refuse(HTTPStatus.BAD_REQUEST)
                return
            case _:
                answer = None
        if answer is None:
            self._refuse(HTTPStatus.NOT_FOUND)
        else:
            self._send(HTTPStatus.OK, "application/json", json.dumps(answer))

    def _asked_for(self) -> str | None:
        """What stands behind the token; ``None`` where the token, the host or the origin is another."""
        server, headers = self.server, self.headers
        if headers.get("Host") not in server.hosts:
            return None
        origin = headers.get("Origin")
        if origin is not None and origin not in {f"http://{host}" for host in server.hosts}:
            return None
        if headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            return None
        token, slash, rest = self.path.removeprefix("/").partition("/")
        if not slash or not secrets.compare_digest(token.encode(), server.token.encode()):
            return None
        return rest

    def _question(self) -> Any:
        """The question of a request; ``None`` where it has none."""
        length = self.headers.get("Content-Length", "")
        digits = len(str(MOST_ASKED))  # more of them, zeros too, are no length that a browser sends
        if not (
            length.isascii() and length.isdigit() and len(length) <= digits and int(length) <= MOST_ASKED
        ):
            return None
        try:
            return json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            return None

    def _last(self) -> int:
        """The number of the last event that the browser had before it asks again; 0 of none."""
        said = self.headers.get("Last-Event-ID", "")
        return int(said[:9]) if said.isascii() and said.isdigit() else 0

    def _stream(self, events: Generator[str]) -> None:
        """Sends events as they come, until they end or nobody listens."""
        self.close_connection = True
        self._head(HTTPStatus.OK, "text/event-stream")
        with suppress(OSError), closing(events):
            for event in events:
                self.wfile.write(event.encode())
                self.wfile.flush()

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True
        self._send(status, "text/plain", f"{status.phrase}\n")

    def _send(self, status: HTTPStatus, kind: str, text: str) -> None:
        body = text.encode()
        self._head(status, kind, len(body))
        self.wfile.write(body)

    def _head(self, status: HTTPStatus, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in _headers(kind):
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, *_told: object) -> None:
        """Says nothing: the token stands in what is asked."""


def _names(lists: list[Any]) -> bool:
    """Whether some values are lists of texts."""
    return all(isinstance(names, list) and all(isinstance(name, str) for name in names) for names in lists)


def _headers(kind: str) -> Iterator[tuple[str, str]]:
    yield "Content-Type", f"{kind}; charset=utf-8"
    yield "Cache-Control", "no-store"
    yield "X-Content-Type-Options", "nosniff"
    yield "X-Frame-Options", "DENY"
    yield "Referrer-Policy", "no-referrer"
    yield "Cross-Origin-Resource-Policy", "same-origin"
