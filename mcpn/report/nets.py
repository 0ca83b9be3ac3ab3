"""What a person reads of a net, its behaviour and its structure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from mcpn.check.verdicts.nets import NetCheck, Structure
from mcpn.net.petri import PetriNet
from mcpn.net.structure import Sparse
from mcpn.report.terminal import Terminal
from mcpn.space.markings.tokens import OMEGA

SHOWN = 20


def net_object(check: NetCheck) -> dict[str, Any]:
    """The behaviour of a net as one JSON object."""
    pump = {"run": check.bounded.run, "repeat": check.bounded.pump} if check.bounded.pump else None
    return {
        "net": check.net.name,
        "places": len(check.net.places),
        "transitions": len(check.net.transitions),
        "states": check.states,
        "safe": check.safe,
        "bounded": check.bounded.bounded,
        "bound": check.bound,
        "unbounded_by": pump,
        "deadlock_free": check.deadlock_free,
        "deadlock": check.deadlock,
        "dead_marking": None if check.deadlock is None else marking_after(check.net, check.deadlock),
        "bounds": _bounds(check),
        "dead_transitions": check.dead_transitions,
        "live": None if check.not_live is None else not check.not_live,
        "not_live": check.not_live,
        "reversible": check.reversible,
        "home_markings": check.home_markings,
    }


def structure_object(structure: Structure) -> dict[str, Any]:
    """The structure of a net as one JSON object, places and transitions by name."""
    net, parts = structure.net, structure.parts
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]

    def sets(part: str) -> list[list[str]] | None:
        return [[places[p] for p in members] for members in parts[part]] if part in parts else None

    def flows(part: str, names: list[str]) -> list[dict[str, int]] | None:
        return [{names[i]: w for i, w in flow.items()} for flow in parts[part]] if part in parts else None

    return {
        "net": net.name,
        "classes": sorted(structure.classes),
        "p_semiflows": flows("p_semiflows", places),
        "t_semiflows": flows("t_semiflows", transitions),
        "siphons": sets("siphons"),
        "traps": sets("traps"),
        "state_machine_components": sets("components"),
        "conservative": structure.conservative,
        "covered_by_state_machines": structure.covered,
        "proves": structure.proves,
        "left_out": structure.left_out,
    }


def marking_after(net: PetriNet, run: tuple[str, ...]) -> dict[str, int]:
    """The tokens of each marked place after a run."""
    marking = net.initial
    for name in run:
        marking = net.fire(marking, net.transition_index[name])
    return {place.name: tokens for place, tokens in zip(net.places, marking, strict=True) if tokens}


def print_net(check: NetCheck) -> None:
    """Prints the behaviour of a net."""
    terminal = Terminal()
    net = check.net
    sizes = f"{len(net.places)} places, {len(net.transitions)} transitions"
    states = "" if check.states is None else f", {check.states} markings"
    terminal.print(f"net {net.name}: {sizes}{states}")
    answers = {True: "yes", False: "no", None: "not known"}
    terminal.print(f"1-safe          {answers[check.safe]}")
    bound = "" if check.bound is None else f"  at most {check.bound} tokens in a place"
    terminal.print(f"bounded         {answers[check.bounded.bounded]}{bound}  {check.bounded.reason}")
    if check.bounded.pump:
        terminal.print(f"run: {' '.join(check.bounded.run)}", indent=4)
        terminal.print(f"repeat: {' '.join(check.bounded.pump)}", indent=4)
    terminal.print(f"deadlock free   {answers[check.deadlock_free]}")
    if check.deadlock is not None:
        terminal.print(f"run: {' '.join(check.deadlock)}", indent=4)
        told = (p if n == 1 else f"{p} {n}" for p, n in marking_after(net, check.deadlock).items())
        terminal.print(f"dead marking: {', '.join(told)}", indent=4)
    for word, names in (("quasi-live", check.dead_transitions), ("live", check.not_live)):
        holds = None if names is None else not names
        without = f"  not: {_some(names)}" if names else ""
        terminal.print(f"{word:15} {answers[holds]}{without}")
    terminal.print(f"reversible      {answers[check.reversible]}")
    if check.home_markings is not None:
        terminal.print(f"home markings   {check.home_markings}")


def print_structure(structure: Structure) -> None:
    """Prints the structure of a net; long lists are cut, and said to be."""
    terminal = Terminal()
    net = structure.net
    terminal.print(f"net {net.name}: {', '.join(sorted(structure.classes)) or 'of no class'}")
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]

    def flow(weights: Sparse) -> str:
        return f"{_combined(weights, places)} = {sum(w * net.initial[p] for p, w in weights.items())}"

    def members(of: Iterable[int]) -> str:
        return ", ".join(places[p] for p in of)

    told: dict[str, tuple[str, Callable[[Any], str]]] = {
        "p_semiflows": ("P-semiflows", flow),
        "t_semiflows": ("T-semiflows", lambda weights: _combined(weights, transitions)),
        "siphons": ("minimal siphons", members),
        "traps": ("minimal traps", members),
        "components": ("state machine components", members),
    }
    for part, (title, tell) in told.items():
        if part in structure.parts:
            _list(terminal, title, list(map(tell, structure.parts[part])))
    for sentence in structure.proves:
        terminal.print(f"proved: {sentence}")
    for part, reason in structure.left_out.items():
        terminal.print(f"left out: {part.replace('_', ' ')}: {reason}")


def _bounds(check: NetCheck) -> dict[str, int | None] | None:
    """By place, the most tokens it holds; null where there is no such number."""
    bounds = check.bounded.bounds
    if bounds is None:
        return None
    return {p.name: None if b == OMEGA else b for p, b in zip(check.net.places, bounds, strict=True)}


def _combined(flow: Sparse, names: list[str]) -> str:
    return " + ".join(_term(weight, names[i]) for i, weight in flow.items())


def _term(weight: int, name: str) -> str:
    return name if weight == 1 else f"{weight} {name}"


def _some(names: Iterable[str]) -> str:
    listed = list(names)
    more = f" and {len(listed) - SHOWN} more" if len(listed) > SHOWN else ""
    return ", ".join(listed[:SHOWN]) + more


def _list(terminal: Terminal, title: str, lines: list[str]) -> None:
    terminal.print(f"{title}: {len(lines)}")
    for line in lines[:SHOWN]:
        terminal.print(line, indent=4)
    if len(lines) > SHOWN:
        terminal.print(f"and {len(lines) - SHOWN} more (--json lists all)", indent=4)
