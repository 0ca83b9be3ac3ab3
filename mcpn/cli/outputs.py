"""Files made of a mission or a net: controllers and other formats."""

from __future__ import annotations

from pathlib import Path

import click

from mcpn.cli.shared import FILE, import_option, limit_option, mission_net_of, net_of, progress_line
from mcpn.errors import InputError, Source


@click.command()
@click.argument("mission", type=FILE)
@click.option("--target", type=click.Choice(["json"]), default="json", show_default=True)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the controller to.")
@limit_option
@import_option
def controller(
    mission: Path, target: str, output: Path, max_states: int | None, import_root: Path | None
) -> None:
    """Generate the controller of MISSION as a finite state machine."""
    from mcpn.controller.machine import controller as generate
    from mcpn.controller.targets.json import FILE_NAME, write_json
    from mcpn.files import write_atomically
    from mcpn.space.confluence import direct_with_proof

    mission_net = mission_net_of(mission, import_root)
    with progress_line(False) as progress:
        limits = {} if max_states is None else {"max_states": max_states}
        graph = direct_with_proof(mission_net.net, progress=progress, **limits)
    machine = generate(mission_net, graph)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.at(Source(str(output)), f"cannot be made a directory: {error.strerror}") from error
    path = output / FILE_NAME
    write_atomically(path, write_json(machine, mission_net))
    click.echo(f"{path}: {len(machine.states)} states, {len(machine.edges)} edges")


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
