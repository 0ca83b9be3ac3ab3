"""Generated nets, and the slow, plain explorer that judges the quick ones."""

from __future__ import annotations

from collections import deque

from hypothesis import strategies as st

from mcpn.net.petri import Marking, NetBuilder, PetriNet

ODD_NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co", "Zl", "Zp")),
    min_size=1,
    max_size=6,
)


@st.composite
def nets(
    draw: st.DrawFn,
    *,
    max_places: int = 6,
    max_transitions: int = 6,
    max_weight: int = 1,
    odd_names: bool = False,
    events: bool = True,
) -> PetriNet:
    """Any small net, with read arcs, self-loops, events and priorities, safe or not."""
    count = draw(st.integers(1, max_places))
    names = [f"p{i}" for i in range(count)]
    size = draw(st.integers(0, max_transitions))
    transitions = [f"t{i}" for i in range(size)]
    if odd_names:
        drawn = draw(
            st.lists(ODD_NAMES, min_size=count + size, max_size=count + size, unique_by=lambda n: n.strip())
        )
        names, transitions = drawn[:count], drawn[count:]
    priorities = events and draw(st.booleans())
    builder = NetBuilder("net", priorities=priorities)
    for name in names:
        builder.place(name, initial=draw(st.integers(0, max_weight)))
    weights = st.dictionaries(st.sampled_from(names), st.integers(1, max_weight), max_size=3)
    for name in transitions:
        consume, produce, read = draw(weights), draw(weights), draw(weights)
        event = draw(st.none() | st.sampled_from(["EV_A", "EV_B"])) if events else None
        builder.transition(name, consume=consume, produce=produce, read=read, event=event)
    return builder.build()


def reachable(net: PetriNet, limit: int = 5000) -> tuple[dict[Marking, int], int, bool]:
    """Markings with their distance, the number of firings, and whether all are 1-safe: the net's own rule."""
    found = {net.initial: 0}
    queue, edges = deque([net.initial]), 0
    safe = max(net.initial, default=0) <= 1
    while queue and safe and len(found) < limit:
        marking = queue.popleft()
        for transition in net.enabled(marking):
            after = net.fire(marking, transition)
            edges += 1
            if max(after) > 1:
                return found, edges, False
            if after not in found:
                found[after] = found[marking] + 1
                queue.append(after)
    return found, edges, safe
