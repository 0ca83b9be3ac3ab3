"""Sequences of events that take every edge of a mission's controller, as tests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json

if TYPE_CHECKING:
    from mcpn.study import Study
    from mcpn.trees.importing import Imported


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, help="Directory to write the tests to.")
@click.option(
    "--btcpp",
    type=FILE,
    metavar="FILE",
    help="Write runs to failure and minimal sets as substitution rules of BehaviorTree.CPP, with --tree.",
)
@click.option("--tree", type=FILE, help="With --btcpp: the behaviour tree that the mission was made of.")
@question()
def tests(
    question: Question,
    mission: Path,
    output: Path | None,
    btcpp: Path | None,
    tree: Path | None,
) -> None:
    """Write sequences of events that take every edge of the controller of MISSION.

    They are for a robot's own code: test_controller.py for pytest, events.txt and expected.txt for a program
    that reads lines, as the example of the C target does.

    With --btcpp they are for the tree that a mission was made of (mcpn init --from): what its leaves answer
    on a run on which nothing fails and on runs to failure, and leaves that always fail.
    """
    of_tree, question = question.of_tree or {}, replace(question, of_tree=None)
    if (btcpp is None) != (tree is None) or (btcpp is None and any(of_tree.values())):
        raise click.UsageError("--btcpp and --tree need each other; --main, --nodes and --library need both")
    if (output is None) == (btcpp is None):
        raise click.UsageError("expected either -o or --btcpp")
    if btcpp is not None and tree is not None:
        from mcpn.files import keep_apart
        from mcpn.trees.importing import imported_of

        study = question.study(mission)
        keep_apart([btcpp], [mission, *study.mission.files, tree])
        made = imported_of(tree, study.mission_net.mission.name, root=question.import_root, **of_tree)
        _mocks(study, btcpp, tree, made, question)
        return
    assert output is not None
    from mcpn.controller.document import document
    from mcpn.files import write_folder
    from mcpn.robot.bench.sequences import files, sequences
    from mcpn.robot.runtime.controller_tables import Tables
    from mcpn.robot.targets.json import FILE_NAME, write_json

    study = question.study(mission)
    controller = study.controller("hierarchical")
    said = document(controller, study.mission_net)
    found = sequences(Tables(said))
    texts = dict(files(found, controller.mission)) | {FILE_NAME: write_json(said)}
    write_folder(output, texts)
    told = {
        "mission": controller.mission,
        "edges": found.edges,
        "sequences": len(found.each),
        "events": sum(map(len, found.each)),
        "files": [str(output / name) for name in texts],
    }
    if question.as_json:
        emit_json(told)
        return
    click.echo(
        f"{told['sequences']:,} sequences of {told['events']:,} events take all {told['edges']:,} edges "
        f"of the controller of {told['mission']}"
    )
    for path in texts:
        click.echo(str(output / path))


def _mocks(study: Study, output: Path, tree: Path, imported: Imported, question: Question) -> None:
    """Writes tests of the tree that a mission was made of."""
    import json

    from mcpn.files import write_atomically
    from mcpn.tree_tests import document, mocks

    mission_net = study.mission_net
    checked = study.verdicts()
    found = mocks(imported, mission_net, checked, study.causes())
    written = document(found, mission_net.mission.name, tree.name)
    write_atomically(output, json.dumps(written, indent=1) + "\n")
    if question.as_json:
        told = {key: written[key] for key in ("mission", "tree", "left_out")}
        emit_json({**told, "scenarios": len(found.scenarios), "files": [str(output)]})
        return
    click.echo(f"{len(found.scenarios):,} tests of {tree.name}")
    for name, why in found.left_out:
        click.echo(f"  left out: {name}: {why}")
    click.echo(str(output))
