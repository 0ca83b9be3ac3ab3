"""What stays in a set, by what runs come to: against the greatest fixpoint on arrays."""

from __future__ import annotations

from collections.abc import Collection

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn._kernel import Zdd
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.greatest_fixpoint import _ByCycles
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from tests.nets.nets import nets, reachable
from tests.spaces.members import members


@st.composite
def fused(draw: st.DrawFn) -> PetriNet:
    """A token that goes about; most of its ways are open once, so that few transitions are on cycles."""
    count = draw(st.integers(2, 5))
    builder = NetBuilder("fused")
    for i in range(count):
        builder.place(f"at{i}", initial=int(i == 0))
    at = st.integers(0, count - 1)
    for i in range(draw(st.integers(1, 7))):
        fuse = []
        if i:
            builder.place(f"fuse{i}", initial=1)
            fuse = [f"fuse{i}"]
        builder.transition(f"go{i}", consume=[f"at{draw(at)}", *fuse], produce=[f"at{draw(at)}"])
    return builder.build()


class Hurried(DiagramMarkings):
    """Layers and what runs come to take turns from the first step on."""

    steps_of_layers = 1

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        self.steps += 1  # even where the kernel remembers them all
        return super().continuing(states, transitions)


class Layered(DiagramMarkings):
    """Counts layers, of which each takes a turn."""

    steps_of_layers = 1
    layers = 0

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        self.layers += 1
        return super().continuing(states, transitions)


@pytest.mark.parametrize("asking", [False, True])
@given(nets(max_places=6, max_transitions=8) | fused(), st.data())
def test_what_runs_come_to_says_what_stays(asking: bool, net: PetriNet, data: st.DataObject) -> None:
    """Where some states are asked for, what is found meets them just where the exact set does."""
    assume(reachable(net)[2])
    outside = data.draw(st.lists(st.sampled_from(range(len(net.places))), max_size=2, unique=True))
    arrays, diagrams = ArraySpace(explore(net)), DiagramMarkings(reach(net))
    exact = members(arrays, arrays.staying(arrays.everything - arrays.marked(outside)))
    along = diagrams.everything - diagrams.marked(outside)
    assume(along)
    wanted = data.draw(st.sampled_from(sorted(members(diagrams, along))))
    asked = diagrams.space.encoding.set_of(wanted) if asking else None
    cycles = _ByCycles(diagrams, along, asked)
    turns = Hurried(diagrams.space).staying(along, asked)
    assert turns is not None, "layers find it where this way is given up"
    for found in (turns, cycles.states(1 << 40)):
        if found is None:
            assert cycles.given_up
            event("given up: most transitions may be repeated")
        elif asked is None:
            assert members(diagrams, found) == exact
        else:
            assert bool(found & asked) == (wanted in exact)
    event(f"something stays: {bool(exact)}")


def test_layers_leave_turns() -> None:
    """Layers count their steps: where each is of many, what runs come to decides before all are dropped."""
    builder = NetBuilder("fuses")
    for i in range(60):
        builder.place(f"fuse{i}", initial=1)
        builder.place(f"blown{i}")
        before = [f"blown{i - 1}"] if i else []
        builder.transition(f"blow{i}", consume=[f"fuse{i}", *before], produce=[f"blown{i}", *before])
    space, along = Layered(reach(builder.build())), [59]
    running = space.everything - space.marked([space.net.place_index[f"blown{p}"] for p in along])
    assert not space.staying(running, None)
    assert space.steps > 0
    assert space.layers < 60
