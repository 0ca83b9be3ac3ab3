"""The structure of a net: what its arcs prove without its markings, part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.nets.semiflows import p_semiflows, state_machine_components, t_semiflows
from mcpn.nets.siphons import commoner, siphons, traps
from mcpn.nets.structural_classes import classes
from mcpn.nets.structure import Sparse, invariants

PARTS: Mapping[str, Callable[[PetriNet], Any]] = {
    "p_semiflows": p_semiflows,
    "t_semiflows": t_semiflows,
    "siphons": siphons,
    "traps": traps,
    "components": state_machine_components,
    "unmarked_siphon": commoner,
}
"""What is looked for among the arcs of a net: see :mod:`mcpn.nets.siphons` and :mod:`mcpn.nets.semiflows`."""


class Structure:
    """What the arcs of a net tell without its markings; a part whose limit was hit is left out and named.

    Places and transitions go by their names, numbers by these are weights; to ask for a part that was left
    out is a :class:`mcpn.errors.LimitError`.

    Args:
        net: The net.

    Examples:
        >>> from mcpn.testing.nets import kanban
        >>> found = Structure(kanban(3))
        >>> found.p_semiflows[0]
        {'machine1': 1, 'rework1': 1, 'out1': 1, 'card1': 1}
        >>> len(found.invariants), len(found.p_semiflows), found.siphons[0] == found.traps[0]
        (5, 6, True)

    Attributes:
        classes: See :func:`mcpn.nets.structural_classes.classes`.
        parts: What was found, by the names of :data:`PARTS`.
        left_out: What was left out, and which limit was hit.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self.classes = classes(net)
        self.parts: dict[str, Any] = {}
        self.left_out: dict[str, str] = {}
        for name, find in PARTS.items():
            try:
                self.parts[name] = find(net)
            except LimitError as error:
                self.left_out[name] = str(error)

    @property
    def invariants(self) -> tuple[dict[str, int], ...]:
        """A basis of the P-invariants: weights, also negative, of sums of tokens that no firing changes."""
        return self._by_place(invariants(self.net))

    @property
    def p_semiflows(self) -> tuple[dict[str, int], ...]:
        """The P-invariants without negative weights, those of minimal support."""
        return self._by_place(self._part("p_semiflows"))

    @property
    def t_semiflows(self) -> tuple[dict[str, int], ...]:
        """How often transitions fire on the way from a marking back to it, those of minimal support."""
        names = [t.name for t in self.net.transitions]
        return tuple({names[t]: n for t, n in flow.items()} for flow in self._part("t_semiflows"))

    @property
    def siphons(self) -> tuple[tuple[str, ...], ...]:
        """Minimal sets of places that stay without tokens once they have none."""
        return self._sets("siphons")

    @property
    def traps(self) -> tuple[tuple[str, ...], ...]:
        """Minimal sets of places that keep a token once they have one."""
        return self._sets("traps")

    @property
    def components(self) -> tuple[tuple[str, ...], ...]:
        """State machine components: sets of places among which transitions only move tokens."""
        return self._sets("components")

    def _part(self, name: str) -> Any:
        if name in self.left_out:
            raise LimitError(self.left_out[name])
        return self.parts[name]

    def _by_place(self, flows: Iterable[Sparse]) -> tuple[dict[str, int], ...]:
        return tuple({self.net.places[p].name: weight for p, weight in flow.items()} for flow in flows)

    def _sets(self, part: str) -> tuple[tuple[str, ...], ...]:
        return tuple(tuple(self.net.places[p].name for p in members) for members in self._part(part))

    @property
    def conservative(self) -> bool | None:
        """Whether some positive weighting of all places never changes; then the net is bounded."""
        return self._every_place(self.parts.get("p_semiflows"))

    @property
    def covered(self) -> bool | None:
        """Whether every place is in some state machine component."""
        return self._every_place(self.parts.get("components"))

    def _every_place(self, parts: Iterable[Iterable[int]] | None) -> bool | None:
        return None if parts is None else set().union(*parts) == set(range(len(self.net.places)))

    @property
    def proves(self) -> list[str]:
        """What follows, whatever the order of firing."""
        proved = []
        if self.conservative:
            proved.append("bounded, whatever the initial marking: every place is in a P-semiflow")
        if "ordinary" in self.classes and "components" in self.parts:
            initial = self.net.initial
            if self._every_place(c for c in self.parts["components"] if sum(initial[p] for p in c) == 1):
                proved.append("1-safe: every place is in a state machine component with one token")
        decided = {"ordinary", "free choice"} <= self.classes and not self.net.priorities
        if decided and {"siphons", "traps", "unmarked_siphon"} <= self.parts.keys():
            live = self.parts["unmarked_siphon"] is None
            why = "every minimal siphon contains" if live else "a minimal siphon does not contain"
            proved.append(f"{'live' if live else 'not live'}: free choice, and {why} a marked trap")
        return proved
