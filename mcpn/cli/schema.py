"""The schema of the mission language, and those of what commands print."""

from __future__ import annotations

import click

from mcpn.cli.options import json_option
from mcpn.cli.printed import emit_json
from mcpn.errors import InputError

LANGUAGE = "mission"


@click.command()
@click.argument("format_", default=LANGUAGE, metavar="[FORMAT]")
@json_option
def schema(format_: str, as_json: bool) -> None:
    """Print the schema of the mission language (RELAX NG), for an editor that completes and checks.

    With FORMAT, the JSON Schema of what a command prints or writes: check, causes, controller-document, ...

    Save it beside your files (mcpn schema > mission.rng) and write as the second line of each of them
    <?xml-model href="mission.rng"?>. Other forms, XSD or compact, are made from it by trang (package trang
    of Debian): trang mission.rng mission.xsd, an XSD that Xerces takes.
    """
    import json
    from importlib import resources

    if format_ == LANGUAGE:
        language = "RELAX NG"
        text = resources.files("mcpn.mission").joinpath("schema.rng").read_text(encoding="utf-8")
    else:
        from mcpn.report.documents import FORMATS, json_schema

        if format_ not in FORMATS:
            names = ", ".join(sorted(FORMATS))
            raise InputError.at(None, f"no schema of {format_!r}, expected {LANGUAGE} or one of {names}")
        language, text = "JSON Schema", json.dumps(json_schema(FORMATS[format_]), indent=2) + "\n"
    if as_json:
        emit_json({"format": language, "schema": text})
    elif format_ != LANGUAGE:
        click.echo(text, nl=False)
    else:
        click.echo(text, nl=False)
        click.echo('in an editor: <?xml-model href="mission.rng"?> as the second line of a file', err=True)
