"""Files made of a mission or a net: controllers and other formats."""

from __future__ import annotations

from pathlib import Path

import click

from mcpn.cli.shared import (
    FILE,
    SECTIONS,
    STATES_AND_EDGES,
    import_option,
    limit_option,
    mission_net_of,
    net_of,
    progress_line,
)
from mcpn.errors import InputError, Source


@click.command()
@click.argument("mission", type=FILE)
@click.option("--target", type=click.Choice(["json"]), default="json", show_default=True)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the controller to.")
@click.option(
    "--hierarchical/--flat",
    default=True,
    help="A machine for each type of section (the default), or one for the whole mission.",
)
@limit_option
@import_option
def controller(
    mission: Path,
    target: str,
    output: Path,
    hierarchical: bool,
    max_states: int | None,
    import_root: Path | None,
) -> None:
    """Generate the controller of MISSION: finite state machines that do what was verified."""
    from mcpn.controller.generate import generate
    from mcpn.controller.targets import files
    from mcpn.files import write_atomically

    mission_net = mission_net_of(mission, import_root)
    with progress_line(False, SECTIONS if hierarchical else STATES_AND_EDGES) as progress:
        found = generate(
            mission_net,
            "hierarchical" if hierarchical else "flat",
            max_states=max_states,
            progress=progress,
            told=lambda text: click.echo(text, err=True),
        )
    click.echo(f"{found.form} controller of {found.mission}: {found.size}")
    texts = files(found, mission_net, target)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.at(Source(str(output)), f"cannot be made a directory: {error.strerror}") from error
    for name, text in texts.items():
        write_atomically(output / name, text)
        click.echo(output / name)


@click.command()
@click.argument("source", type=FILE)
@click.argument("target", type=FILE)
@import_option
def convert(source: Path, target: Path, import_root: Path | None) -> None:
    """Convert SOURCE (.xml mission, .pnml, .net, .json) to TARGET (.pnml, .net, .dot, .json)."""
    from mcpn.net.formats import save_net

    warning = save_net(net_of(source, import_root), target)
    if warning:
        click.echo(f"warning: {warning}", err=True)
