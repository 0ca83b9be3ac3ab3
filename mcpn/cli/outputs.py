"""Files made of a mission or a net: controllers and other formats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import (
    FILE,
    composite_of,
    emit_json,
    import_option,
    json_option,
    limit_option,
    mission_net_of,
    net_of,
    progress_line,
)

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
@json_option
def controller(
    mission: Path,
    target: str,
    output: Path,
    flat: bool,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Generate the controller of MISSION as finite state machines."""
    from mcpn.controller.targets.json import FILE_NAME
    from mcpn.files import write_folder

    mission_net = mission_net_of(mission, import_root)
    text, sizes = (_flat if flat else _hierarchical)(mission_net, max_states, as_json)
    write_folder(output, {FILE_NAME: text})
    if as_json:
        emit_json({"files": [str(output / FILE_NAME)], **sizes})
    else:
        click.echo(f"{output / FILE_NAME}: {', '.join(f'{n} {what}' for what, n in sizes.items())}")


def _flat(mission_net: MissionNet, max_states: int | None, quiet: bool) -> tuple[str, dict[str, int]]:
    from mcpn.controller.machine import controller as generate
    from mcpn.controller.targets.json import write_json
    from mcpn.space.confluence import direct_with_proof

    limits = {} if max_states is None else {"max_states": max_states}
    with progress_line(quiet) as progress:
        graph = direct_with_proof(mission_net.net, progress=progress, **limits)
    machine = generate(mission_net, graph)
    return write_json(machine, mission_net), {"states": len(machine.states), "edges": len(machine.edges)}


def _hierarchical(mission_net: MissionNet, max_states: int | None, quiet: bool) -> tuple[str, dict[str, int]]:
    from mcpn.controller.hierarchy import hierarchical_controller
    from mcpn.controller.targets.json import write_hierarchical_json

    composite = composite_of(mission_net, max_states, quiet=quiet, listed=True)
    hierarchy = hierarchical_controller(composite)
    sizes = {
        "sections": len(hierarchy.sections),
        "types": len(hierarchy.types),
        "states": sum(len(machine.states) for machine in hierarchy.types),
        "edges": sum(len(machine.edges) for machine in hierarchy.types),
    }
    return write_hierarchical_json(hierarchy, mission_net), sizes


@click.command()
@click.argument("source", type=FILE)
@click.argument("target", type=FILE)
@import_option
@json_option
def convert(source: Path, target: Path, import_root: Path | None, as_json: bool) -> None:
    """Convert SOURCE (.xml mission, .pnml, .net, .json) to TARGET (.pnml, .net, .dot, .json)."""
    from mcpn.net.formats import save_net

    net = net_of(source, import_root)
    warning = save_net(net, target)
    if as_json:
        sizes = {"places": len(net.places), "transitions": len(net.transitions)}
        emit_json({"file": str(target), **sizes, "warnings": [warning] if warning else []})
    elif warning:
        click.echo(f"warning: {warning}", err=True)
