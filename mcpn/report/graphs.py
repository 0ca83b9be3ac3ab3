"""The alternatives graph as a file: JSON, GraphML, Aldebaran (``.aut``), Graphviz or a picture."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.nets.formats.dot import dot_string
from mcpn.report.pictures.drawing import KNOWN as PICTURES
from mcpn.spaces.stable.alternatives import AlternativesGraph

KNOWN = (".json", ".graphml", ".aut", ".dot", *PICTURES)


def save_graph(
    graph: AlternativesGraph, mission_net: MissionNet, path: Path, section: str | None = None
) -> None:
    """Writes an alternatives graph, whole or not at all.

    Args:
        graph: The graph.
        mission_net: The net that it belongs to.
        path: The file; its suffix chooses the format.
        section: The section that the graph is of, if not of the whole mission.

    Raises:
        InputError: The suffix is of no known format, or the file cannot be written.
        LimitError: A picture would be too large to be read.
    """
    suffix = path.suffix.lower()
    if suffix in PICTURES:
        from mcpn.report.pictures.machines import alternatives_drawing, local_graph_drawing

        if section is None:
            alternatives_drawing(mission_net, graph).save(path)
        else:
            local_graph_drawing(mission_net, graph, section).save(path)
        return
    edges = [
        (int(graph.sources[edge]), str(graph.event(edge)), int(graph.targets[edge]))
        for edge in range(graph.edges)
    ]
    if suffix == ".aut":
        lines = [f"des (0, {graph.edges}, {graph.states})"]
        lines += [f'({source}, "{event}", {target})' for source, event, target in edges]
        write_atomically(path, "\n".join(lines) + "\n")
        return
    said = [situation(mission_net, graph.marking(state)) for state in range(graph.states)]
    if suffix == ".json":
        document = {
            "format": "mcpn-alternatives",
            "version": 1,
            "initial": 0,
            "states": [asdict(state) for state in said],
            "edges": [{"from": s, "event": e, "to": t} for s, e, t in edges],
        }
        write_atomically(path, json.dumps(document, indent=1) + "\n")
    elif suffix == ".dot":
        lines = ["digraph alternatives {"]
        lines += [f"  {n} [label={dot_string(_label(state))}];" for n, state in enumerate(said)]
        lines += [f"  {source} -> {target} [label={dot_string(event)}];" for source, event, target in edges]
        write_atomically(path, "\n".join([*lines, "}"]) + "\n")
    elif suffix == ".graphml":
        import networkx

        drawn: networkx.MultiDiGraph[int] = networkx.MultiDiGraph()
        for number, state in enumerate(said):
            drawn.add_node(number, label=_label(state))
        for source, event, target in edges:
            drawn.add_edge(source, target, event=event)
        write_atomically(path, "\n".join(networkx.generate_graphml(drawn, named_key_ids=True)) + "\n")
    else:
        known = ", ".join(KNOWN)
        raise InputError.at(
            Source(str(path)), f"unknown kind of file {suffix or path.name!r}, expected {known}"
        )


def _label(state: Situation) -> str:
    parts = [*state.objectives, *(f"{a}: {alt}" for a, alt in state.mode.items() if a != alt)]
    parts += [f"{name} waits" for name in state.waiting] + [f"{name} refused" for name in state.refused]
    parts += [f"{h} out" for h in state.out_of_service]
    return ", ".join([*parts, *([state.outcome] if state.outcome else [])]) or "idle"
