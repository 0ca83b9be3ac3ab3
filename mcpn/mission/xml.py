"""Reads mission files (namespace ``urn:mcpn:mission:1``); :mod:`mcpn.mission.writer` writes them.

Files are untrusted: see :mod:`mcpn.xmlio`; imports stay inside the directory of the main file, unless a wider
root is given. All problems of all files are collected and raised in one go.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lxml import etree

from mcpn.errors import InputError, Problem, Source
from mcpn.mission.model import (
    Activity,
    Alternative,
    Block,
    DeclaredEvent,
    Each,
    Handler,
    Hardware,
    Mission,
    Objective,
    Parallel,
    Parameter,
    Protocol,
    Recursive,
    Robot,
    Software,
    Use,
)
from mcpn.mission.schema import find_misfits
from mcpn.mission.validate import find_errors
from mcpn.xmlio import parse_xml

MAX_FILE_BYTES = 16 << 20
MAX_IMPORTS = 1000
MAX_DEPTH = 64
MAX_ELEMENTS = 200_000


def read_mission(path: Path | str, *, import_root: Path | str | None = None) -> Mission:
    """Reads a mission with its imports, and checks it.

    Args:
        path: The mission file.
        import_root: The directory that imports must stay in; that of the file by default.

    Returns:
        A valid mission, every element with its file and line.

    Raises:
        InputError: Everything that is wrong, by file and line. References are checked once every file could
            be read and fits the schema, for what a file declares is not known otherwise.
    """
    main = Path(path)
    root = Path(import_root) if import_root is not None else main.parent
    reader = _Reader(root.resolve())
    mission = reader.mission(main)
    problems = reader.problems
    if mission is not None and reader.complete:
        problems = [*problems, *find_errors(mission)]
    if mission is None or problems:
        raise InputError(sorted(set(problems), key=_by_place))
    return mission


def _by_place(problem: Problem) -> tuple[str, int, str]:
    source = problem.source or Source("")
    return source.file, source.line or 0, problem.message


@dataclass
class _Contents:
    """What a file and its imports declare."""

    robots: list[Robot] = field(default_factory=list)
    protocols: list[Protocol] = field(default_factory=list)


class _Reader:
    def __init__(self, root: Path) -> None:
        self.root = root
        self.problems: list[Problem] = []
        self.complete = True
        self.elements = 0
        self.seen: set[Path] = set()

    def mission(self, path: Path) -> Mission | None:
        element = self.load(path)
        if element is None:
            return None
        if _tag(element) != "mission":
            self.wrong(path, element, f"expected a mission, found <{_tag(element)}>")
            self.complete = False
            return None
        self.seen.add(path.resolve())
        found = _Contents()
        blocks = []
        for child in element:
            if _tag(child) in ("import", "robot", "protocols"):
                self.declarations(child, path, [path.resolve()], found)
            elif _tag(child) != "on":
                blocks.append(self.block(child, path))
        return Mission(
            **self.common(element, path),
            blocks=tuple(blocks),
            robots=tuple(found.robots),
            protocols=tuple(found.protocols),
            handlers=self.handlers(element, path),
        )

    def load(self, path: Path) -> etree._Element | None:
        """The root of a file that fits the schema, or ``None`` after noting why it does not."""
        try:
            element = parse_xml(path, MAX_FILE_BYTES)
        except InputError as error:
            self.problems.extend(error.problems)
            self.complete = False
            return None
        if not self.bounded(element, path):
            self.complete = False
            return None
        misfits = find_misfits(element)
        self.problems.extend(Problem(Source(str(path), line), message) for line, message in misfits)
        if misfits:
            self.complete = False
            return None
        return element

    def bounded(self, root: etree._Element, path: Path) -> bool:
        depth = 0
        for event, element in etree.iterwalk(root, events=("start", "end")):
            depth += 1 if event == "start" else -1
            self.elements += event == "start"
            if depth > MAX_DEPTH:
                self.wrong(path, element, f"nested more than {MAX_DEPTH} deep, the limit on nesting")
                return False
            if self.elements > MAX_ELEMENTS:
                self.wrong(
                    path, element, f"more than {MAX_ELEMENTS} elements in all files, the limit on them"
                )
                return False
        return True

    def wrong(self, path: Path, element: etree._Element, message: str) -> None:
        self.problems.append(Problem(_source(element, path), message))

    # --- imports, robots and protocols -----------------------------------------------------------------

    def declarations(self, element: etree._Element, path: Path, chain: list[Path], found: _Contents) -> None:
        if _tag(element) == "import":
            self.imported(element, path, chain, found)
        elif _tag(element) == "robot":
            found.robots.append(self.robot(element, path, chain, found))
        else:
            for child in element:
                if _tag(child) == "import":
                    self.imported(child, path, chain, found)
                else:
                    found.protocols.append(self.protocol(child, path))

    def imported(self, element: etree._Element, path: Path, chain: list[Path], found: _Contents) -> None:
        href = element.get("href", "")
        try:
            target = path.parent / href
            real = target.resolve()
            inside = real.is_relative_to(self.root)
            kind = "a file" if target.is_file() else "a directory" if target.is_dir() else "no such file"
        except (OSError, ValueError, RuntimeError) as error:
            what = getattr(error, "strerror", None) or error
            self.not_imported(path, element, f"{href[:80]!r}: {what}")
            return
        if not inside or ":" in href.split("/")[0]:
            self.not_imported(path, element, f"{href} leaves the mission's directory")
        elif real in chain:
            self.not_imported(path, element, f"{href} closes a cycle of imports")
        elif real not in self.seen:
            self.seen.add(real)
            if len(self.seen) > MAX_IMPORTS:
                self.not_imported(
                    path, element, f"{href}: more than {MAX_IMPORTS} files, the limit on imports"
                )
            elif len(chain) > MAX_DEPTH:
                self.not_imported(
                    path, element, f"{href}: more than {MAX_DEPTH} files deep, the limit on imports"
                )
            elif kind != "a file":
                self.not_imported(path, element, f"{href}: {kind}")
            else:
                root = self.load(target)
                if root is not None and _tag(root) == "mission":
                    self.not_imported(
                        path, element, f"{href}: expected <robot> or <protocols>, found <mission>"
                    )
                elif root is not None:
                    self.declarations(root, target, [*chain, real], found)

    def not_imported(self, path: Path, element: etree._Element, why: str) -> None:
        self.complete = False
        self.wrong(path, element, f"import of {why}")

    def robot(self, element: etree._Element, path: Path, chain: list[Path], found: _Contents) -> Robot:
        hardware, software, activities, events = [], [], [], []
        for child in element:
            tag, common = _tag(child), self.common(child, path)
            if tag == "import":
                self.imported(child, path, chain, found)
            elif tag == "hardware":
                common |= _numbers(child, "failure_rate", "repair_rate")
                faulty, shared = _truth(child, "faulty"), _truth(child, "shared", "false")
                hardware.append(Hardware(**common, faulty=faulty, shared=shared))
            elif tag == "software":
                software.append(Software(**common, exclusive=_truth(child, "exclusive", "false")))
            elif tag == "event":
                common |= _numbers(child, "rate")
                events.append(DeclaredEvent(**common))
            else:
                activities.append(self.activity(child, path))
        return Robot(
            **self.common(element, path),
            hardware=tuple(hardware),
            software=tuple(software),
            activities=tuple(activities),
            events=tuple(events),
        )

    def activity(self, element: etree._Element, path: Path) -> Activity:
        common = self.common(element, path)
        alternatives = tuple(
            Alternative(
                **self.common(child, path),
                consumes=_names(child, "consumes"),
                parameters=self.parameters(child, path),
            )
            for child in element
            if _tag(child) == "alternative"
        )
        short = Alternative(
            name=common["name"], consumes=_names(element, "consumes"), source=common["source"]
        )
        return Activity(
            **common,
            produces=_names(element, "produces"),
            switch_back=_truth(element, "switch_back", "false"),
            alternatives=alternatives or (short,),
            parameters=self.parameters(element, path),
        )

    def protocol(self, element: etree._Element, path: Path) -> Protocol:
        return Protocol(
            **self.common(element, path),
            blocks=self.blocks(element, path),
            parameters=self.parameters(element, path),
        )

    # --- blocks ----------------------------------------------------------------------------------------

    def blocks(self, element: etree._Element, path: Path) -> tuple[Block, ...]:
        return tuple(self.block(child, path) for child in element if _tag(child) not in ("parameter", "on"))

    def block(self, element: etree._Element, path: Path) -> Block:
        # Where it is false the validator of missions says so, of files and of those built in Python.
        within_parallel = (parent := element.getparent()) is not None and _tag(parent) == "parallel"
        if not within_parallel and "mandatory" in element.attrib and _truth(element, "mandatory"):
            self.wrong(path, element, "mandatory is for children of a parallel block, expected none here")
        common: dict[str, Any] = self.common(element, path) | {
            "success": element.get("success"),
            "failure": element.get("failure"),
            "mandatory": _truth(element, "mandatory"),
            "retries": int(element.get("retries", "0")),
            "repeat": int(element.get("repeat", "1")) if "repeat" in element.attrib else None,
            "handlers": self.handlers(element, path),
        }
        tag = _tag(element)
        if tag == "parallel":
            return Parallel(**common, blocks=self.blocks(element, path))
        if tag == "each":
            common |= {"values": _names(element, "in"), "parameter": element.get("parameter")}
            return Each(**common, blocks=self.blocks(element, path))
        parameters = self.parameters(element, path)
        if tag == "use":
            return Use(**common, protocol=element.get("protocol", ""), parameters=parameters)
        if "activities" in element.attrib:
            common |= _numbers(element, "duration", "failure_probability")
            return Objective(**common, activities=_names(element, "activities"), parameters=parameters)
        return Recursive(**common, blocks=self.blocks(element, path), parameters=parameters)

    def handlers(self, element: etree._Element, path: Path) -> tuple[Handler, ...]:
        return tuple(
            Handler(
                event=child.get("event", ""),
                goto=child.get("goto", ""),
                once=_truth(child, "once", "false"),
                description=child.get("description"),
                source=_source(child, path),
            )
            for child in element
            if _tag(child) == "on"
        )

    def parameters(self, element: etree._Element, path: Path) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(**self.common(child, path), value=child.get("value", ""), unit=child.get("unit"))
            for child in element
            if _tag(child) == "parameter"
        )

    def common(self, element: etree._Element, path: Path) -> dict[str, Any]:
        return {
            "name": element.get("name", ""),
            "description": element.get("description"),
            "source": _source(element, path),
        }


def _tag(element: etree._Element) -> str:
    return etree.QName(element).localname


def _source(element: etree._Element, path: Path) -> Source:
    line = element.sourceline
    return Source(str(path), line if isinstance(line, int) else None)


def _names(element: etree._Element, attribute: str) -> tuple[str, ...]:
    return tuple(element.get(attribute, "").split())


def _truth(element: etree._Element, attribute: str, default: str = "true") -> bool:
    return element.get(attribute, default).strip() in ("true", "1")


def _numbers(element: etree._Element, *attributes: str) -> dict[str, float]:
    return {a: float(text) for a in attributes if (text := element.get(a)) is not None}
