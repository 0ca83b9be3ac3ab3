"""A mission's report served to a browser: it follows the files of who writes the mission, and answers.

The server listens on this machine alone (127.0.0.1). Its address has a token that nobody can guess, and who
asks must not come from a page of another origin: another name of the machine, as in DNS rebinding, is refused
too. A thread looks at the files, and verifies the mission again when one of them changes; what is wrong in
them is shown with the lines.

The same page can be attached to a robot that runs: then it shows each event as the controller takes it.
"""

from __future__ import annotations

import json
import secrets
import sys
import threading
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from time import time
from typing import TYPE_CHECKING, Any

from mcpn.editor.what_if import compared
from mcpn.errors import InputError, LimitError, McpnError, Problem
from mcpn.report.page import failed_page, files_of, page
from mcpn.report.pages.token_game import fired
from mcpn.report.words import in_words
from mcpn.robot.runtime.controller import Step
from mcpn.robot.runtime.journal import step_object
from mcpn.spaces.engine_names import Asking
from mcpn.study import Study, open_study
from mcpn.trees.options import TreeOptions

if TYPE_CHECKING:
    from mcpn.logic.session import Answer

LOOPBACK = "127.0.0.1"
EVERY = 0.5
"""Seconds between two looks at the files."""

PATIENCE = 10.0
"""Seconds that a question waits for another one: states are built by one at a time."""

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


@dataclass
class ServedMission(Content):
    """A mission that is verified again when its files change.

    Args:
        file: The mission.
        import_root: The directory that imports must stay in; by default the mission's own.
        asked: Who verifies it, and within what limit.
        of_tree: How a behaviour tree is read.
    """

    file: Path
    import_root: Path | None = None
    asked: Asking = field(default_factory=Asking)
    of_tree: TreeOptions = field(default_factory=TreeOptions)
    shown: ServedPage = field(init=False)

    def __post_init__(self) -> None:
        self._lock = threading.Lock()  # of questions: the states of a study are built by one thread
        self._stop = threading.Event()
        self.shown = self._made(1, ())

    def _made(self, number: int, known: Collection[str]) -> ServedPage:
        """What is served of the files as they are now; these are the files that were known before."""
        before = _stamps([str(self.file)])
        try:
            study = open_study(self.file, import_root=self.import_root, **self.of_tree).bound(**self.asked)
            files = files_of(study.mission_net.mission)
            stamps = _stamps(files) | before  # of the mission itself from before it was read
            text = page(study.findings(), served=number)
        except InputError as error:
            files = [problem.source.file for problem in error.problems if problem.source]
            text = failed_page(self.file, error.problems, number)
            return ServedPage(number, text, None, _stamps([*files, *known]) | before)
        except Exception as error:  # the page says it, and goes on with the next change
            said = str(error) if isinstance(error, McpnError) else f"internal error: {error!r}"
            text = failed_page(self.file, [Problem(None, said)], number)
            return ServedPage(number, text, None, _stamps(known) | before)
        return ServedPage(number, text, study, stamps)

    def follow(self) -> None:
        """Verifies the mission again whenever one of its files changes, until :meth:`stop` is called."""
        while not self._stop.wait(EVERY):
            if _stamps(self.shown.stamps) != self.shown.stamps:
                self.shown = self._made(self.shown.number + 1, self.shown.stamps)

    def stop(self) -> None:
        """Ends :meth:`follow`."""
        self._stop.set()

    def answer(self, formula: str) -> dict[str, Any]:
        """The answer to a formula as a JSON object, or what is wrong with it."""

        def answered(study: Study) -> dict[str, Any]:
            found = study.ctl(formula)
            return {"formula": found.formula, "holds": found.holds, **_shows(study, found)}

        return self._asked(answered)

    def suppose(self, lost: list[str], ways: dict[str, list[str]]) -> dict[str, Any]:
        """The mission as it is beside what it would be, as a JSON object, or why that is not known."""
        return self._asked(lambda study: compared(study, lost, ways))

    def fire(self, tokens: list[Any], transition: int) -> dict[str, Any]:
        """The marking after a firing in another one, or why there is none."""
        return self._asked(lambda study: fired(study.mission_net.net, tokens, transition))

    def _asked(self, question: Callable[[Study], dict[str, Any]]) -> dict[str, Any]:
        study = self.shown.study
        if study is None:
            return {"error": "the mission cannot be read: see the page"}
        if not self._lock.acquire(timeout=PATIENCE):
            return {"error": f"another question has been running for {PATIENCE:g} seconds: ask again later"}
        try:
            return question(study)
        except McpnError as error:
            return {"error": str(error)}
        finally:
            self._lock.release()


def _shows(study: Study, answer: Answer) -> dict[str, Any]:
    steps = [(str(event), words) for event, words in in_words(study.mission_net, answer.witness.run)]
    return {"steps": steps, "notes": list(answer.witness.notes)}


def _stamps(files: Iterable[str]) -> dict[str, tuple[int, int]]:
    found = {}
    for file in files:
        try:
            told = Path(file).stat()
        except OSError:
            found[file] = (0, 0)
        else:
            found[file] = (told.st_mtime_ns, told.st_size)
    return found


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
            self.serve_forever(poll_interval=EVERY)
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


SILENCE = 10.0
"""Seconds after which a stream on which nothing happens says so, so that one whose page is closed ends."""

LAST = 2.0
"""Seconds in which pages are notified of the end."""


class RobotPage(Content):
    """The page of a mission that a robot runs; its stream is the journal, a line for each event.

    Args:
        study: The mission.
        max_states: Limit on states that are listed.

    Raises:
        LimitError: Its controller is too large for a page.
    """

    def __init__(self, study: Study) -> None:
        found = study.findings()
        if found.controller is None:
            raise LimitError(f"--page: {'; '.join(found.notes) or 'the page has no controller'}")
        self.shown = ServedPage(1, page(found, robot=True), study, {})
        self._lines: list[str] = []
        self._ended: str | None = None
        self._listening = 0
        self._changed = threading.Condition()

    def __call__(self, step: Step) -> None:
        """Takes a step; give it to ``Controller.observe``."""
        line = json.dumps({"time": time(), **step_object(step)})
        with self._changed:
            self._lines.append(f"id: {len(self._lines) + 1}\ndata: {line}\n\n")
            self._changed.notify_all()

    def lost(self, what: str) -> None:
        """Tells of a record that cannot be written."""
        with self._changed:
            self._lines.append(f"id: {len(self._lines) + 1}\nevent: lost\ndata: {json.dumps(what)}\n\n")
            self._changed.notify_all()

    def end(self, outcome: str | None) -> None:
        """Tells that the robot has ended, and waits until all pages know it, but not for long."""
        with self._changed:
            self._ended = f"event: end\ndata: {json.dumps(outcome)}\n\n"
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._listening, LAST)

    def stream(self, after: int) -> Generator[str]:
        """The journal behind a line, as it grows."""
        with self._changed:
            self._listening += 1
        try:
            while True:
                with self._changed:
                    if not self._lines[after:] and self._ended is None:
                        self._changed.wait(SILENCE)
                    lines, ended = self._lines[after:], self._ended
                yield from lines or (":\n\n",)
                after += len(lines)
                if ended is not None:
                    yield ended
                    return
        finally:
            with self._changed:
                self._listening -= 1
                self._changed.notify_all()


@contextmanager
def attached(content: RobotPage, port: int = 0) -> Iterator[PageServer]:
    """Serves the page on threads of its own.

    Args:
        content: The page.
        port: The port; 0 for any that is free.

    Raises:
        OSError: The port cannot be listened on.
    """
    server = PageServer(content, port)
    serving = threading.Thread(target=server.run, daemon=True)
    serving.start()
    try:
        yield server
    finally:
        server.shutdown()
        serving.join()
