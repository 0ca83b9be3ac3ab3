"""Limits are exact: what has N states is built under a limit of N, and refused under N - 1."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import MemoryLimit, SafeNet
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.composite.composing import composite_space
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.drawing.permanent_loss import mortal
from mcpn.drawing.sections import MOST_ALTERNATIVES, MOST_AT_ONCE, MOST_BRANCHES, MOST_HARDWARE
from mcpn.drawing.templates import interrupt_net as interrupting
from mcpn.errors import LimitError, UnboundedError
from mcpn.events import Event
from mcpn.mission.model import SUCCEED, Handler, Mission, Objective, Parallel
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import EVENTS, NetBuilder, PetriNet
from mcpn.nets.semiflows import p_semiflows, t_semiflows
from mcpn.nets.siphons import siphons, traps
from mcpn.spaces import projections as images
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.bounded import reach_markings
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engines import Choice
from mcpn.spaces.markings.boundedness import boundedness
from mcpn.spaces.markings.counted import count_tokens, explore_tokens
from mcpn.spaces.markings.explicit import count, explore
from mcpn.spaces.projections import ImageStore
from mcpn.spaces.search.goal import FALSE, AtMost
from mcpn.spaces.search.searches import Searches
from mcpn.spaces.stable.alternatives import direct, direct_with_proof
from mcpn.spaces.stable.written_out import written_out
from mcpn.testing import missions
from tests import small
from tests.commands import mcpn
from tests.conftest import ULYSSE
from tests.draws import fewer
from tests.nets.nets import nets, reachable, state_machines
from tests.shares import returns_early
from tests.spaces.search.goals import all_markings


def assert_exact(build: Callable[..., object], size: int, message: str, limit: str = "max_states") -> None:
    """Something of a size is built under that limit; one less is refused by a message that says it."""
    build(**{limit: size})
    if size == 1:  # no limit is below one
        return
    with pytest.raises(LimitError, match=message.format(limit=size - 1)):
        build(**{limit: size - 1})


def swaps(count: int, *, events: bool = False) -> PetriNet:
    """Pairs of places between which a token goes to and fro."""
    builder = NetBuilder("swaps", priorities=events)
    for i in range(count):
        builder.place(f"a{i}", initial=1)
        builder.place(f"b{i}")
        for name, before, after in (("to", "a", "b"), ("fro", "b", "a")):
            event = Event.parse(f"{name}{i}") if events else None
            builder.transition(f"{name}{i}", consume=[f"{before}{i}"], produce=[f"{after}{i}"], event=event)
    return builder.build()


def test_markings_of_swaps() -> None:
    net = swaps(3)
    for build in (explore, count, explore_tokens, count_tokens):
        assert_exact(partial(build, net), 8, "more than {limit} states")
    # Karp and Miller's tree: the root, and each marking has its three children once.
    assert_exact(partial(boundedness, net), 1 + 8 * 3, "more than {limit} nodes")
    net = swaps(3, events=True)
    assert boundedness(net, max_states=8).bounded
    assert boundedness(net, max_states=7).bounded is None
    assert_exact(partial(direct, net), 8, "more than {limit} stable states")


@fewer(0.5)
@given(nets(max_weight=2) | state_machines().map(lambda pair: pair[0]))
def test_markings(net: PetriNet) -> None:
    markings, edges, safe = reachable(net)
    if safe:
        assert_exact(partial(explore, net), len(markings), "more than {limit} states")
        assert_exact(partial(count, net), len(markings), "more than {limit} states")
        if not net.priorities:
            # Karp and Miller's tree of a 1-safe net: each marking has its children once.
            assert_exact(partial(boundedness, net), edges + 1, "more than {limit} nodes")
        elif len(markings) > 1:
            assert boundedness(net, max_states=len(markings)).bounded
            left_open = boundedness(net, max_states=len(markings) - 1)
            assert left_open.bounded is None
            assert f"more than {len(markings) - 1} markings" in left_open.reason


@given(nets(max_weight=2, max_places=4, max_transitions=4, events=False))
def test_markings_of_several_tokens(net: PetriNet) -> None:
    try:
        found = explore_tokens(net, max_states=200)
    except (LimitError, UnboundedError) as error:
        returns_early(type(error).__name__)
        return
    assert_exact(partial(explore_tokens, net), found.states, "more than {limit} states")
    assert_exact(partial(count_tokens, net), found.states, "more than {limit} states")


@fewer(0.5, least=8)
@given(nets(max_weight=2) | state_machines().map(lambda pair: pair[0]))
def test_search(net: PetriNet) -> None:
    markings = all_markings(net)
    if markings is None:
        returns_early("too many markings")
        return
    # What holds nowhere: every marking is looked at.
    for limit, outcome in ((len(markings), "unreachable"), (len(markings) - 1, "states")):
        if limit == 0:
            continue
        found = Searches(net).seek(FALSE, max_states=limit, stubborn=False)
        assert found.outcome == outcome, (limit, len(markings))


@fewer(0.1)
@given(missions(max_objectives=2, max_sections=3, max_hardware=3, disjoint_branches=True))
def test_stable_markings(mission: Mission) -> None:
    found = compose(mission)
    net = found.net
    space = DiagramAlternatives(reach(net))
    size = space.everything.count()  # diagrams list nothing
    for proof in (True, False):
        assert_exact(partial(direct, net, proof=proof), size, "more than {limit} stable states")
    assert_exact(partial(direct_with_proof, net), size, "more than {limit} stable states")
    assert_exact(partial(written_out, space, "symbolic"), size, f"{size} states, more than {{limit}}")

    def by(max_states: int) -> Choice:
        return Choice("explicit", max_states=max_states)

    assert_exact(
        lambda max_states: spaces_of(found).space(by(max_states), "alternatives"), size, "limit on states"
    )
    dying = DiagramAlternatives(reach(mortal(found).net)).everything.count()
    assert_exact(
        lambda max_states: spaces_of(found).space(by(max_states), "alternatives", may_die=True),
        dying,
        "more than {limit} stable",
    )


@fewer(0.05)
@given(missions(max_objectives=2, max_sections=4, max_hardware=3, own_hardware=True, shared_activities=False))
def test_sections(mission: Mission) -> None:
    found = compose(mission)
    composite = composite_space(found)
    largest = max(placed.type.size for placed in composite.sections.values())
    name = next(n for n, placed in composite.sections.items() if placed.type.size == largest)
    wanted = f"section .* has {largest:,} states: .*, the limit is {{limit:,}} "
    assert_exact(partial(generate, found), largest, wanted)
    kind = composite.sections[name].type
    assert_exact(partial(kind.refuse_list, name, why="a test"), largest, wanted)
    assert kind.listed().states == largest


def test_siphons_traps_and_semiflows() -> None:
    # Each of the six places is looked at alone, then with its partner; a pair is looked at once.
    net = swaps(3)
    for search in (siphons, traps):
        assert len(search(net)) == 3
        assert_exact(partial(search, net), 9, "more than {limit} sets looked at", "max_steps")
    # Five vectors are left of six once the places of one pair are balanced, three in the end.
    for flows in (p_semiflows, t_semiflows):
        assert [sorted(flow.values()) for flow in flows(net)] == [[1, 1]] * 3
        assert_exact(partial(flows, net), 5, "more than {limit} vectors", "max_rows")


def test_transient_markings(monkeypatch: pytest.MonkeyPatch) -> None:
    # Three tokens that each take one internal step, or two that lead to the same place: a second step may be
    # fired at once, so that of the 26 markings behind the event the seven without a token between are left in
    # several ways, and kept.
    builder = NetBuilder("cube", priorities=True)
    builder.place("begin", initial=1)
    for i in range(3):
        builder.place(f"a{i}")
        builder.place(f"b{i}")
        builder.place(f"c{i}")
        builder.transition(f"t{i}", consume=[f"a{i}"], produce=[f"b{i}"])
        builder.transition(f"by{i}", consume=[f"a{i}"], produce=[f"c{i}"])
        builder.transition(f"on{i}", consume=[f"c{i}"], produce=[f"b{i}"])
    builder.transition("go", consume=["begin"], produce=["a0", "a1", "a2"], event=Event.parse("GO"))
    net = builder.build()
    assert explore(net).states == 28

    def built(max_states: int) -> None:
        monkeypatch.setattr("mcpn.spaces.stable.run_to_completion.TRANSIENT_OF_A_STATE", 0)
        monkeypatch.setattr("mcpn.spaces.stable.run_to_completion.LEAST_TRANSIENT", max_states)
        assert direct(net).states == 2

    assert_exact(built, 7, "more than {limit} transient markings")


def test_stable_and_transient_markings_share_the_memory() -> None:
    # A ring: as many transient markings as stable ones, so that with them about twice the memory is needed.
    size = 4000
    ranks = [EVENTS if i % 2 == 0 else 0 for i in range(2 * size)]
    steps = [([i], [i], [(i + 1) % (2 * size)], ranks[i], False) for i in range(2 * size)]
    steps.sort(key=lambda step: step[3])
    net = SafeNet(2 * size, steps, True)

    def least(orders: Literal["one", "every"]) -> int:
        def fits(limit: int) -> bool:
            try:
                return net.settle([0], orders, size, size, limit).states == size
            except MemoryLimit:
                return False

        return bisect_left(range(1 << 26), True, key=fits)

    assert least("every") > 1.5 * least("one")


@pytest.mark.parametrize(
    ("arguments", "size"),
    [
        ("states {} --engine explicit", 44_299),
        ("check {} --engine explicit", 260),
        ("alternatives {} --method reduction", 44_299),
        ("alternatives {} --method direct", 260),
        ("controller {} --flat -o {out}", 260),
    ],
)
def test_the_option(arguments: str, size: int, tmp_path: Path) -> None:
    filled = arguments.replace("{out}", str(tmp_path / "out")).replace("{}", str(ULYSSE)).split()
    refused = mcpn(*filled, "--max-states", size - 1)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert f"more than {size - 1} " in refused.stderr
    assert "limit" in refused.stderr
    assert not (tmp_path / "out").exists()
    assert mcpn(*filled, "--max-states", size).returncode == 0


def test_minimal_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    found = ImageStore(6)
    pairs = set(combinations(range(6), 2))
    family = found.of_rows(pairs | {(0, 1, 2)})
    for most in (len(pairs), len(pairs) - 1):
        monkeypatch.setattr(images, "MAX_MINIMAL", most)
        if most == len(pairs):
            assert set(found.minimal(family)) == pairs
        else:
            with pytest.raises(LimitError, match=f"more than {most} minimal sets"):
                found.minimal(family)


@pytest.mark.parametrize("branches", [1, 2, 3])
def test_combinations_of_branches_that_an_event_meets(monkeypatch: pytest.MonkeyPatch, branches: int) -> None:
    """What a branch may be doing multiplies by each further branch that the same event concerns."""
    names = [f"x{i}" for i in range(branches)]
    of = small.robot((), *(small.activity(f"do_{n}", ()) for n in (*names, "free")), events=("recall",))
    handlers = (Handler(event="recall", goto=SUCCEED),)
    blocks = tuple(Objective(name=n, activities=(f"do_{n}",), handlers=handlers) for n in names)
    mission = small.mission(
        of, Parallel(name="all", blocks=(*blocks, Objective(name="free", activities=("do_free",))))
    )
    monkeypatch.setattr(interrupting, "MAX_POSITIONS", 0)
    words = r"parallel block all: (\d+) combinations of where its branches are when the event recall happens"
    with pytest.raises(LimitError, match=words) as caught:
        compose(mission)
    told = int(str(caught.value).partition(": ")[2].split()[0])
    assert round(told ** (1 / branches)) ** branches == told
    monkeypatch.setattr(interrupting, "MAX_POSITIONS", told)
    compose(mission)
    monkeypatch.setattr(interrupting, "MAX_POSITIONS", told - 1)
    with pytest.raises(LimitError, match=f"the limit is {told - 1}"):
        compose(mission)


def test_hardware_that_alone_is_too_much() -> None:
    of = small.robot(small.hw(*(f"h{i}" for i in range(5))), small.activity("look", ()))
    found = compose(small.mission(of, Objective(name="x", activities=("look",))))
    alone = "5 hardware resources that may fail have 2\\^5 states"
    with pytest.raises(LimitError, match=alone):
        spaces_of(found).space(Choice("explicit", max_states=2**5 - 1), "alternatives")
    with pytest.raises(LimitError) as caught:
        spaces_of(found).space(Choice("explicit", max_states=2**5), "alternatives")
    assert "2^5" not in str(caught.value)


def with_tokens(initial: int, weight: int) -> PetriNet:
    builder = NetBuilder("many")
    builder.place("many", initial=initial)
    builder.place("out")
    builder.transition("take", consume={"many": weight}, produce=["out"])
    return builder.build()


def test_numbers_of_tokens() -> None:
    # A place of 40 bits, a weight of 62: no run is near them, so that the limits are on what is written.
    assert count_tokens(with_tokens(2**40 - 1, 2**39)).states == 2
    with pytest.raises(LimitError, match=f"many may hold more than {2**40 - 1} tokens"):
        count_tokens(with_tokens(2**40, 2**39))
    assert count_tokens(with_tokens(2, 2**62)).states == 1
    with pytest.raises(LimitError, match=f"take has a weight of more than {2**62}"):
        count_tokens(with_tokens(2, 2**62 + 1))


@given(st.integers(-(2**63) + 1, 2**63 - 1), st.integers(-(2**63) + 1, 2**63 - 1))
def test_weighted_sums_of_several_tokens(weight: int, bound: int) -> None:
    net = with_tokens(12, 1)
    spaces: dict[str, Space[Any]] = {
        "diagrams": DiagramMarkings(reach_markings(net)),
        "arrays": ArraySpace(explore_tokens(net)),
    }
    for name, space in spaces.items():
        for limit in (bound, 5 * weight, 12 * weight - 1):
            expected = sum(n * weight - (12 - n) <= limit for n in range(13))
            assert space.at_most({0: weight, 1: -1}, limit).count() == expected, name
        assert space.at_most({0: 2**61}, 10).count() == 1  # none of the tokens


def test_weights_of_tokens_have_a_limit() -> None:
    net = with_tokens(12, 1)
    with pytest.raises(LimitError, match="beyond 2\\^105"):
        DiagramMarkings(reach_markings(net)).at_most({0: 2**105}, 0)
    arrays = ArraySpace(explore_tokens(net))
    with pytest.raises(LimitError, match="weight of tokens is beyond 64 bits"):
        arrays.at_most({0: 2**63}, 0)
    with pytest.raises(LimitError, match="bound of tokens is beyond"):
        arrays.at_most({0: 1}, 2**127)
    with pytest.raises(LimitError, match="sum of tokens is beyond 64 bits"):
        arrays.graph.tokens({0: 2**62})


@given(st.integers(-(2**29), 2**29), st.integers() | st.integers(-(2**70), 2**70))
def test_weighted_sums_of_searches(weight: int, bound: int) -> None:
    net = with_tokens(12, 1)
    found = Searches(net).seek(AtMost(((0, weight),), bound), max_states=100)
    met = any(n * weight <= bound for n in range(13))
    assert found.outcome == ("reached" if met else "unreachable")


def wide(folder: Path, branches: int, hardware: int, concerned: int = 1, fault: bool = False) -> Path:
    """A mission of two lines: hardware that may fail, and a section of branches that use it.

    Each branch has its share of the hardware. The first resource is needed by the first branches
    (``concerned``) through what one activity produces, or a fault takes that of those out of service.
    """
    names = [f"h{i}" for i in range(hardware)]
    declared = "".join(f'<hardware name="{name}" shared="true"/>' for name in names)
    if fault:
        declared += f'<fault name="f" affects="{" ".join(names[:concerned])}"/>'
    declared += '<software name="s"/><activity name="p" produces="s" consumes="h0"/>'
    for i in range(branches):
        needed = [*names[i::branches], *(["s"] if i < concerned and not fault else [])]
        declared += f'<activity name="a{i}" consumes="{" ".join(needed)}"/>'
    inner = "".join(f'<objective name="o{i}" activities="a{i}"/>' for i in range(1, branches))
    nested = (
        '<objective name="s"><parallel name="q"><objective name="x" activities="a0"/></parallel></objective>'
    )
    block = f'<parallel name="p">{inner}{nested}</parallel>'
    path = folder / "wide.xml"
    robot = f'<robot name="r">{declared}</robot>'
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}\n{block}</mission>')
    return path


AT_ONCE = "branches that may run at the same time"


@pytest.mark.parametrize("engine", ["symbolic", "local"])
@pytest.mark.parametrize(
    ("refused", "found", "allowed"),
    [
        ((MOST_BRANCHES + 1, 1), f"31 {AT_ONCE}, .* is 30", (MOST_BRANCHES, 1)),
        ((1, MOST_HARDWARE + 1), "121 hardware resources that may fail, .* is 120", (1, MOST_HARDWARE)),
        ((30, 31), rf"930 \(30 {AT_ONCE}\) x \(31 hardware .*\), .* is 900", (30, 30)),
        ((20, 11, 2), rf"220 \(20 {AT_ONCE}\) x \(11 hardware .*\), .* is 200", (20, 10, 2)),
        ((12, 51, 2), rf"612 \(12 {AT_ONCE}\) x \(51 hardware .*\), .* is 600", (12, 50, 2)),
        ((12, 76), rf"912 \(12 {AT_ONCE}\) x \(76 hardware .*\), .* is 900", (12, 75)),
        (
            (15, 13, MOST_AT_ONCE + 1),
            f"13 {AT_ONCE} and that the loss of h0 concerns, .* is 12",
            (15, 13, 12),
        ),
        ((14, 13, 13, True), f"13 {AT_ONCE} and that the loss of f concerns, .* is 12", (14, 13, 12, True)),
    ],
)
def test_a_wide_section_is_refused_before_a_diagram_is_made(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    engine: Literal["symbolic", "local"],
    refused: tuple[Any, ...],
    found: str,
    allowed: tuple[Any, ...],
) -> None:
    class Begun(Exception):
        pass

    def begun(*_: object, **__: object) -> None:
        raise Begun

    monkeypatch.setattr("mcpn.composite.composing._explored", begun)
    monkeypatch.setattr("mcpn.composite.composing.nearest_fault", lambda *_: None)
    monkeypatch.setattr("mcpn.spaces.registry.reaching", begun)
    spaces = spaces_of(compose(read_mission(wide(tmp_path, *refused))))
    with pytest.raises(LimitError, match=rf"wide\.xml:2: p has {found}"):
        spaces.space(Choice(engine), "alternatives")
    with pytest.raises(Begun):
        spaces_of(compose(read_mission(wide(tmp_path, *allowed)))).space(Choice(engine), "alternatives")


@pytest.mark.parametrize("engine", ["symbolic", "local"])
def test_many_alternatives_are_refused_before_a_diagram_is_made(
    tmp_path: Path, engine: Literal["symbolic", "local"]
) -> None:
    names = [f"h{i}" for i in range(MOST_ALTERNATIVES + 1)]
    path = tmp_path / "m.xml"
    ways = "".join(f'<alternative name="by_{name}" consumes="{name}"/>' for name in names)
    declared = "".join(f'<hardware name="{name}"/>' for name in names)
    path.write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{declared}
        <activity name="a">{ways}</activity></robot><objective name="o" activities="a"/></mission>"""
    )
    spaces = spaces_of(compose(read_mission(path)))
    with pytest.raises(LimitError, match=r"m\.xml:2: o has 61 alternatives of activity a, .* is 60"):
        spaces.space(Choice(engine), "alternatives")
