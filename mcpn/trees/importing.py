"""Makes the files of a mission from a behaviour tree: mission, robot, protocols and the ledger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Unpack

from lxml import etree

from mcpn.mission.language.forms import NAMESPACE
from mcpn.mission.model import (
    Approximation,
    Import,
    Mission,
    Protocol,
    Protocols,
    Translated,
)
from mcpn.mission.robot import Activity, Alternative, Robot
from mcpn.mission.validate import valid
from mcpn.mission.writer import element_of
from mcpn.trees.controls import CONTROLS
from mcpn.trees.decorators import DECORATING, unknown
from mcpn.trees.ledger import Ledger, in_order, in_words, placed
from mcpn.trees.nav2 import NAV2
from mcpn.trees.nodes.forest import Forest
from mcpn.trees.options import TreeOptions
from mcpn.trees.py_trees import PY_TREES_RULES
from mcpn.trees.reactive import REACTIVE
from mcpn.trees.translator import BlockOrigin, Context, Translator, series_of
from mcpn.trees.tree_names import TreeNames

RULES = {**CONTROLS, **REACTIVE, **DECORATING, **NAV2, **PY_TREES_RULES}
"""How control nodes and decorators are translated, by the rule that the table of nodes names."""


@dataclass(frozen=True, slots=True)
class Imported:
    """A mission that was made of a tree.

    Args:
        mission: The mission with its robot and its protocols.
        ledger: What each node became.
        forest: The trees.
        origins: By block of the mission and of its protocols, as it is written, what it stands for.
        heard: By declared event, the block of the leaf that answers otherwise then, and whether well.
        silent: Objectives whose end no leaf decides, and whose outcome makes no difference.
    """

    mission: Mission
    ledger: Ledger
    forest: Forest
    origins: Mapping[str, BlockOrigin]
    heard: Mapping[str, tuple[str, bool]]
    silent: frozenset[str]


def translate(forest: Forest, name: str, file: str, *, faulty: bool = False) -> Imported:
    """Makes a mission of a tree.

    Args:
        forest: The trees.
        name: The name of the mission.
        file: What the file of the tree is called.
        faulty: Whether leaves may crash, so that cut sets name them.

    Returns:
        A valid mission and the ledger.

    Raises:
        InputError: A node has no translation, with its line.
    """
    at = Translator(forest, RULES, unknown)
    result = at.piece(forest.main.root, Context())
    at.done()
    if isinstance(result, bool):
        result = at.constant("idle", Context(), result, "at once")
    activities = tuple(
        Activity(
            name=activity,
            alternatives=(Alternative(name=activity),),
            faulty=faulty and leaf,
            description=None if leaf else _HELPERS[what],
        )
        for activity, (what, leaf) in at.activities.items()
    )
    robot = Robot(
        name=f"{name}_robot",
        facts=tuple(at.facts.values()),
        events=tuple(at.events.values()),
        activities=activities,
    )
    ledger = Ledger(file, in_order(at.entries), str(forest.choice), forest.warnings)
    mission = Mission(
        name=name,
        source=forest.main.source,
        translated=(_translated(ledger),),
        robots=(robot,),
        protocols=tuple(_used(at)),
        blocks=series_of(result),
    )
    return Imported(valid(mission), ledger, forest, at.origins, at.heard, frozenset(at.silent))


def imported_of(
    file: Path,
    name: str | None = None,
    *,
    more: Sequence[Path] = (),
    root: Path | None = None,
    **options: Unpack[TreeOptions],
) -> Imported:
    """The mission that the tree of a file or a folder becomes.

    Args:
        file: The file, or the folder.
        name: The name of the mission; by default that of the file.
        more: Further files of trees, which trees of the first one use.
        root: The folder that includes stay inside; by default that of the file.
        options: How the tree is read.

    Raises:
        InputError: Everything that is wrong with the tree, by file and line.
    """
    from mcpn.trees.reading import read_forest

    nodes, main, library = options.get("nodes", ()), options.get("main"), options.get("library", ())
    forest = read_forest(file, nodes, main, more=more, library=library, root=root)
    mission = TreeNames().fresh(file.stem) if name is None else name
    return translate(forest, mission, file.name, faulty=options.get("faulty_leaves", False))


def _translated(ledger: Ledger) -> Translated:
    """The ledger as the mission's file has it: what is not exact, in one entry for each node."""
    less = ledger.inexact
    return Translated(
        tree=ledger.file,
        library=ledger.read_as or None,
        exact=len(ledger.entries) - len(less),
        description="; ".join(placed(each, ledger.file) for each in ledger.warnings) or None,
        approximations=tuple(
            Approximation(
                node=entry.node.title,
                kind=entry.kind.value,
                line=entry.node.source.line,
                description=entry.why or None,
            )
            for entry in less
        ),
    )


_HELPERS = {
    "wait": "Waits: for a time, a stretch of way, news",
    "decide": "Decides what the tree decides by data, or goes on",
    "idle": "Does nothing",
}
"""What activities are for that are no leaves of the tree."""


def _used(at: Translator) -> list[Protocol]:
    return list(at.protocols.values())


def files_of(imported: Imported) -> dict[str, str]:
    """The files of a mission that was made of a tree, by name."""
    mission, ledger = imported.mission, imported.ledger
    head = _comment(in_words(ledger).split("\n\n", 1)[0] + "\nledger.txt says what each node became.")
    files = {}
    imports = ["robot.xml"]
    note = "One activity for each leaf: say what each consumes, and declare that as <hardware> or <software>."
    files["robot.xml"] = _text(element_of(mission.robots[0]), _comment(note))
    if mission.protocols:
        imports.append("protocols.xml")
        files["protocols.xml"] = _text(element_of(Protocols(protocols=mission.protocols)), head)
    root = element_of(replace(mission, robots=(), protocols=()))
    for place, href in enumerate(imports):
        made = etree.Element(f"{{{NAMESPACE}}}{Import.TAG}", href=href)
        root.insert(place, made)
    return {"mission.xml": _text(root, head), **files, "ledger.txt": in_words(ledger)}


def _comment(text: str) -> str:
    safe = text.replace("--", "- -").rstrip("-")
    return f"<!--\n{safe}\n-->\n"


def _text(root: etree._Element, comment: str) -> str:
    etree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{comment}{etree.tostring(root, encoding="unicode")}\n'
