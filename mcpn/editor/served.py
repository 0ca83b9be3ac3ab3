"""A mission's report that follows its files: verified again when one of them changes, and asked questions.

A thread looks at the files; what is wrong in them is shown with the lines.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcpn.editor.page_server import Content, ServedPage
from mcpn.editor.what_if import compared
from mcpn.errors import InputError, McpnError, Problem
from mcpn.report.page import failed_page, page
from mcpn.report.pages.token_game import fired
from mcpn.report.words import in_words
from mcpn.spaces.engine_names import Asking
from mcpn.study import Study, open_study
from mcpn.trees.options import TreeOptions

if TYPE_CHECKING:
    from mcpn.logic.session import Answer

EVERY = 0.5
"""Seconds between two looks at the files."""


PATIENCE = 10.0
"""Seconds that a question waits for another one: states are built by one at a time."""


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
            files = [*study.mission_net.mission.files]
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
