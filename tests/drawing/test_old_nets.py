"""Missions that were written before some words of the language have the nets that they had, place for place.

The digests are of the nets that the program of commit d492155 drew, before guards at entry: they were made by
:func:`digest` with that commit's ``mcpn`` in the path, and are not to be made anew where one differs.
"""

from __future__ import annotations

import hashlib

import pytest

from mcpn.drawing.compose import compose
from mcpn.events import Event, What
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from tests.conftest import ROOT

BEFORE = """
experiments/courier/mission.xml 269 443 2e49bfbefa347f31
experiments/drone/mission.xml 254 291 50b640a053119639
experiments/glider/mission.xml 321 418 546716c6a8bd8272
experiments/roscon/problem1.xml 63 79 7bff9d5388923772
experiments/roscon/problem2.xml 124 194 905abbe274535e66
experiments/roscon/problem2_published.xml 114 177 b6a1c96460bedf43
experiments/roscon/problem3.xml 133 197 f85585383e57429f
experiments/roscon/problem4.xml 274 483 2854933fed59f481
experiments/rover/mission.xml 331 497 ea899465481f6f18
experiments/ulysse/mission.xml 133 150 b0317c609556f8c4
tests/controller/watch.xml 72 82 cf41a96851143ba6
tests/natural/auv.xml 109 119 9e2e0d1aac5e8311
tests/natural/dumpster.xml 75 105 c1d7231ae7ec7ab0
tests/natural/guard.xml 73 87 0513d08d52590fc2
tests/natural/hospital.xml 343 504 8015b3cdac2c8355
tests/natural/inspection.xml 285 350 b1a7951233e5b515
tests/natural/rover.xml 93 145 601084a61e9706e2
tests/natural/sewer.xml 346 397 348b0c27ab852072
"""


def in_old_spelling(event: Event | None) -> str:
    """An event as text, a declared one as that program spelt it: the name and ``_EV``."""
    return f"{event}_EV" if event is not None and event.what is What.DECLARED else str(event)


def digest(net: PetriNet) -> str:
    """All places with their tokens, all transitions with their places, by name."""
    said = [f"{p.name} {p.initial}" for p in net.places]
    said += [
        f"{t.name} {in_old_spelling(t.event)} {t.rank} "
        f"{sorted(t.consume)} {sorted(t.produce)} {sorted(t.read)}"
        for t in net.transitions
    ]
    return hashlib.sha256("\n".join(said).encode()).hexdigest()[:16]


@pytest.mark.parametrize(
    ("path", "places", "transitions", "before"), [line.split() for line in BEFORE.strip().splitlines()]
)
def test_its_net_is_as_it_was(path: str, places: str, transitions: str, before: str) -> None:
    net = compose(read_mission(ROOT / path)).net
    assert (str(len(net.places)), str(len(net.transitions))) == (places, transitions)
    assert digest(net) == before
