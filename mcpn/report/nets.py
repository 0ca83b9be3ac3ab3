"""A net's behaviour, structure and token game, for people and as objects for JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from mcpn.logic.behaviour import NetCheck
from mcpn.logic.structure import Structure
from mcpn.nets.game import TokenGame
from mcpn.nets.petri import Arcs, Marking, PetriNet
from mcpn.report.terminal import Terminal
from mcpn.spaces.markings.boundedness import OMEGA

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

    def known(part: str) -> Any:
        return None if part in structure.left_out else getattr(structure, part)

    return {
        "net": structure.net.name,
        "classes": sorted(structure.classes),
        "p_semiflows": known("p_semiflows"),
        "t_semiflows": known("t_semiflows"),
        "siphons": known("siphons"),
        "traps": known("traps"),
        "state_machine_components": known("components"),
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
    return tokens_of(net, marking)


def tokens_of(net: PetriNet, marking: Marking) -> dict[str, int]:
    """The tokens of each marked place."""
    return {place.name: tokens for place, tokens in zip(net.places, marking, strict=True) if tokens}


def marking_in_words(tokens: Mapping[str, int]) -> str:
    """Marked places, each with its number of tokens if it holds several."""
    return ", ".join(place if count == 1 else f"{place} {count}" for place, count in tokens.items())


def arcs_in_words(net: PetriNet, transition: int) -> str:
    """A transition as ``name: a + 2 b ?c -> d``, with its event if another name says it; ``?`` reads."""
    t = net.transitions[transition]

    def sums(arcs: Arcs) -> list[str]:
        return [_term(weight, net.places[place].name) for place, weight in arcs]

    read = [f"?{term}" for term in sums(t.read)]
    parts = [" + ".join(sums(t.consume)), *read, "->", " + ".join(sums(t.produce))]
    event = "" if t.event is None or str(t.event) == t.name else f" [{t.event}]"
    return f"{t.name}{event}: {' '.join(part for part in parts if part)}"


def game_object(game: TokenGame) -> dict[str, Any]:
    """A token game as one JSON object."""
    transitions = game.net.transitions

    def named(transition: int) -> dict[str, str | None]:
        event = transitions[transition].event
        return {"transition": transitions[transition].name, "event": None if event is None else str(event)}

    return {
        "fired": [named(t) for t in game.run],
        "marking": tokens_of(game.net, game.marking),
        "enabled": [named(t) for t in game.enabled],
    }


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
        dead = marking_in_words(marking_after(net, check.deadlock))
        terminal.print(f"dead marking: {dead}", indent=4)
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
    initial = {place.name: place.initial for place in net.places}

    def flow(weights: Mapping[str, int]) -> str:
        return f"{_combined(weights)} = {sum(w * initial[p] for p, w in weights.items())}"

    told: dict[str, tuple[str, Callable[[Any], str]]] = {
        "p_semiflows": ("P-semiflows", flow),
        "t_semiflows": ("T-semiflows", _combined),
        "siphons": ("minimal siphons", ", ".join),
        "traps": ("minimal traps", ", ".join),
        "components": ("state machine components", ", ".join),
    }
    for part, (title, tell) in told.items():
        if part not in structure.left_out:
            _list(terminal, title, list(map(tell, getattr(structure, part))))
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


def _combined(flow: Mapping[str, int]) -> str:
    return " + ".join(_term(weight, name) for name, weight in flow.items())


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
