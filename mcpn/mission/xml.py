"""Reads mission files (namespace ``urn:mcpn:mission:1``); :mod:`mcpn.mission.writer` writes them.

Files are untrusted: see :mod:`mcpn.xmlio`; imports stay inside the directory of the main file, unless a wider
root is given. All problems of all files are collected and raised in one go.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lxml import etree

from mcpn.errors import InputError, Problem, Source
from mcpn.mission.language.forms import Field, form_of, language
from mcpn.mission.model import Import, Mission, Parallel, Protocol
from mcpn.mission.robot import Robot
from mcpn.mission.schema import find_misfits
from mcpn.mission.validate import find_errors
from mcpn.xmlio import parse_xml

NOTHING: Mapping[Path, str] = {}
MAX_FILE_BYTES = 16 << 20
MAX_IMPORTS = 1000
MAX_DEPTH = 64
MAX_ELEMENTS = 200_000


def read_mission(
    path: Path | str, *, import_root: Path | str | None = None, unsaved: Mapping[Path, str] = NOTHING
) -> Mission:
    """Reads a mission with its imports, and checks it.

    Args:
        path: The mission file.
        import_root: The directory that imports must stay in; that of the file by default.
        unsaved: By resolved file the text that is read instead of what the file holds.

    Returns:
        A valid mission, every element with its file and line.

    Raises:
        InputError: Everything that is wrong, by file and line. References are checked once every file could
            be read and fits the schema, for what a file declares is not known otherwise.

    Examples:
        >>> mission = read_mission("experiments/ulysse/mission.xml")
        >>> mission.name, [block.name for block in mission.blocks]
        ('ulysse', ['coral_head', 'transect'])
    """
    main = Path(path)
    root = Path(import_root) if import_root is not None else main.parent
    reader = _MissionReader(main, root.resolve(), unsaved)
    mission = reader.mission()
    problems = reader.problems
    if mission is not None and reader.complete:
        problems = [*problems, *find_errors(mission)]
    if mission is None or problems:
        raise InputError(sorted(set(problems), key=_by_place))
    return mission


def misfits_of(path: Path, *, unsaved: Mapping[Path, str] = NOTHING) -> list[Problem]:
    """What of one file does not fit the language, whatever its root; what it refers to is not looked at.

    Args:
        path: A file of a mission, a robot or protocols.
        unsaved: As of :func:`read_mission`.
    """
    reader = _MissionReader(path, path.parent, unsaved)
    reader.load()
    return reader.problems


def _by_place(problem: Problem) -> tuple[str, int, str]:
    source = problem.source or Source("")
    return source.file, source.line or 0, problem.message


class _MissionReader:
    def __init__(self, main: Path, root: Path, unsaved: Mapping[Path, str] = NOTHING) -> None:
        self.root = root
        self.unsaved = unsaved
        self.problems: list[Problem] = []
        self.complete = True
        self.elements = 0
        self.path = main  # the file that is read
        self.chain: list[Path] = []  # it and the files that import it, the main one first
        self.seen: set[Path] = set()
        self.robots: list[Robot] = []
        self.protocols: list[Protocol] = []

    def mission(self) -> Mission | None:
        root = self.load()
        if root is None:
            return None
        if _tag(root) != Mission.TAG:
            self.wrong(root, f"expected a mission, found <{_tag(root)}>")
            self.complete = False
            return None
        self.chain.append(self.path.resolve())
        self.seen.update(self.chain)
        mission: Mission = self.element(root)
        return replace(mission, robots=tuple(self.robots), protocols=tuple(self.protocols))

    def element(self, element: etree._Element) -> Any:
        """What an element of a file that fits the schema says; the robots and protocols are kept aside."""
        texts = {str(name): str(text) for name, text in element.attrib.items()}
        of = language()[_tag(element)].form(texts)
        form = form_of(of)
        values = _said(texts, form.attributes) | {"source": self.source(element)}
        if "mandatory" in texts:
            self.mandatory(element, values)
        members = [self.element(child) for child in element]
        for content in form.contents if members else ():
            values[content.name] = tuple(member for member in members if isinstance(member, content.classes))
        for content in form.contents:
            if (brief := content.short) and not values.get(content.name):
                single = {"name": values["name"], "source": values["source"]} | _said(texts, (brief,))
                values[content.name] = (content.classes[0](**single),)
        made = of(**values)
        match made:
            case Import():
                self.imported(element, made.href)
            case Robot():
                self.robots.append(made)
            case Protocol():
                self.protocols.append(made)
        return made

    def mandatory(self, element: etree._Element, values: dict[str, Any]) -> None:
        # Where it is false the validator of missions says so, of files and of those built in Python.
        parent = element.getparent()
        if values["mandatory"] and (parent is None or _tag(parent) != Parallel.TAG):
            self.wrong(element, "mandatory is for children of a parallel block, expected none here")

    def load(self) -> etree._Element | None:
        """The root of the file if that fits the schema, or ``None`` after noting why it does not."""
        try:
            typed = self.unsaved.get(self.path.resolve()) if self.unsaved else None
            element = parse_xml(self.path, MAX_FILE_BYTES, typed)
        except InputError as error:
            self.problems.extend(error.problems)
            self.complete = False
            return None
        if not self.bounded(element):
            self.complete = False
            return None
        misfits = find_misfits(element)
        self.problems.extend(Problem(Source(str(self.path), line), message) for line, message in misfits)
        if misfits:
            self.complete = False
            return None
        return element

    def bounded(self, root: etree._Element) -> bool:
        depth = 0
        for event, element in etree.iterwalk(root, events=("start", "end")):
            depth += 1 if event == "start" else -1
            self.elements += event == "start"
            if depth > MAX_DEPTH:
                self.wrong(element, f"nested more than {MAX_DEPTH} deep, the limit on nesting")
                return False
            if self.elements > MAX_ELEMENTS:
                self.wrong(element, f"more than {MAX_ELEMENTS} elements in all files, the limit on them")
                return False
        return True

    def wrong(self, element: etree._Element, message: str) -> None:
        self.problems.append(Problem(self.source(element), message))

    def source(self, element: etree._Element) -> Source:
        line = element.sourceline
        return Source(str(self.path), line if isinstance(line, int) else None)

    def imported(self, element: etree._Element, href: str) -> None:
        try:
            target = self.path.parent / href
            real = target.resolve()
            inside = real.is_relative_to(self.root)
            kind = "a file" if target.is_file() else "a directory" if target.is_dir() else "no such file"
        except (OSError, ValueError, RuntimeError) as error:
            what = getattr(error, "strerror", None) or error
            self.not_imported(element, f"{href[:80]!r}: {what}")
            return
        if not inside or ":" in href.split("/")[0]:
            self.not_imported(element, f"{href} leaves the mission's directory")
        elif real in self.chain:
            self.not_imported(element, f"{href} closes a cycle of imports")
        elif real not in self.seen:
            self.seen.add(real)
            if len(self.seen) > MAX_IMPORTS:
                self.not_imported(element, f"{href}: more than {MAX_IMPORTS} files, the limit on imports")
            elif len(self.chain) > MAX_DEPTH:
                self.not_imported(element, f"{href}: more than {MAX_DEPTH} files deep, the limit on imports")
            elif kind != "a file":
                self.not_imported(element, f"{href}: {kind}")
            elif not self.file(target, real):
                self.not_imported(element, f"{href}: expected <robot> or <protocols>, found <mission>")

    def file(self, path: Path, real: Path) -> bool:
        """Reads an imported file; whether it is none that holds a mission."""
        importing, self.path = self.path, path
        self.chain.append(real)
        root = self.load()
        fits = root is None or _tag(root) != Mission.TAG
        if root is not None and fits:
            self.element(root)
        self.chain.pop()
        self.path = importing
        return fits

    def not_imported(self, element: etree._Element, why: str) -> None:
        self.complete = False
        self.wrong(element, f"import of {why}")


def _tag(element: etree._Element) -> str:
    return etree.QName(element).localname


def _said(texts: Mapping[str, str], attributes: Iterable[Field]) -> dict[str, Any]:
    """The values of the attributes that an element has, by field."""
    return {a.name: a.datatype.read(texts[a.tag]) for a in attributes if a.tag in texts}
