"""The controller in Python: the modules of :mod:`mcpn.robot.runtime` and its tables, in one file.

As a package of ROS 2 it is a lifecycle node around that file; events and actions are topics. The package lies
flat in one folder, which is put into a workspace.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from mcpn.robot.targets.btcpp import held
from mcpn.robot.targets.identifiers import PYTHON_KEYWORDS, comment, identifiers
from mcpn.robot.targets.json import write_json
from mcpn.robot.targets.render import render

PACKAGE = "mcpn.robot.runtime"


def write_python(document: Mapping[str, Any]) -> dict[str, str]:
    """The file by name.

    Args:
        document: The controller's.
    """
    name = identifiers([document["mission"]], keywords=PYTHON_KEYWORDS)[document["mission"]].lower()
    text = render(
        "controller.py.jinja",
        mission=comment(document["mission"]),
        controller=document,
        runtime=bundle("program"),
        # JSON has no three double quotes in a row, and ends in a brace: it can stand in a raw string.
        document=write_json(document),
    )
    return {f"{name}_controller.py": text}


@cache
def bundle(module: str) -> str:
    """A module of the runtime, and all modules of the runtime that it imports, as the text of one.

    Modules stand in the order of their imports. What they import of Python comes first, once.

    Args:
        module: Its name in the package.

    Raises:
        ValueError: The modules cannot stand in one: a name means two things, or an import gives another
            name to what it imports from the runtime.
    """
    found = _Bundle()
    found.add(module)
    return "\n".join((*sorted(found.plain), *found.from_python(), *found.texts.values()))


class _Bundle:
    """Modules that become one."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}  # by module, in order
        self.plain: set[str] = set()
        self.names: dict[str, set[str]] = {}  # by module of Python, what is imported from it
        self._means: dict[str, str] = {}

    def add(self, module: str) -> None:
        """Adds a module behind those that it imports, unless it is there."""
        if module in self.texts:
            return
        source = files(PACKAGE).joinpath(f"{module}.py").read_text(encoding="utf-8")
        tree, lines = ast.parse(source), source.split("\n")
        for node in tree.body:
            if self._goes(node, is_first=node is tree.body[0]):
                for line in range(node.lineno - 1, node.end_lineno or node.lineno):
                    lines[line] = ""
            for name in _bound(node):
                self._define(name, ast.dump(node))
        heading = "".join(f"# {line}".rstrip() + "\n" for line in (ast.get_docstring(tree) or "").split("\n"))
        text = "\n".join(lines).strip()
        self.texts[module] = f"\n# --- {PACKAGE}.{module} ---\n{heading}\n\n{text}\n"

    def _goes(self, node: ast.stmt, *, is_first: bool) -> bool:
        """Whether a statement of a module is left out of its text, after noting what it imports."""
        if isinstance(node, ast.Import):
            for alias in node.names:
                self.plain.add(ast.unparse(ast.Import([alias])))
                self._define(alias.asname or alias.name.partition(".")[0], alias.name)
            return True
        if isinstance(node, ast.ImportFrom):
            package, _, module = (node.module or "").rpartition(".")
            if package == PACKAGE:
                if any(alias.asname for alias in node.names):
                    raise ValueError(f"{ast.unparse(node)}: the runtime gives two names to one thing")
                self.add(module)
            else:
                for alias in node.names:
                    self.names.setdefault(node.module or "", set()).add(ast.unparse(alias))
                    self._define(alias.asname or alias.name, f"{node.module}.{alias.name}")
            return True
        return (is_first and isinstance(node, ast.Expr)) or "__all__" in _bound(node)

    def from_python(self) -> Iterator[str]:
        """The imports of names from Python's modules."""
        for module, names in sorted(self.names.items()):
            if module != "__future__":
                yield f"from {module} import {', '.join(sorted(names))}"

    def _define(self, name: str, meaning: str) -> None:
        if name != "__all__" and self._means.setdefault(name, meaning) != meaning:
            raise ValueError(f"two modules of the runtime mean different things by {name}")


def _bound(node: ast.stmt) -> set[str]:
    """Names that a statement of a module defines, imports aside."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.Assign | ast.AnnAssign):
        return {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return set()


def write_ros2(document: Mapping[str, Any]) -> dict[str, str]:
    """The files by name: the package's, the node, the controller in Python.

    Args:
        document: The controller's.
    """
    ((module, text),) = write_python(document).items()
    # ROS names packages in lower case, without two _ in a row.
    package = re.sub(r"[^a-z0-9]+", "_", document["mission"].lower()).strip("_")
    package = f"mission_{package}" if not package or package[0].isdigit() else f"{package}_mission"
    said = {
        "package": package,
        "module": module.removesuffix(".py"),
        "mission": comment(document["mission"]).replace('"', "'"),
        "holds": {f"{activity}.{way}": names for (activity, way), names in held(document).items()},
        "hardware": [name for name in document["hardware"] if name not in document["crashing"]],
    }
    files = {name: render(f"ros2_{name}.jinja", **said) for name in ("package.xml", "setup.py", "setup.cfg")}
    return {
        **files,
        package: f"{package}\n",
        "__init__.py": f'"""The mission {said["mission"]}. Generated by mcpn."""\n',
        "node.py": render("ros2_node.py.jinja", **said),
        module: text,
    }
