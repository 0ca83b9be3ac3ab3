"""The missions that an open file is part of, with the texts that are typed and not saved."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from mcpn.answers.formula_errors import with_formulas
from mcpn.answers.requirements import asked_of
from mcpn.drawing.compose import MissionNet, compose_usage
from mcpn.editor.scan import Scan, scan
from mcpn.errors import InputError, LimitError, Problem
from mcpn.files import file_inside, read_bounded
from mcpn.mission.core.flattening import flatten
from mcpn.mission.fact_conditions import facts_of, objective_done
from mcpn.mission.language.incremental_reader import MissionDraft
from mcpn.mission.model import Import, Mission
from mcpn.mission.robot import Robot
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import static_warnings
from mcpn.mission.xml import MAX_FILE_BYTES, misfits_of, read_mission

MOST_TYPED = 3_000
"""Elements of a mission, beyond which its net is composed anew only when nothing is typed."""
MOST_FILES = 200
"""In how many files beside an open one, or above it, missions are looked for that import it."""


class Memory:
    """What was found of files, for when they are looked at again after an edit."""

    def __init__(self) -> None:
        self.scans = defaultdict[Path, Scan](Scan)
        self.drafts = defaultdict[Path, MissionDraft](MissionDraft)
        self.warnings: dict[Path, list[Problem]] = {}
        """By mission what was suspicious when that was last looked for."""
        self.nets: dict[Path, tuple[Mission, MissionNet]] = {}
        """By mission without its requirements the net that was composed of it."""


class Project:
    """Files of missions as an editor has them.

    Args:
        unsaved: By file its text, where that is typed and not saved; files are resolved.
        memory: What was found of these files before.
    """

    def __init__(self, unsaved: Mapping[Path, str], memory: Memory | None = None) -> None:
        self.unsaved = unsaved
        self.memory = memory or Memory()

    def text(self, file: Path) -> str | None:
        """The text of a file; ``None`` where it cannot be read, is no regular file, or is too large."""
        if file in self.unsaved:
            return self.unsaved[file]
        try:
            return read_bounded(file, MAX_FILE_BYTES).decode()
        except (InputError, ValueError):
            return None

    def scan(self, file: Path) -> Scan:
        """The elements of a file, as its text is now."""
        scan = self.memory.scans[file]
        scan.of(self.text(file) or "")
        return scan

    def missions(self, file: Path) -> list[Path]:
        """The missions that a file is part of: itself, or those near it that import it."""
        if self._root(file) == Mission.TAG:
            return [file]
        folders = (file.parent, file.parent.parent)
        found = [(folder, path.name) for folder in folders for path in sorted(folder.glob("*.xml"))]
        near = [path for folder, name in found[:MOST_FILES] if (path := _inside(name, folder, folder))]
        missions = [path for path in near if path != file and self._root(path) == Mission.TAG]
        return [mission for mission in missions if file in self.files(mission)]

    def files(self, mission: Path) -> list[Path]:
        """A mission's file and those that it may import, at any depth."""
        found = [mission]
        for file in found:
            for element in self.scan(file).elements:
                if element.tag == Import.TAG and (href := element.texts.get("href")):
                    target = _inside(href, file.parent, mission.parent)
                    if target is not None and target not in found:
                        found.append(target)
        return found

    def problems(self, file: Path, *, at_once: bool = False) -> tuple[list[Problem], list[Problem]]:
        """What is wrong in the missions that a file is part of, and what is suspicious, as ``check`` says it.

        Of a file without a mission, what does not fit the language is reported.

        Args:
            file: The file.
            at_once: Whether what was suspicious before is told, where nothing is wrong.
        """
        errors, warnings = dict[Problem, None](), dict[Problem, None]()
        missions = self.missions(file)
        for mission in missions:
            try:
                valid = read_mission(mission, unsaved=self.unsaved, draft=self.memory.drafts[mission])
                usage = cache(partial(_usage, valid))
                errors |= dict.fromkeys(self._misread(mission, valid, usage, at_once=at_once))
                if not at_once:
                    self.memory.warnings[mission] = static_warnings(usage())
                warnings |= dict.fromkeys(self.memory.warnings.get(mission, ()))
            except InputError as error:
                errors |= dict.fromkeys(with_formulas(error).problems)
            except LimitError as error:
                errors[Problem(None, str(error))] = None
        if not missions:
            errors |= dict.fromkeys(misfits_of(file, unsaved=self.unsaved))
        return list(errors), list(warnings)

    def _misread(
        self, file: Path, mission: Mission, usage: Callable[[], Usage], *, at_once: bool
    ) -> list[Problem]:
        """What is wrong with the formulas of a valid mission's requirements."""
        if not (mission.requirements or any(p.requirements for p in mission.protocols)):
            return []
        known = self.memory.nets.get(file)
        if known is not None and known[0] == _asked_nothing(mission):
            # What formulas alone have changed is another mission around the same net.
            net, required = replace(known[1], mission=mission), usage().graph.requirements
        elif at_once and sum(len(self.scan(f).elements) for f in self.files(file)) > MOST_TYPED:
            return []
        else:
            net, required = compose_usage(usage()), None
            self.memory.nets[file] = _asked_nothing(mission), net
        try:
            asked_of(net, required)
        except InputError as error:
            return list(error.problems)
        return []

    def together(self, file: Path) -> Iterator[Path]:
        """The files that name the same things as a file: those of its missions, or itself alone."""
        files = [f for mission in self.missions(file) for f in self.files(mission)]
        yield from dict.fromkeys([file, *files])

    def _root(self, file: Path) -> str:
        return next((element.tag for element in scan((self.text(file) or "")[:10_000])), "")


def _inside(name: str, folder: Path, root: Path) -> Path | None:
    """The file that a name in a folder means; ``None`` where it may not be read, or there is none."""
    try:
        return file_inside(name, folder, root).resolve()
    except InputError:
        return None


def _usage(mission: Mission) -> Usage:
    return Usage(mission, flatten(mission))


def _asked_nothing(mission: Mission) -> Mission:
    """A mission without its requirements, but with what they say is done, which its net keeps."""
    kept = tuple(fact for name, fact in facts_of(mission).items() if objective_done(name) is not None)
    robot = Robot(name="done", facts=kept)
    protocols = tuple(replace(protocol, requirements=()) for protocol in mission.protocols)
    return replace(mission, requirements=(), protocols=protocols, robots=(*mission.robots, robot))
