"""Structural classes of a net: ordinary, pure, state machine, marked graph, free choice, asymmetric choice.

Weights decide only whether a net is *ordinary*; the other classes see which places stand where, so that what
is known of them holds for ordinary nets.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section V.
"""

from __future__ import annotations

from mcpn.nets.petri import PetriNet
from mcpn.nets.surroundings import members, surroundings


def classes(net: PetriNet) -> frozenset[str]:
    """Structural classes that the net belongs to.

    Returns:
        Among ``ordinary`` (all weights 1), ``pure`` (no place both before and after a transition), ``state
        machine``, ``marked graph``, ``free choice``, ``extended free choice``, ``asymmetric choice``.

    Examples:
        >>> from mcpn.testing.nets import philosophers, token_ring
        >>> sorted(classes(philosophers(2)))
        ['ordinary', 'pure']
        >>> classes(token_ring(3)) - classes(philosophers(2)) >= {"free choice", "state machine"}
        True
    """
    around, places = surroundings(net), range(len(net.places))
    consumers = [frozenset(i for i, (before, _) in enumerate(around) if before >> p & 1) for p in places]
    producers = [frozenset(i for i, (_, after) in enumerate(around) if after >> p & 1) for p in places]
    pairs = [(consumers[p], consumers[q]) for p in places for q in range(p) if consumers[p] & consumers[q]]
    arcs = [w for t in net.transitions for side in (t.consume, t.produce, t.read) for _, w in side]
    held = {
        "ordinary": all(w == 1 for w in arcs),
        "pure": all(not before & after for before, after in around),
        "state machine": all(b.bit_count() == 1 and a.bit_count() == 1 for b, a in around),
        "marked graph": all(len(c) <= 1 and len(p) <= 1 for c, p in zip(consumers, producers, strict=True)),
        "free choice": all(
            len(consumers[p]) == 1 or before.bit_count() == 1 for before, _ in around for p in members(before)
        ),
        "extended free choice": all(c == d for c, d in pairs),
        "asymmetric choice": all(c <= d or d <= c for c, d in pairs),
    }
    return frozenset(name for name, holds in held.items() if holds)
