"""Reads behaviour trees: the XML of BehaviorTree.CPP 3 and 4 and of py_trees, with includes and models.

Files are untrusted as missions are (:mod:`mcpn.xmlio`): no DTD, no entities, bounded size, depth and number;
includes stay inside one folder. All problems of all files are raised in one go.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from types import MappingProxyType

from lxml import etree

from mcpn.errors import InputError, Problem, Source
from mcpn.files import OutsideError, file_inside, read_bounded
from mcpn.trees.doubts import doubts
from mcpn.trees.nodes.choosing import choose
from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import ATTRIBUTES, OF_EDITORS, Tree, TreeNode
from mcpn.trees.nodes.scripts import script_problems
from mcpn.trees.nodes.table import TABLE, rows_of
from mcpn.trees.nodes.versions import BTCPP, NAV2
from mcpn.trees.nodes.versions import asked as asked_for
from mcpn.trees.tolerant import escaped
from mcpn.xmlio import line_of, parse_bytes

MAX_BYTES = 16 << 20
MAX_FILES = 1000
MAX_NODES = 200_000
MAX_DEPTH = 64
EXPLICIT = ("Action", "Condition", "Control", "Decorator", "SubTree", "SubTreePlus")
"""Elements whose attribute ID says which node it is."""
_MODELS = (*EXPLICIT[:5],)
_PORTS = ("input_port", "output_port", "inout_port", "bidirectional_port")
ELEMENTS = MappingProxyType(
    {
        "root": (
            ("BTCPP_format", "main_tree_to_execute", "project_name"),
            ("include", "Import", "Include", "BehaviorTree", "TreeNodesModel"),
        ),
        "include": (("path", "ros_pkg"), ()),
        "Import": (("src", "file"), ()),
        "Include": (("src", "file"), ()),
        "BehaviorTree": (("ID", *OF_EDITORS), None),
        "TreeNodesModel": ((), _MODELS),
        **dict.fromkeys(_MODELS, (("ID", "editable"), (*_PORTS, "MetadataFields", "description"))),
        **dict.fromkeys(_PORTS, (("name", "type", "default"), ())),
        "MetadataFields": ((), ("Metadata",)),
        "Metadata": (None, ()),
        "description": ((), ()),
    }
)
"""Elements around nodes: attributes, and elements inside; ``None`` where all are allowed.

``project_name``, ``editable``, ``MetadataFields`` and ``description`` are of editors and mean nothing, as
do types and defaults of ports in models: data is not modelled. Any other element inside a tree is a node. Its
attributes are ``name``, ``ID`` in the explicit form, ports by the table of nodes, and those of
:data:`mcpn.trees.nodes.node.ATTRIBUTES`.
"""

_NO_NODES = frozenset(("root", "include", "BehaviorTree", "TreeNodesModel", "MetadataFields", *_PORTS))
"""Elements around nodes that stand inside a tree by mistake: none is taken for an activity of that name."""

_SPELLED = {
    row.node.lower(): row.node
    for row in TABLE
    if row.library in (BTCPP, NAV2)
    and (row.role in ("Control", "Decorator") or row.rule in ("succeeds", "fails"))
}


def spelled(tag: str) -> str:
    """The registered name that a tag means: some files write ``inverter``."""
    return tag if tag in _SPELLED.values() else _SPELLED.get(tag.lower(), tag)


def read_forest(
    path: Path,
    models: Sequence[Path] = (),
    main: str | None = None,
    *,
    more: Sequence[Path] = (),
    library: Iterable[str] = (),
    root: Path | None = None,
) -> Forest:
    """Reads a file of trees with all that it includes, or all files of trees in a folder.

    Args:
        path: The file, or the folder.
        models: Further files with a ``TreeNodesModel``, which say what is an action and what a condition.
        main: The tree to execute; by default what the file says, or its only tree that no other uses.
        more: Further files of trees, which trees of the first one use.
        library: Versions of libraries that the trees are for: ``nav2=1.5``.
        root: The folder that includes stay inside; by default that of the file.

    Returns:
        The trees; every node has its file and line.

    Raises:
        InputError: Everything that is wrong, by file and line.
    """
    wanted = asked_for(library)
    files = [*_files(path), *more]
    reader = _Reader((root or (path if path.is_dir() else path.parent)).resolve())
    for model in models:
        reader.models(model)
    for place, file in enumerate(files):
        if file.resolve() not in reader.seen:
            reader.file(file, file.name, own=not place or path.is_dir(), among=path.is_dir())
    trees = reader.trees
    if reader.problems:
        raise InputError(reader.problems)
    executed = trees[_main(reader, main, Source(str(path), reader.root_line))]
    nodes = [node for tree in trees.values() for node in tree.root.walk()]
    choice, problems = choose(nodes, frozenset(trees), reader.formats, wanted)
    forest = Forest(trees, executed, reader.categories, choice)
    refused, told = script_problems(nodes, choice)
    problems += [*refused, *_cycles(forest), *_named_as_nodes(forest)]
    if problems:
        raise InputError(problems)
    warnings = (*reader.warnings, *doubts(forest, reader.ports, reader.spelt), *told)
    return replace(forest, warnings=warnings)


def is_tree(path: Path) -> bool:
    """Whether the first element of a file, or of one in a folder, is that of behaviour trees."""
    if path.is_dir():
        return any(is_tree(each) for each in islice(path.rglob("*.xml"), MAX_FILES) if each.is_file())
    try:
        text = read_bounded(path, MAX_BYTES).decode("utf-8-sig", "replace")
    except InputError:
        return False
    while (text := text.lstrip()).startswith(("<?", "<!--")):
        _, closed, text = text.partition("?>" if text.startswith("<?") else "-->")
        if not closed:
            return False
    return re.match(r"<root[\s/>]", text) is not None


def _files(path: Path) -> list[Path]:
    """The files that a path means."""
    if not path.is_dir():
        return [path]
    found = sorted(each for each in path.rglob("*.xml") if each.is_file())
    if not found:
        raise InputError.at(Source(str(path)), "no file *.xml in this folder, expected files of trees")
    if len(found) > MAX_FILES:
        raise InputError.at(
            Source(str(path)), f"{len(found)} files in this folder, expected at most {MAX_FILES}"
        )
    return found


def _main(reader: _Reader, asked: str | None, at: Source) -> str:
    """The tree to execute."""
    trees = reader.trees
    if not trees:
        raise InputError.at(at, "found no <BehaviorTree>, expected at least one")
    said = list(dict.fromkeys(reader.mains))
    main = asked or (said[0] if len(said) == 1 else None)
    if main is None and not said:
        inside = {node.id for tree in trees.values() for node in tree.root.walk()}
        alone = [name for name in reader.own if name not in inside]
        alone = reader.own if len(reader.own) == 1 else alone
        main = alone[0] if len(alone) == 1 else None
    if main is None:
        named = ", ".join(said or sorted(trees))
        several = "several files say main_tree_to_execute" if said else "no main_tree_to_execute"
        raise InputError.at(at, f"{several}, expected one of {named}: say it with --main")
    if main not in trees:
        raise InputError.at(at, f"no tree {main!r} to execute, expected one of {', '.join(sorted(trees))}")
    return main


class _Reader:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []
        self.trees: dict[str, Tree] = {}
        self.own: list[str] = []  # identifiers in the files that were named
        self.mains: list[str] = []  # what these say is to be executed
        self.formats: list[str | None] = []
        self.categories: dict[str, str] = {}
        self.ports: dict[str, dict[str, bool]] = {}  # by name in models, and whether each must be given
        self.spelt: dict[int, str] = {}  # by node, how its name is written
        self.seen: set[Path] = set()
        self.nodes = 0
        self.root_line = 1

    def models(self, path: Path) -> None:
        """Reads node models from a file that holds nothing else."""
        root = self.parsed(path)
        if root is None:
            return
        found = [root] if root.tag == "TreeNodesModel" else root.findall("TreeNodesModel")
        if not found:
            self.wrong(Source(str(path), 1), "expected <TreeNodesModel>, found none")
        for model in found:
            self.model(model, path)

    def model(self, element: etree._Element, path: Path) -> None:
        for each in element.iter(etree.Element):
            self.known(each, path, parent=each.getparent() if each is not element else None)
        for each in element:
            if each.get("ID"):
                self.category(str(each.get("ID")), _tag(each), Source(str(path), line_of(each)))
                ports = [port for port in each if _tag(port) in _PORTS]
                self.ports[str(each.get("ID"))] = {
                    str(port.get("name")): not port.get("default") for port in ports
                }

    def category(self, name: str, said: str, source: Source) -> None:
        """Takes what a model says a node is; one that says otherwise than another before it is warned of."""
        before = self.categories.get(name, said)
        if before != said:
            both = f"{name} is {said} here and {before} in another model"
            self.warnings.append(Problem(source, f"{both}: {said} counts"))
        self.categories[name] = said

    def known(self, element: etree._Element, path: Path, parent: etree._Element | None = None) -> None:
        """Holds an element that is no node to the table of elements."""
        tag, source = _tag(element), Source(str(path), line_of(element))
        inside = None if parent is None else ELEMENTS.get(_tag(parent), ((), ()))[1]
        if inside is not None and tag not in inside:
            expected = " or ".join(f"<{each}>" for each in inside) or "nothing"
            self.wrong(source, f"found <{tag}> in <{_tag(parent)}>, expected {expected}")  # type: ignore[arg-type]
            return
        attributes, _ = ELEMENTS[tag]
        for key in element.attrib if attributes is not None else ():
            if str(key) in attributes:  # type: ignore[operator]
                continue
            if str(key).startswith("_"):
                self.warnings.append(Problem(source, f"<{tag}>: attribute {key!s} means nothing"))
            else:
                expected = ", ".join(attributes) if attributes else "none"
                self.wrong(source, f"<{tag}> has no attribute {str(key)!r}, expected {expected}")

    def parsed(self, path: Path) -> etree._Element | None:
        """The root of a file; ``None`` where it is none, which is a problem."""
        try:
            data = read_bounded(path, MAX_BYTES)
            try:
                return parse_bytes(path, data)
            except InputError:
                root = self.as_tinyxml2(path, data)
                if root is None:
                    raise
                return root
        except InputError as error:
            self.problems.extend(error.problems)
            return None

    def as_tinyxml2(self, path: Path, data: bytes) -> etree._Element | None:
        """A file with ``&`` and ``<`` in attributes; ``None`` where something else is wrong with it."""
        try:
            text, lines = escaped(data.decode("utf-8-sig"))
            root = parse_bytes(path, text.encode(), "utf-8") if lines else None
        except (UnicodeDecodeError, InputError):
            return None
        if root is not None:
            said = "& or < in an attribute is no XML, write &amp; and &lt;: it is read as tinyxml2 reads it"
            self.warnings += [Problem(Source(str(path), line), said) for line in lines]
        return root

    def file(self, path: Path, shown: str, *, own: bool = False, among: bool = False) -> None:
        """Reads one file of trees and what it includes.

        Args:
            path: The file.
            shown: What it is called in problems.
            own: Whether its trees may be the one to execute.
            among: Whether it is one of a folder, which may hold other XML.
        """
        self.seen.add(path.resolve())
        root = self.parsed(path)
        if root is None:
            return
        here = Source(str(path), line_of(root))
        if _tag(root) != "root":
            said = f"expected <root> of a behaviour tree, found <{_tag(root)}>"
            self.warnings.append(Problem(here, f"{said}: not read")) if among else self.wrong(here, said)
            return
        self.known(root, path)
        version = root.get("BTCPP_format")
        if version not in (None, "3", "4"):
            self.wrong(here, f"BTCPP_format {version!r}, expected 3 or 4")
            return
        self.formats.append(version)
        if own:
            self.root_line = line_of(root) if len(self.seen) == 1 else self.root_line
            self.mains += [main] if (main := root.get("main_tree_to_execute")) else []
        for element in root.iterchildren(etree.Element):
            self.top(element, root, path, shown, own=own)

    def top(
        self, element: etree._Element, root: etree._Element, path: Path, shown: str, *, own: bool
    ) -> None:
        """Reads an element inside the root."""
        tag, source = _tag(element), Source(str(path), line_of(element))
        if tag not in ("include", "Import", "Include", "BehaviorTree", "TreeNodesModel"):
            expected = "expected <include>, <BehaviorTree> or <TreeNodesModel>"
            self.wrong(source, f"found <{tag}>, {expected}")
            return
        self.known(element, path, root)
        if tag == "TreeNodesModel":
            self.model(element, path)
        elif tag == "BehaviorTree":
            if tree := self.tree(element, path, source, shown):
                self.own += [tree] if own else []
        else:
            for inside in element.iterchildren(etree.Element):
                self.known(inside, path, element)
            self.include(element, path, source)

    def included(self, href: str, folders: list[Path]) -> tuple[Path | None, InputError | None]:
        """The first file of a name in some folders, or why there is none in the first of them."""
        why: InputError | None = None
        for folder in folders:
            try:
                return file_inside(href, folder, self.folder), None
            except InputError as error:
                why = why or error
        return None, why

    def include(self, element: etree._Element, path: Path, source: Source) -> None:
        href = element.get("path") or element.get("src") or element.get("file")
        if not href:
            self.wrong(source, "include without a path")
            return
        package = element.get("ros_pkg")
        # As BT.CPP: relative to the including file; some write it relative to the main file.
        folders = [path.parent, self.folder]
        if package:
            folders = [self.folder / package, self.folder / "share" / package]
        target, why = self.included(href, folders)
        if isinstance(why, OutsideError):
            self.wrong(
                source, f"include of {href} leaves the folder of the main file: --import-root says another"
            )
        elif why is not None and package:
            said = f"include of a file in package {package!r}: no {href} in a folder of that name"
            self.wrong(source, f"{said}, give a plain path, or the folder of packages with --import-root")
        elif target is None:
            self.wrong(source, f"include of {why}")
        elif target.resolve() not in self.seen:
            if len(self.seen) >= MAX_FILES:
                self.wrong(source, f"include of {href}: more than {MAX_FILES} files, the limit on includes")
            else:
                self.file(target, href)

    def tree(self, element: etree._Element, path: Path, source: Source, shown: str) -> str | None:
        name = element.get("ID") or path.stem
        children = list(element.iterchildren(etree.Element))
        self.text(element, source)
        if len(children) != 1:
            self.wrong(source, f"tree {name} has {len(children)} roots, expected one")
            return None
        if name in self.trees:
            self.wrong(source, f"there is already a tree {name!r} ({self.trees[name].source}), in {shown}")
            return None
        root = self.node(children[0], path, 1)
        if root is None:
            return None
        self.trees[name] = Tree(name, root, source)
        return name

    def text(self, element: etree._Element, source: Source) -> None:
        """Warns of text, which the libraries skip."""
        texts = (element.text, *(child.tail for child in element))
        if any(text and text.strip() for text in texts):
            self.warnings.append(Problem(source, f"<{_tag(element)}> holds text, which means nothing"))

    def node(self, element: etree._Element, path: Path, depth: int) -> TreeNode | None:
        source = Source(str(path), line_of(element))
        self.nodes += 1
        if depth > MAX_DEPTH or self.nodes > MAX_NODES:
            limit = (
                f"nested more than {MAX_DEPTH} deep" if depth > MAX_DEPTH else f"more than {MAX_NODES} nodes"
            )
            self.wrong(source, f"{limit}, the limit of trees")
            return None
        tag = _tag(element)
        attributes = {str(key): str(value) for key, value in element.attrib.items()}
        if tag in _NO_NODES:
            self.wrong(source, f"found <{tag}> inside a tree, expected a node")
            return None
        explicit = tag in EXPLICIT
        name = attributes.pop("name", None) or None
        if explicit != bool(attributes.get("ID")):
            said = (
                f"<{tag}> without ID"
                if explicit
                else f"<{tag}> has no attribute 'ID', which <Action> and its kin have"
            )
            self.wrong(source, said)
            return None
        written = attributes.pop("ID") if explicit else tag
        category = "SubTree" if tag == "SubTreePlus" else tag if explicit else ""
        id_ = written if category == "SubTree" else spelled(written)
        self.text(element, source)
        inside = list(element.iterchildren(etree.Element))
        if category == "SubTree":  # version 3 writes ports as elements, too
            attributes |= {str(c.get("internal")): f"{{{c.get('external')}}}" for c in inside if _is_remap(c)}
            inside = [child for child in inside if not _is_remap(child)]
        children = [self.node(child, path, depth + 1) for child in inside]
        if any(child is None for child in children):
            return None
        if category == "SubTree" and children:
            self.wrong(source, f"{id_} has {len(children)} children, expected 0: a SubTree has none")
            return None
        rules = {key: value for key, value in attributes.items() if key.startswith("_")}
        for rule in rules.keys() - set(ATTRIBUTES):
            meant = next((known for known in ATTRIBUTES if known.lower() == rule.lower()), None)
            hint = f", {meant} does" if meant else ""
            self.warnings.append(Problem(source, f"{id_}: attribute {rule} means nothing{hint}"))
        ports = {key: value for key, value in attributes.items() if not key.startswith("_")}
        found = tuple(child for child in children if child is not None)
        made = TreeNode(id_, category, name, ports, rules, found, source)
        if written != id_:
            self.spelt[id(made)] = written
        return made

    def wrong(self, source: Source, message: str) -> None:
        self.problems.append(Problem(source, message))


def _is_remap(element: etree._Element) -> bool:
    """Whether an element inside of a use of a tree names one port: internal, external."""
    return (
        _tag(element) == "remap"
        and {*map(str, element.attrib)} == {"internal", "external"}
        and not len(element)
    )


def _tag(element: etree._Element) -> str:
    """The name of an element as it is written: libraries of trees know no namespaces."""
    local = str(element.tag).rpartition("}")[2]
    return f"{element.prefix}:{local}" if element.prefix else local


def _named_as_nodes(forest: Forest) -> Iterator[Problem]:
    """Trees with the name of a node that BehaviorTree.CPP has: which of both is meant is not known."""
    for tree in forest.trees.values() if BTCPP in forest.choice.libraries else ():
        if rows_of(tree.id, (BTCPP,)):
            said = f"tree {tree.id!r} has the name of a node of BehaviorTree.CPP"
            yield Problem(tree.source, f"{said}, expected another name")


def _cycles(forest: Forest) -> Iterator[Problem]:
    """What is wrong with the use of trees in trees: none of that name, or one that holds itself."""
    state: dict[str, int] = {}
    stack: list[tuple[str, list[TreeNode]]] = []

    def uses(tree: Tree) -> list[TreeNode]:
        return [n for n in tree.root.walk() if tree_of(forest, n) is not None or n.category == "SubTree"]

    for start in forest.trees:
        if start in state:
            continue
        state[start] = 1
        stack.append((start, uses(forest.trees[start])))
        while stack:
            name, todo = stack[-1]
            if not todo:
                state[name] = 2
                stack.pop()
                continue
            node = todo.pop()
            if node.id not in forest.trees:
                known = ", ".join(sorted(forest.trees))
                yield Problem(node.source, f"no tree {node.id!r}, expected one of {known}")
            elif state.get(node.id) == 1:
                yield Problem(node.source, f"tree {node.id} holds itself")
            elif node.id not in state:
                state[node.id] = 1
                stack.append((node.id, uses(forest.trees[node.id])))
