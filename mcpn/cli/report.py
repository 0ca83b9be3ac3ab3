"""The report: everything that is found of a mission, on one page, written or served."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import emit_json
from mcpn.errors import InputError, Source
from mcpn.report.progress import progress_on_terminal
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from mcpn.spaces.engine_names import Asked, Asking


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The page to write, FILE.html.")
@engine_option()
@click.option(
    "--certificate",
    type=FILE,
    metavar="OUT",
    help="Write the claims to OUT, with evidence, have certcheck check it, and say on the page what it says.",
)
@question(workers=True)
def report(
    question: Question,
    mission: Path,
    output: Path,
    engine: Asked,
    certificate: Path | None,
) -> None:
    """Write a report of MISSION as one HTML page: drawing, verdicts, causes, a controller to click through.

    The page opens from disk, needs no network, and can be printed or sent.
    """
    from mcpn.cli.check import certified
    from mcpn.files import write_atomically
    from mcpn.report.page import page
    from mcpn.report.pictures.local_graphs import local_pictures

    if output.suffix.lower() not in (".html", ".htm"):
        source = Source(str(output))
        raise InputError.at(source, f"found the suffix {output.suffix!r}, expected .html")
    study = question.study(mission, engine)
    question.keep_apart(mission, study, output, certificate)
    with progress_on_terminal(), question.workers():
        found = study.findings()
        step(Doing.PREPARING, question="the page")
        local = local_pictures(found.local)
        verified = None if certificate is None else certified(found.check, certificate, question.max_states)
        text = page(found, local=local, verified=verified)
    write_atomically(output, text)
    if question.as_json:
        size = len(text.encode())
        emit_json({"file": str(output), "bytes": size, "engine": found.engine, "passed": found.check.passed})
    else:
        for note in (*found.notes, *found.unlisted, *local[1]):
            click.echo(f"note: {note}", err=True)
        click.echo(str(output))
    if not found.check.passed or (verified is not None and verified.keys("refuted")):
        sys.exit(EXIT_FAILED)


@click.command()
@click.argument("mission", type=FILE)
@click.option(
    "--port", type=click.IntRange(0, 65_535), default=0, help="The port (default: any that is free)."
)
@engine_option()
@question(templates=False, as_json=False)
def serve(
    question: Question,
    mission: Path,
    port: int,
    engine: Asked,
) -> None:
    """Serve the report of MISSION to a browser on this machine, and verify again when its files change.

    What is wrong in the files is shown with the lines; questions that are typed in the page are answered. The
    address has a token; it is printed, and nobody who does not know it is answered.
    """
    from mcpn.editor.page_server import PageServer
    from mcpn.editor.served import ServedMission

    if not mission.is_file():
        raise InputError.at(Source(str(mission)), "found no such file, expected a mission")
    try:
        asked: Asking = {"engine": engine, "max_states": question.max_states}
        served = ServedMission(mission, question.import_root, asked, question.of_tree or {})
        server = PageServer(served, port)
    except OSError as error:
        raise InputError.at(None, f"port {port} cannot be listened on: {error.strerror}") from error
    click.echo(server.address)
    sys.stdout.flush()
    server.run()
