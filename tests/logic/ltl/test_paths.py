"""What paths satisfy: by automata on every engine, by tableaux, and run by run."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import Justice, every_path, on_one_path, says_paths, some_path
from mcpn.logic.ltl.automaton import translated
from mcpn.logic.ltl.formulas import SomePath, is_of_paths, normal
from mcpn.logic.ltl.parts import PathParts
from mcpn.logic.ltl.path_search import FoundPath, PathSearch
from mcpn.logic.questions import Questions
from mcpn.logic.syntax import ON_PATH, parse, parse_open
from mcpn.logic.without_space import Known
from mcpn.logic.witness import explain
from mcpn.logic.writing import show
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.formula_names import Names
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.goal import Formula
from mcpn.turns import finished
from tests.draws import fewer
from tests.logic.formulas import Edges, Written, edges_of
from tests.logic.formulas import formulas as on_states
from tests.logic.formulas import read as read_on_states
from tests.logic.formulas import satisfying as states_satisfying
from tests.logic.ltl import tableau
from tests.logic.test_ctl import names, satisfy
from tests.nets.nets import nets, reachable, state_machines
from tests.shares import returns_early

MOST_NODES = 5_000
"""Of the tableau of one formula on one net."""

EVERYWHERE, NOWHERE = ("<=", (0,), (0, "p")), ("<", (0, "p"), (0,))
"""Of the place ``p``, by formulas of which only the markings tell it."""
NETS = nets(max_places=4, max_transitions=5) | state_machines().map(lambda drawn: drawn[0])


def test_each_operator_on_one_path_is_judged() -> None:
    """By the tableaux, which share nothing with the automata, on formulas that are drawn with it."""
    assert {*tableau.OF_ONE, *tableau.OF_TWO} == ON_PATH.keys() - {"A", "E"}


def spaces(net: PetriNet) -> list[Space[Any]]:
    return [ArraySpace(explore(net)), DiagramMarkings(reach(net))]


def fits(written: Written, edges: Edges) -> bool:
    if len(edges) * 2 ** len(tableau.promises(written)) <= MOST_NODES:
        return True
    returns_early("a large tableau")
    return False


def assert_shown(evaluation: Evaluation[Any], formula: Formula, written: Written, edges: Edges) -> None:
    """The run that shows a path is one of the net, and satisfies the formula by its definition."""
    net, witness = evaluation.space.net, explain(evaluation, formula)
    marking, run = net.initial, list[tuple[Marking, int | None]]()
    for t in witness.firings:
        assert t in net.enabled(marking)
        run.append((marking, t))
        marking = net.fire(marking, t)
    cycle = witness.cycle_firing
    event(f"decided by a part of a path: {witness.decided}")
    if witness.decided:
        for choice in range(3):
            further, begin = gone_on(net, marking, choice)
            assert tableau.on_lasso(written, net, edges, run + further, len(run) + begin)
        return
    if cycle is None:
        assert not edges[marking]
        cycle = len(run)
        run.append((marking, None))
    else:
        assert run[cycle][0] == marking
    assert tableau.on_lasso(written, net, edges, run, cycle)


def gone_on(net: PetriNet, marking: Marking, choice: int) -> tuple[list[tuple[Marking, int | None]], int]:
    """How a path goes on from a marking, always by the same choice of what may fire; where that repeats."""
    run, seen = list[tuple[Marking, int | None]](), dict[Marking, int]()
    while marking not in seen:
        seen[marking] = len(run)
        enabled = net.enabled(marking)
        t = enabled[choice % len(enabled)] if enabled else None
        run.append((marking, t))
        marking = marking if t is None else net.fire(marking, t)
    return run, seen[marking]


def test_a_run_against_safety_ends_where_it_is_violated() -> None:
    builder = NetBuilder("counter")
    for name, tokens in (("a", 1), ("b", 0), ("c", 0)):
        builder.place(name, initial=tokens)
    for begin, end in ("ab", "bc", "ca"):
        builder.transition(f"{begin}{end}", consume=[begin], produce=[end])
    net = builder.build()
    for space in spaces(net):
        for text, length in (("G !fires(bc)", 2), ("G (a & X b -> X X a)", 2)):
            witness = explain(Evaluation(space), parse(text, Names(net)))
            assert (len(witness.steps), witness.decided, witness.cycle) == (length, True, None), text
        witness = explain(Evaluation(space), parse("F G a", Names(net)))
        assert (witness.decided, witness.cycle) == (False, 0)


@pytest.mark.parametrize(
    "written",
    [
        ("F", ("&", EVERYWHERE, ("X", EVERYWHERE))),
        ("G", ("F", ("&", EVERYWHERE, ("X", EVERYWHERE)))),
        ("G", ("|", ("&", NOWHERE, ("fires", "t")), ("X", NOWHERE))),
        ("F", ("&", ("->", NOWHERE, ("fires", "t")), ("X", ("EG", ("EX", EVERYWHERE))))),
        ("U", ("X", NOWHERE), ("&", ("X", EVERYWHERE), NOWHERE)),
    ],
    ids=tableau.text,
)
@pytest.mark.parametrize("fair", [False, True])
def test_what_holds_everywhere_or_nowhere_leaves_edges_that_are_no_loop(written: Written, fair: bool) -> None:
    builder = NetBuilder("one")
    builder.place("p", initial=1)
    builder.transition("t", consume=["p"], produce=["p"])
    net = builder.build()
    edges, justice = edges_of(net), [Justice(parse("p", Names(net)))] if fair else []
    for every in (written, ("!", written)):
        expected = tableau.satisfying(every, net, edges)
        for space in spaces(net):
            assert satisfy(Evaluation(space, justice), SomePath(normal(tableau.read(every, net)))) == expected


@given(NETS, st.data())
def test_automata_and_tableaux_find_the_same(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    for written in data.draw(st.lists(tableau.formulas(*names(net)), min_size=2, max_size=2)):
        if not fits(written, edges):
            continue
        expected = tableau.satisfying(written, net, edges)
        formula = parse(f"E ({tableau.text(written)})", Names(net))
        # The automaton alone, without what single states tell.
        alone = SomePath(normal(tableau.read(written, net)))
        assert formula == some_path(tableau.read(written, net))
        event(f"needs an automaton: {any(isinstance(f, SomePath) for f in formula.walk())}")
        event(f"some {bool(expected)}, all {len(expected) == len(edges)}")
        for space in spaces(net):
            for of in (formula, alone):
                assert Evaluation(space).holds(of) == (net.initial in expected)
                evaluation = Evaluation(space)
                assert satisfy(evaluation, of) == expected
            if net.initial in expected:
                assert_shown(evaluation, alone, written, edges)


@fewer(0.2)  # hundreds of formulas each
@given(NETS, st.sampled_from(["", "!"]))
def test_one_operator_on_two_conditions_is_asked_state_by_state(net: PetriNet, negated: str) -> None:
    """All pairs of places, since few are both so for a while and then neither."""
    assume(reachable(net)[2])
    edges, built = edges_of(net), spaces(net)
    for one, other in permutations(names(net)[0], 2):
        for operator in "URW":
            second = ("place", other)
            written = operator, ("place", one), ("!", second) if negated else second
            expected = tableau.satisfying(written, net, edges)
            formula = parse(f"E ({tableau.text(written)})", Names(net))
            assert not any(isinstance(part, SomePath) for part in formula.walk())
            event(f"{operator}: some {bool(expected)}, all {len(expected) == len(edges)}")
            for space in built:
                assert satisfy(Evaluation(space), formula) == expected


@fewer(0.6)
@given(NETS, st.data())
def test_paths_that_do_not_count_are_left_out(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    places, transitions = names(net)
    fires = st.lists(st.sampled_from(range(len(transitions))), max_size=2) if transitions else st.just([])
    fair = data.draw(st.lists(st.tuples(on_states(places, transitions, leaves=2), fires), max_size=2))
    justice = [Justice(read_on_states(f, net), tuple(t)) for f, t in fair]
    met = [(states_satisfying(f, net, edges), set(t)) for f, t in fair]
    # Fairness is of all paths, of those of CTL in the leaves too, for which tableaux ask another oracle.
    written = data.draw(tableau.formulas(places, transitions, of_ctl=False))
    if not fits(written, edges):
        return
    expected = tableau.satisfying(written, net, edges, met)
    alone = SomePath(normal(tableau.read(written, net)))
    # What single states say is written in CTL; where no path counts, no state begins one.
    asked = parse(f"E ({tableau.text(written)})", Names(net), fair=bool(justice))
    for space in spaces(net):
        evaluation = Evaluation(space, justice)
        assert satisfy(evaluation, alone) == expected
        assert satisfy(evaluation, asked) == expected
        assert Evaluation(space, justice).holds(alone) == (net.initial in expected)
        if net.initial in expected:
            assert_shown(evaluation, alone, written, edges)


@pytest.mark.parametrize("engine", ["explicit", "symbolic", "auto"])
def test_where_no_path_counts_every_path_satisfies_all(engine: Asked) -> None:
    builder = NetBuilder("never fair")
    builder.place("p", initial=1)
    builder.place("q")
    builder.transition("a", consume=["p"], produce=["p"])
    questions = Questions(builder.build(), engine=engine, fair=["q"])
    for some in ("EG true", "E (G true)", "E (true)", "E (p)", "E (X p)", "E (q | F p)", "E (F (p | X p))"):
        assert not questions.answer(some).holds, some
    for every in ("AG q", "A (G q)", "A (F q)", "A (q)", "A (q & F p)", "A (false)", "F q", "G false", "X q"):
        assert questions.answer(every).holds, every
    assert questions.answer("p").holds
    assert not questions.answer("q").holds


def test_a_path_that_ends_counts_whatever_must_happen_again_and_again() -> None:
    builder = NetBuilder("ends")
    for name, tokens in (("a", 1), ("b", 0), ("never", 0)):
        builder.place(name, initial=tokens)
    builder.transition("again", consume=["a"], produce=["a"])
    builder.transition("end", consume=["a"], produce=["b"])
    net = builder.build()
    justice = [Justice(parse("never", Names(net)))]
    for space in spaces(net):
        for text, holds in (("F b", True), ("G a", False), ("F (a & X b)", True)):
            written = SomePath(normal(parse_open(text, Names(net))))
            assert Evaluation(space, justice).holds(written) == holds, text


@given(st.data())
def test_what_is_shown_of_paths_reads_back(data: st.DataObject) -> None:
    net = data.draw(nets(max_places=3))
    of_net = Names(net)
    path = tableau.read(data.draw(tableau.formulas(*names(net))), net)
    for formula in (some_path(path), every_path(path), SomePath(normal(path))):
        text = show(formula, of_net)
        again = parse(text, of_net)
        event(f"on paths: {is_of_paths(path)}")
        for space in spaces(net) if reachable(net)[2] else ():
            assert satisfy(Evaluation(space), again) == satisfy(Evaluation(space), formula)


def assert_found(found: FoundPath, net: PetriNet, written: Written, edges: Edges) -> None:
    """A path that a search has found is one of the net, and satisfies the formula however it goes on."""
    marking, run = net.initial, list[tuple[Marking, int | None]]()
    for t in found.run:
        assert t in net.enabled(marking)
        run.append((marking, t))
        marking = net.fire(marking, t)
    if found.cycle is not None:
        assert marking == run[found.cycle][0]
        assert tableau.on_lasso(written, net, edges, run, found.cycle)
    for choice in range(3) if found.cycle is None else ():
        further, begin = gone_on(net, marking, choice)
        assert tableau.on_lasso(written, net, edges, run + further, len(run) + begin)


@given(NETS, st.data())
def test_a_search_finds_what_tableaux_find(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    for written in data.draw(st.lists(tableau.formulas(*names(net), of_ctl=False), min_size=2, max_size=2)):
        if not fits(written, edges):
            continue
        expected = net.initial in tableau.satisfying(written, net, edges)
        search = PathSearch(net, translated(normal(tableau.read(written, net))))
        assert search.fits
        for seed in range(3):
            found = search.search(100_000, seed)
            assert found.outcome == ("found" if expected else "none")
            if expected:
                event(f"repeats: {found.cycle is not None}")
                assert_found(found, net, written, edges)
        for seed in range(2):
            found = search.search(100, seed, guided=True)
            event(f"guided: {found.outcome}, where there is one: {expected}")
            assert found.outcome in (("found", "steps") if expected else ("none", "steps"))
            if found.outcome == "found":
                assert_found(found, net, written, edges)


def test_a_search_for_paths_says_which_limit_it_hit() -> None:
    net = bits(20)
    formula = parse_open("(F G tokens(on0, off0) = 2) & F (on1 & X on2)", Names(net))
    search = PathSearch(net, translated(normal(formula)))
    assert search.search(1_000, 0).outcome == "steps"
    assert search.search(10_000_000, 0, max_bytes=1 << 20).outcome == "bytes"
    grows = NetBuilder("grows")
    grows.place("heap")
    grows.transition("more", produce=["heap"])
    automaton = translated(normal(parse_open("G F !heap", Names(grows.build()))))
    assert PathSearch(grows.build(), automaton).search(10**9, 0, max_bytes=1 << 20).outcome == "bytes"


def bits(count: int) -> PetriNet:
    """Bits that go on and off, each by itself."""
    builder = NetBuilder("bits")
    for bit in range(count):
        builder.place(f"off{bit}", initial=1)
        builder.place(f"on{bit}")
        builder.transition(f"up{bit}", consume=[f"off{bit}"], produce=[f"on{bit}"])
        builder.transition(f"down{bit}", consume=[f"on{bit}"], produce=[f"off{bit}"])
    return builder.build()


def test_a_guided_search_goes_to_what_is_asked_for_and_back() -> None:
    net = bits(24)
    all_on, all_off = (" & ".join(f"{state}{bit}" for bit in range(24)) for state in ("on", "off"))
    for text in (
        f"(G F ({all_on})) & G F ({all_off})",
        f"F ({all_on} & X G on3)",
        f"F (({all_on}) & F G ({all_off} | on5))",
    ):
        search = PathSearch(net, translated(normal(parse_open(text, Names(net)))))
        assert search.search(20_000, 1).outcome == "steps"
        found = search.search(500, 1, guided=True)
        assert found.outcome == "found", text
        assert found.cycle is not None
        marking, passed = net.initial, [net.initial]
        for t in found.run:
            assert t in net.enabled(marking)
            passed.append(marking := net.fire(marking, t))
        assert passed[found.cycle] == marking
        on = {sum(m[net.place_index[f"on{bit}"]] for bit in range(24)) for m in passed[found.cycle :]}
        if text.startswith("(G F"):
            assert {0, 24} <= on


@pytest.mark.parametrize("guided", [False, True])
def test_pauses_change_nothing_of_a_search_for_paths(guided: bool) -> None:
    net, rests = bits(9), 0
    for text in ("(G F (on0 & on1 & on2 & on6)) & G F (off0 & off1 & on3)", "F (on8 & X G (on2 & off8))"):
        finder = PathSearch(net, translated(normal(parse_open(text, Names(net)))))._finder
        for seed in range(3):
            whole = finder.search(500, 1 << 30, seed, guided, 1 << 40)
            finder.search(500, 1 << 30, seed + 1, guided, 1)  # which rests, and is not gone on with
            while (paused := finder.search(500, 1 << 30, seed, guided, 1))[0] == "pause":
                rests += 1
            assert paused == whole
    assert rests > 30


@given(NETS, st.data())
def test_parts_of_formulas_are_decided_marking_by_marking(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    written = data.draw(tableau.formulas(*names(net), of_ctl=False))
    if not fits(written, edges):
        return
    expected = net.initial in tableau.satisfying(written, net, edges)
    formula = some_path(tableau.read(written, net))
    known = Known(net, settled=False)
    parts = PathParts(net)
    path = on_one_path(formula, net)
    event(f"read as one path: {path is not None}; needs an automaton: {says_paths(formula)}")
    if path is None:
        return
    for of in (formula, known.simple(formula)):
        for enrich in (False, True):
            path = on_one_path(of, net)
            assert path is not None
            found = parts.decide(path, 100_000, 1, enrich=enrich)
            assert found is not None
            assert found.outcome == ("found" if expected else "none")


def is_without_next(written: Written) -> bool:
    operator, *operands = written
    return operator not in ("X", "fires") and all(
        is_without_next(f) for f in operands if isinstance(f, tuple)
    )


@given(NETS, st.data())
def test_a_path_of_a_smaller_net_is_one_of_the_net(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    written = data.draw(tableau.formulas(*names(net), of_ctl=False).filter(is_without_next))
    for operator in data.draw(st.sampled_from(["", "FG", "GF"])):
        written = (operator, written)
    if not fits(written, edges):
        return
    expected = net.initial in tableau.satisfying(written, net, edges)
    parts = PathParts(net)
    path = normal(tableau.read(written, net))
    found = parts.decide(path, 100_000, 1, enrich=True)
    assert found is not None
    assert found.outcome == ("found" if expected else "none")
    asked = parts._searches[path]
    smaller = None if asked is None or asked.reduction is None else asked.reduction
    fewer = smaller is not None and len(smaller.net.places) < len(net.places)
    event(f"in a smaller net: {fewer}, {found.outcome}, repeats: {found.cycle is not None}")
    if expected:
        assert_found(found, net, written, edges)


def test_a_cycle_of_a_smaller_net_alone_is_not_shown() -> None:
    """What counts the rounds is left out of the smaller net, and keeps every round from being a cycle."""
    builder = NetBuilder("counts its rounds")
    for name, tokens in (("a", 1), ("b", 0), ("rounds", 0)):
        builder.place(name, initial=tokens)
    builder.transition("ab", consume=["a"], produce=["b"])
    builder.transition("ba", consume=["b"], produce=["a", "rounds"])
    net = builder.build()
    path = normal(parse_open("(G F a) & G F b", Names(net)))
    reduced = PathParts(net)._reduced(path)
    assert reduced is not None
    smaller, there = reduced
    assert PathSearch(smaller.net, translated(there)).search(1_000, 1).cycle is not None
    found = PathParts(net).decide(path, 1_000, 1, enrich=True)
    assert found is not None
    assert found.outcome != "found"


def test_what_comes_on_every_path_is_known_before_the_search() -> None:
    builder = NetBuilder("ends, and counts meanwhile")
    for name, tokens in (("begun", 1), ("ended", 0), ("even", 1), ("odd", 0)):
        builder.place(name, initial=tokens)
    builder.transition("end", consume=["begun"], produce=["ended"])
    builder.transition("up", consume=["even", "ended"], produce=["odd", "ended"])
    builder.transition("down", consume=["odd", "ended"], produce=["even", "ended"])
    net = builder.build()
    parts = PathParts(net)
    for text, refuted in (
        ("(G F odd) & (G F even) & G !ended", True),  # what comes on every path comes here never
        ("(G F odd) & (G F even) & F ended", False),
        ("(G F odd) & X X !ended", False),  # none is so, but what comes at some time does not say it
    ):
        assert finished(parts._refuting(normal(parse_open(text, Names(net))))) == refuted
        found = parts.decide(parse_open(text, Names(net)), 100, 1, enrich=True)
        assert found is not None
        assert found.outcome == ("found" if text.endswith("F ended") else "none")


def test_a_path_is_shown_where_there_is_no_space() -> None:
    builder = NetBuilder("grows")
    for name, tokens in (("a", 1), ("b", 0), ("heap", 0)):
        builder.place(name, initial=tokens)
    builder.transition("ab", consume=["a"], produce=["b"])
    builder.transition("ba", consume=["b"], produce=["a"])
    builder.transition("more", consume=["a"], produce=["a", "heap"])
    net = builder.build()
    fails = Questions(net, max_states=1_000).answer("(F G a) | F G (b | heap)")
    assert not fails.holds
    witness = fails.witness
    assert witness.cycle is not None
    assert {net.transitions[t].name for t in witness.repeated} == {"ab", "ba"}
    decided = Questions(net, max_states=1_000).answer("G (a & X b -> X X b)")
    *_, first, last = [net.transitions[t].name for t in decided.witness.firings]
    assert (first, last) == ("ab", "ba")
    assert decided.witness.decided
    assert any("decides it" in note for note in decided.witness.notes)
