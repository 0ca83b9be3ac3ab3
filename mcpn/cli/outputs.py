"""Files made of a mission or a net: controllers and other formats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import (
    FILE,
    composite_of,
    import_option,
    limit_option,
    mission_net_of,
    net_of,
    progress_line,
)
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet


@click.command()
@click.argument("mission", type=FILE)
@click.option("--target", type=click.Choice(["json"]), default="json", show_default=True)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the controller to.")
@click.option(
    "--flat/--hierarchical",
    default=True,
    help="One machine, or one for each type of section and one on top.",
)
@limit_option
@import_option
def controller(
    mission: Path, target: str, output: Path, flat: bool, max_states: int | None, import_root: Path | None
) -> None:
    """Generate the controller of MISSION as finite state machines."""
    from mcpn.controller.targets.json import FILE_NAME
    from mcpn.files import write_atomically

    mission_net = mission_net_of(mission, import_root)
    text, size = (_flat if flat else _hierarchical)(mission_net, max_states)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.at(Source(str(output)), f"cannot be made a directory: {error.strerror}") from error
    path = output / FILE_NAME
    write_atomically(path, text)
    click.echo(f"{path}: {size}")


def _flat(mission_net: MissionNet, max_states: int | None) -> tuple[str, str]:
    from mcpn.controller.machine import controller as generate
    from mcpn.controller.targets.json import write_json
    from mcpn.space.confluence import direct_with_proof

    limits = {} if max_states is None else {"max_states": max_states}
    with progress_line(False) as progress:
        graph = direct_with_proof(mission_net.net, progress=progress, **limits)
    machine = generate(mission_net, graph)
    return write_json(machine, mission_net), f"{len(machine.states)} states, {len(machine.edges)} edges"


def _hierarchical(mission_net: MissionNet, max_states: int | None) -> tuple[str, str]:
    from mcpn.controller.hierarchy import hierarchical_controller
    from mcpn.controller.targets.json import write_hierarchical_json

    composite = composite_of(mission_net, max_states, listed=True)
    hierarchy = hierarchical_controller(composite)
    states = sum(len(machine.states) for machine in hierarchy.types)
    edges = sum(len(machine.edges) for machine in hierarchy.types)
    size = (
        f"{len(hierarchy.sections)} sections of {len(hierarchy.types)} types, {states} states, {edges} edges"
    )
    return write_hierarchical_json(hierarchy, mission_net), size


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
