"""The report: everything that is found of a mission, on one page, written or served."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import (
    EXIT_FAILED,
    FILE,
    emit_json,
    engine_option,
    import_option,
    jobs_option,
    json_option,
    limit_option,
    scheduler_option,
    templates_option,
    without_threads_of_numpy,
)
from mcpn.errors import InputError, Source
from mcpn.report.progress import progress_on_terminal
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from mcpn.drawing.templates import TemplateSet
    from mcpn.spaces.engines import Asked


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The page to write, FILE.html.")
@engine_option()
@jobs_option
@scheduler_option
@limit_option
@import_option
@templates_option
@json_option
def report(
    mission: Path,
    output: Path,
    engine: Asked,
    jobs: int,
    scheduler: str | None,
    max_states: int | None,
    import_root: Path | None,
    templates: TemplateSet | None,
    as_json: bool,
) -> None:
    """Write a report of MISSION as one HTML page: drawing, verdicts, causes, a controller to click through.

    The page opens from disk, needs no network, and can be printed or sent.
    """
    without_threads_of_numpy()
    from mcpn.files import write_atomically
    from mcpn.opening import open_study
    from mcpn.report.page import page
    from mcpn.workers import workers_of

    if output.suffix.lower() not in (".html", ".htm"):
        source = Source(str(output))
        raise InputError.at(source, f"found the suffix {output.suffix!r}, expected .html")
    study = open_study(mission, import_root=import_root, templates=templates)
    with progress_on_terminal(), workers_of(jobs, scheduler):
        found = study.findings(engine=engine, max_states=max_states)
        step(Doing.PREPARING, question="the page")
        text = page(found)
    write_atomically(output, text)
    if as_json:
        size = len(text.encode())
        emit_json({"file": str(output), "bytes": size, "engine": found.engine, "passed": found.check.passed})
    else:
        for note in (*found.notes, *found.undrawn):
            click.echo(f"note: {note}", err=True)
        click.echo(str(output))
    if not found.check.passed:
        sys.exit(EXIT_FAILED)


@click.command()
@click.argument("mission", type=FILE)
@click.option(
    "--port", type=click.IntRange(0, 65_535), default=0, help="The port (default: any that is free)."
)
@engine_option()
@limit_option
@import_option
def serve(
    mission: Path,
    port: int,
    engine: Asked,
    max_states: int | None,
    import_root: Path | None,
) -> None:
    """Serve the report of MISSION to a browser on this machine, and verify again when its files change.

    What is wrong in the files is shown with the lines; questions that are typed in the page are answered. The
    address has a token; it is printed, and nobody who does not know it is answered.
    """
    from mcpn.editor.served import PageServer, ServedMission

    if not mission.is_file():
        raise InputError.at(Source(str(mission)), "found no such file, expected a mission")
    try:
        server = PageServer(ServedMission(mission, import_root, engine, max_states), port)
    except OSError as error:
        raise InputError.at(None, f"port {port} cannot be listened on: {error.strerror}") from error
    click.echo(server.address)
    sys.stdout.flush()
    server.run()
