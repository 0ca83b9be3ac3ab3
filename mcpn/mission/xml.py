"""Reads mission files with all that they import, within limits: 64 deep, 200,000 elements, 1,000 imports.

Their namespace is ``urn:mcpn:mission:1``; :mod:`mcpn.mission.writer` writes them. Files are untrusted:
see :mod:`mcpn.xmlio`; imports stay inside the directory of the main file, unless a wider root is given. All
problems of all files are collected and raised in one go.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lxml import etree

from mcpn.errors import InputError, Problem, Source
from mcpn.files import OutsideError, file_inside, read_bounded
from mcpn.mission.language.forms import ROOTS, Field, form_of, language
from mcpn.mission.language.incremental_reader import Edit, Made, MissionDraft, tag_of
from mcpn.mission.misfits import find_misfits
from mcpn.mission.model import Import, Mission, Parallel, Protocol
from mcpn.mission.robot import Robot
from mcpn.mission.validate import find_errors
from mcpn.xmlio import line_of, parse_bytes

NOTHING: Mapping[Path, str] = {}
MAX_FILE_BYTES = 16 << 20
MAX_IMPORTS = 1000
MAX_DEPTH = 64
MAX_ELEMENTS = 200_000
_ASIDE = {Import.TAG, Protocol.TAG, *(root.TAG for root in ROOTS)}
"""Elements that the reader also collects (robots, protocols) or follows (imports), wherever they stand."""


def read_mission(
    path: Path | str,
    *,
    import_root: Path | str | None = None,
    unsaved: Mapping[Path, str] = NOTHING,
    draft: MissionDraft | None = None,
) -> Mission:
    """Reads a mission with its imports, and checks it.

    Args:
        path: The mission file.
        import_root: The directory that imports must stay in; that of the file by default.
        unsaved: By resolved file the text that is read instead of what the file holds.
        draft: What was read of these files before: what has not changed since is not read again. It keeps
            what is read now.

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
    reader = _MissionReader(main, root.resolve(), unsaved, draft)
    mission = reader.mission()
    problems = reader.problems
    if mission is not None and reader.complete:
        problems = [*problems, *find_errors(mission, read=True, before=draft.mission if draft else None)]
    if draft is not None and mission is not None and not problems:
        draft.mission = mission
    if mission is None or problems:
        raise InvalidMission(sorted(set(problems), key=in_place), mission if reader.complete else None)
    return mission


class InvalidMission(InputError):
    """A mission is not valid.

    Args:
        problems: What is wrong, in the order of the files and lines.
        mission: The mission as it was read; ``None`` where not all of it could be.
    """

    def __init__(self, problems: Iterable[Problem], mission: Mission | None) -> None:
        super().__init__(problems)
        self.mission = mission


def misfits_of(path: Path, *, unsaved: Mapping[Path, str] = NOTHING) -> list[Problem]:
    """What of one file does not fit the language, whatever its root; what it refers to is not looked at.

    Args:
        path: A file of a mission, a robot or protocols.
        unsaved: As of :func:`read_mission`.
    """
    reader = _MissionReader(path, path.parent, unsaved)
    reader.load()
    return reader.problems


def in_place(problem: Problem) -> tuple[str, int, str]:
    """By what problems are sorted: the order of the files and lines."""
    source = problem.source or Source("")
    return source.file, source.line or 0, problem.message


class _MissionReader:
    def __init__(
        self, main: Path, root: Path, unsaved: Mapping[Path, str] = NOTHING, draft: MissionDraft | None = None
    ) -> None:
        self.root = root
        self.unsaved = unsaved
        self.draft = draft
        self.lines: list[bytes] = []  # of the file that is read
        self.known: tuple[Made, Edit] | None = None  # what that file was read as before, and its edit since
        self.misplaced: set[Path] = set()
        """Files with a problem that the schema does not find: a draft must not keep them."""
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
        if tag_of(root) != Mission.TAG:
            self.wrong(self.source(root), f"expected a mission, found <{tag_of(root)}>")
            self.complete = False
            return None
        self.chain.append(self.path.resolve())
        self.seen.update(self.chain)
        mission: Mission = self.read(root).value
        return replace(mission, robots=tuple(self.robots), protocols=tuple(self.protocols))

    def read(self, root: etree._Element) -> Made:
        """Reads the elements of a file that fits the schema; the draft keeps them."""
        path, lines, known = self.path, self.lines, self.known
        if self.draft is None:
            return self.element(root)
        self.draft.files.pop(path, None)  # kept elements may get other line numbers
        made = self.element(root, *(known or (None, None)))
        if path not in self.misplaced:
            self.draft.files[path] = lines, made
        return made

    def element(self, element: etree._Element, before: Made | None = None, edit: Edit | None = None) -> Made:
        """Reads an element of a file that fits the schema, and collects robots and protocols."""
        texts = {str(name): str(text) for name, text in element.attrib.items()}
        tag = tag_of(element)
        kind = language(core=True)[tag].form(texts)
        form = form_of(kind)
        source = self.source(element)
        values = _said(texts, form.said()) | {"source": source}
        if "mandatory" in texts:
            self.mandatory(element, values)
        made = self.members(element, before, edit)
        members = [each.value for each in made]
        for content in form.held() if members else ():
            values[content.name] = tuple(member for member in members if type(member) in content.classes)
        for content in form.contents:
            if (brief := content.short) and not values.get(content.name):
                single = {"name": values["name"], "source": source} | _said(texts, (brief,))
                values[content.name] = (content.classes[0](**single),)
        value = kind(**values)
        self.aside(value)
        return Made(tag, value, made, source.line or 1, made[-1].last if made else source.line or 1)

    def members(self, element: etree._Element, before: Made | None, edit: Edit | None) -> list[Made]:
        """Reads the elements inside; those that an edit has not changed are taken from before."""
        if before is None or edit is None or before.tag != tag_of(element):
            return [self.element(child) for child in element]
        count = len(element)
        first, behind = edit.kept(before, count)
        made = before.members[:first]
        self.again(made)
        for place, old in enumerate(edit.between_kept(before, count), first):
            made.append(self.element(element[place], old, edit))
        last = before.members[len(before.members) - behind :]
        for each in last if edit.more else ():
            each.move(edit.more)
        self.again(last)
        return [*made, *last]

    def again(self, made: Iterable[Made]) -> None:
        """Collects robots and protocols, and follows imports, of elements that are not read again."""
        for each in made:
            if each.tag in _ASIDE:
                self.again(each.members)
                self.aside(each.value)

    def aside(self, value: Any) -> None:
        match value:
            case Import():
                self.imported(value)
            case Robot():
                self.robots.append(value)
            case Protocol():
                self.protocols.append(value)

    def mandatory(self, element: etree._Element, values: dict[str, Any]) -> None:
        # Where it is false the validator of missions says so, of files and of those built in Python.
        parent = element.getparent()
        if values["mandatory"] and (parent is None or tag_of(parent) != Parallel.TAG):
            self.misplaced.add(self.path)
            self.wrong(values["source"], "mandatory is for children of a parallel block, expected none here")

    def load(self) -> etree._Element | None:
        """The root of the file if that fits the schema, or ``None`` after noting why it does not."""
        try:
            typed = self.unsaved.get(self.path.resolve()) if self.unsaved else None
            data = read_bounded(self.path, MAX_FILE_BYTES) if typed is None else typed.encode()
            element = parse_bytes(self.path, data, None if typed is None else "utf-8")
        except InputError as error:
            self.problems.extend(error.problems)
            self.complete = False
            return None
        if not self.bounded(element):
            self.complete = False
            return None
        misfits = self.misfits(element, data.split(b"\n"))
        self.problems.extend(Problem(Source(str(self.path), line), message) for line, message in misfits)
        if misfits:
            self.complete = False
            return None
        return element

    def misfits(self, root: etree._Element, lines: list[bytes]) -> list[tuple[int, str]]:
        """What in the file does not fit the schema; unchanged parts that fitted before are skipped."""
        self.lines = lines
        self.known = None if self.draft is None else self.draft.edit(self.path, lines)
        if self.known is None or self.known[0].tag != tag_of(root):
            return find_misfits(root)
        before, edit = self.known
        return find_misfits(root, (edit.excerpt(root, before), edit.changed(root, before)))

    def bounded(self, root: etree._Element) -> bool:
        depth = 0
        for event, element in etree.iterwalk(root, events=("start", "end")):
            depth += 1 if event == "start" else -1
            self.elements += event == "start"
            if depth > MAX_DEPTH:
                self.wrong(self.source(element), f"nested more than {MAX_DEPTH} deep, the limit on nesting")
                return False
            if self.elements > MAX_ELEMENTS:
                self.wrong(
                    self.source(element), f"more than {MAX_ELEMENTS} elements in all files, the limit on them"
                )
                return False
        return True

    def wrong(self, source: Source | None, message: str) -> None:
        self.problems.append(Problem(source, message))

    def source(self, element: etree._Element) -> Source:
        return Source(str(self.path), line_of(element))

    def imported(self, made: Import) -> None:
        href = made.href
        try:
            target = file_inside(href, self.path.parent, self.root)
        except OutsideError:
            real = (self.path.parent / href).resolve()
            root = os.path.relpath(os.path.commonpath([self.root, real]))
            self.not_imported(made, f"{href} leaves the mission's directory: --import-root {root} allows it")
            return
        except InputError as error:
            self.not_imported(made, str(error))
            return
        real = target.resolve()
        if real in self.chain:
            self.not_imported(made, f"{href} closes a cycle of imports")
        elif real not in self.seen:
            self.seen.add(real)
            if len(self.seen) > MAX_IMPORTS:
                self.not_imported(made, f"{href}: more than {MAX_IMPORTS} files, the limit on imports")
            elif len(self.chain) > MAX_DEPTH:
                self.not_imported(made, f"{href}: more than {MAX_DEPTH} files deep, the limit on imports")
            elif not self.file(target, real):
                self.not_imported(made, f"{href}: expected <robot> or <protocols>, found <mission>")

    def file(self, path: Path, real: Path) -> bool:
        """Reads an imported file. Returns whether its root may be imported: is not ``<mission>``."""
        importing, self.path = self.path, path
        self.chain.append(real)
        root = self.load()
        fits = root is None or tag_of(root) != Mission.TAG
        if root is not None and fits:
            self.read(root)
        self.chain.pop()
        self.path = importing
        return fits

    def not_imported(self, made: Import, why: str) -> None:
        self.complete = False
        self.wrong(made.source, f"import of {why}")


def _said(texts: Mapping[str, str], attributes: Iterable[Field]) -> dict[str, Any]:
    """The values of the attributes that an element has, by field."""
    return {a.name: a.datatype.read(texts[a.tag]) for a in attributes if a.tag in texts}
