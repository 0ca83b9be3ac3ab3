"""Sequences of events that take every edge of a mission's controller, as tests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import FILE, emit_json, import_option, json_option, limit_option, templates_option

if TYPE_CHECKING:
    from mcpn.drawing.templates import TemplateSet


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the tests to.")
@limit_option
@import_option
@templates_option
@json_option
def tests(
    mission: Path,
    output: Path,
    max_states: int | None,
    import_root: Path | None,
    templates: TemplateSet | None,
    as_json: bool,
) -> None:
    """Write sequences of events that take every edge of the controller of MISSION.

    They are for a robot's own code: test_controller.py for pytest, events.txt and expected.txt for a program
    that reads lines, as the example of the C target does.
    """
    from mcpn.bench.sequences import files, sequences
    from mcpn.controller.targets.json import FILE_NAME, document, write_json
    from mcpn.files import write_folder
    from mcpn.opening import open_study
    from mcpn.runtime.tables import Tables

    study = open_study(mission, import_root=import_root, templates=templates)
    controller = study.controller("hierarchical", max_states=max_states)
    found = sequences(Tables(document(controller, study.mission_net)))
    texts = dict(files(found, controller.mission)) | {FILE_NAME: write_json(controller, study.mission_net)}
    write_folder(output, texts)
    told = {
        "mission": controller.mission,
        "edges": found.edges,
        "sequences": len(found.each),
        "events": sum(map(len, found.each)),
        "files": [str(output / name) for name in texts],
    }
    if as_json:
        emit_json(told)
        return
    click.echo(
        f"{told['sequences']:,} sequences of {told['events']:,} events take all {told['edges']:,} edges "
        f"of the controller of {told['mission']}"
    )
    for path in texts:
        click.echo(str(output / path))
