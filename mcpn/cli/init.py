"""Files to start a mission from: a small one, an example, or what a behaviour tree becomes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.options import FILE, json_option, tree_options
from mcpn.cli.printed import emit_json
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from collections.abc import Iterable
    from importlib.abc import Traversable

    from mcpn.trees.importing import Imported
    from mcpn.trees.options import TreeOptions

FILES = ("mission.xml", "robot.xml", "protocols.xml")


PLAYED = ("drivers.toml", "played.py")
"""What the small mission runs with: drivers that play a robot."""


EXAMPLES = ("courier", "drone", "glider", "rover", "ulysse")
"""Missions of different robots; ulysse is the paper's."""


@click.command()
@click.argument("folder", type=FILE, metavar="NAME")
@click.option("--example", type=click.Choice(EXAMPLES), help="Write this mission; ulysse is the paper's.")
@click.option(
    "--from",
    "trees",
    type=FILE,
    multiple=True,
    metavar="TREE",
    help="Translate this behaviour tree, a file or a folder (XML of BehaviorTree.CPP 3 or 4, with nodes of "
    "Nav2 and PlanSys2, or of py_trees). May be repeated for files whose trees it uses.",
)
@click.option("--import-root", type=FILE, help="With --from: the folder that includes must stay in.")
@tree_options
@json_option
def init(
    folder: Path,
    example: str | None,
    trees: tuple[Path, ...],
    import_root: Path | None,
    of_tree: TreeOptions,
    as_json: bool,
) -> None:
    """Write a small mission to start from into the new folder NAME, or one of the examples.

    With the small one come drivers that play its robot, so that mcpn run runs it. With --from it is a
    behaviour tree as a mission, with a ledger of what each node became.
    """
    from mcpn.files import write_folder
    from mcpn.mission.language.datatypes import NAME

    name = folder.name
    if not NAME.matches(name):
        raise InputError.at(None, f"a mission cannot be called {name!r}, expected {NAME.expected}")
    if trees:
        if example is not None:
            raise click.UsageError("--from and --example exclude each other")
        from mcpn.trees.importing import imported_of

        made = imported_of(trees[0], name, more=trees[1:], root=import_root, **of_tree)
        _import(folder, made, as_json)
        return
    if any(of_tree.values()) or import_root is not None:
        raise click.UsageError("--main, --nodes, --library, --import-root and --faulty-leaves need --from")
    files = FILES if example is not None else (*FILES, *PLAYED)
    _not_there(folder, files)
    texts = {file: _start(example).joinpath(file).read_text(encoding="utf-8") for file in files}
    if example is None:
        texts = {file: text.replace("NAME", name) for file, text in texts.items()}
    write_folder(folder, texts)
    paths = [str(folder / file) for file in files]
    if as_json:
        emit_json({"files": paths})
    else:
        click.echo("\n".join(paths))
        click.echo(f"verify it: mcpn check {folder / FILES[0]}", err=True)
        if example is None:
            click.echo(f"run it: mcpn run {folder / FILES[0]} --drivers {folder / PLAYED[0]}", err=True)


def _import(folder: Path, imported: Imported, as_json: bool) -> None:
    """Writes a behaviour tree as a mission, and says what each kind of node became."""
    from mcpn.files import write_folder
    from mcpn.trees.importing import files_of
    from mcpn.trees.ledger import SURVIVES, in_words

    files = files_of(imported)
    _not_there(folder, files)
    write_folder(folder, files)
    paths = [str(folder / file) for file in files]
    ledger = imported.ledger
    if as_json:
        counts = {kind.value: count for kind, count in ledger.counts.items()}
        told = {"counts": counts, "survives": SURVIVES[ledger.kind], "read_as": ledger.read_as}
        emit_json({"files": paths, "ledger": told})
    else:
        click.echo("\n".join(paths))
        click.echo(in_words(ledger).split("\n\n", 1)[0], err=True)
        click.echo(f"verify it: mcpn check {folder / FILES[0]}", err=True)


def _not_there(folder: Path, files: Iterable[str]) -> None:
    for file in files:
        if (folder / file).exists():
            raise InputError.at(Source(str(folder / file)), "exists already, and is not overwritten")


def _start(example: str | None) -> Traversable:
    """The folder of the files to start from."""
    from importlib import resources  # which takes milliseconds to load

    if example is None:
        return resources.files("mcpn.cli.start")
    installed = resources.files("mcpn").joinpath("examples", example)
    checkout = Path(__file__).resolve().parents[2] / "experiments" / example
    return installed if installed.is_dir() else checkout
