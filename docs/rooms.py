"""Draws the rooms of mcpn by what they import, in the page on the architecture.

Each line holds rooms that import none of each other, and only rooms of lines above. Of what a room imports
those are named that no other of them imports in turn. A waist stands behind the room that makes it.
"""

from __future__ import annotations

import re
from pathlib import Path

import networkx

PACKAGE = Path(__file__).resolve().parents[1] / "mcpn"
PAGE = Path(__file__).with_name("architecture.md")
BASE = "base"
WAISTS = {
    "mission/core/objectives_graph.py": "the objectives graph",
    "spaces/algebra.py": "a space",
    "controller/document.py": "the controller's document",
}
"""The files of the three waists, with what each makes."""
READ = {"controller/document.py": ("robot",)}
"""Who reads what a waist makes, and need not import it: a document is a file."""
IMPORTS = re.compile(r"^ *from mcpn\.([\w.]+) import", re.MULTILINE)
WIDTH = 34
"""Of one room in a line."""


def imports() -> dict[str, set[str]]:
    """By module what it imports of mcpn, as paths below the package."""
    return {
        path.relative_to(PACKAGE).as_posix(): {
            name.replace(".", "/") for name in IMPORTS.findall(path.read_text())
        }
        for path in PACKAGE.rglob("*.py")
        if path.parent != PACKAGE or path.name != "__init__.py"
    }


def room(name: str) -> str:
    """The room of a module: a folder, or a file beside the folders that imports some; else the base."""
    first = name.partition("/")[0].removesuffix(".py")
    return first if first in ROOMS else BASE


FOUND = imports()
MODULES = {name.removesuffix(".py") for name in FOUND if "/" not in name}
ROOMS = {name.partition("/")[0] for name in FOUND if "/" in name}
ROOMS |= {name for name in MODULES if any(each.partition("/")[0] in ROOMS for each in FOUND[f"{name}.py"])}


def graph() -> networkx.DiGraph[str]:
    """The rooms, with an edge from each to those that import it."""
    found: networkx.DiGraph[str] = networkx.DiGraph()
    for name, of in FOUND.items():
        found.add_edges_from((room(each), room(name)) for each in of if room(each) != room(name))
    return found


def readers(waist: str) -> list[str]:
    """The rooms that import the module of a waist, or read what it makes."""
    module = waist.removesuffix(".py")
    own = room(waist)
    return sorted({room(name) for name, of in FOUND.items() if module in of} - {own} | {*READ.get(waist, ())})


def picture() -> str:
    """The rooms, line by line, and the waists."""
    whole = graph()
    direct = networkx.transitive_reduction(whole)
    lines = ["```text"]
    for layer in networkx.topological_generations(whole):
        said = [
            f"{shown(each)} ◄ {', '.join(map(shown, sorted(direct.predecessors(each))))}".removesuffix(" ◄ ")
            for each in sorted(layer)
        ]
        if BASE in layer:
            said = [f"{BASE} ({', '.join(sorted(name for name in MODULES - ROOMS if name[0] != '_'))})"]
        lines.append("".join(f"{each:<{WIDTH}}" for each in said).rstrip())
        for waist, made in WAISTS.items():
            if room(waist) in layer:
                lines.append(f"════ {made} ({waist}), read by {', '.join(map(shown, readers(waist)))}")
    return "\n".join([*lines, "```"])


def shown(name: str) -> str:
    """A room as the page names it."""
    return f"{name}/" if (PACKAGE / name).is_dir() else name


def renewed(page: str) -> str:
    """The page with its picture drawn anew."""
    before, begin, rest = page.partition("<!-- rooms -->\n")
    _, end, after = rest.partition("<!-- end -->")
    return "".join((before, begin, picture(), "\n", end, after))


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text()))
