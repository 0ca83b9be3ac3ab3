"""Files of properties and examinations that one call asks: answers as by definition, on one space."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.errors import Source
from mcpn.logic.answering import answer_all
from mcpn.logic.behaviour import EXAMINATIONS
from mcpn.logic.contest import Property
from mcpn.logic.questions import Questions
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.registry import Spaces
from tests.commands import mcpn, output
from tests.draws import fewer
from tests.logic.formulas import Edges, edges_of, formulas, read, satisfying
from tests.logic.test_behaviour import ahead
from tests.nets.nets import nets, reachable, state_machines, token_nets

SAFE = nets(max_places=5, max_transitions=6, events=False) | state_machines().map(lambda drawn: drawn[0])
ENGINES: tuple[Asked, ...] = ("auto", "symbolic", "explicit")


def examined(net: PetriNet, edges: Edges) -> dict[str, bool]:
    fired = {marking: {t for at in ahead(edges, marking) for t, _ in edges[at]} for marking in edges}
    transitions = set(range(len(net.transitions)))
    values = {
        "ReachabilityDeadlock": not all(edges.values()),
        "QuasiLiveness": fired[net.initial] == transitions,
        "Liveness": all(later == transitions for later in fired.values()),
        "OneSafe": all(max(marking) <= 1 for marking in edges),
        "StableMarking": any(len({m[p] for m in edges}) == 1 for p in range(len(net.places))),
    }
    return {f"{net.name}-{name}": value for name, value in values.items()}


@pytest.mark.parametrize("engine", ENGINES)
@fewer(0.4)
@given(SAFE | token_nets(), st.data())
def test_all_are_answered_as_the_definitions_say_on_one_space(
    engine: Asked, net: PetriNet, data: st.DataObject
) -> None:
    assume(_small(net))
    edges = edges_of(net)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    drawn = formulas(places, transitions, leaves=5)
    expected = {name: str(value).upper() for name, value in examined(net, edges).items()}
    asked = []
    for file in ("a", "b"):
        for number in range(2):
            formula = data.draw(drawn)
            asked.append(Property(f"{file}{number}", read(formula, net), Source(file)))
            value = net.initial in satisfying(formula, net, edges)
            expected[f"{file}{number}"] = str(value).upper()
        bound = tuple(data.draw(st.lists(st.sampled_from(places), min_size=1, max_size=3)))
        asked.append(Property(f"{file}-bound", tuple(net.place_index[name] for name in bound), Source(file)))
        most = max(sum(marking[net.place_index[name]] for name in bound) for marking in edges)
        expected[f"{file}-bound"] = str(most)
    questions = Questions(net, engine=engine)
    made: list[object] = []

    def counted(build: Callable[..., object]) -> Callable[..., object]:
        def counting(*given: object, **more: object) -> object:
            made.append(build(*given, **more))
            return made[-1]

        return counting

    with patch("mcpn.spaces.registry.Spaces.space", counted(Spaces.space)):
        answers = [
            (found.name, found.value) for found in answer_all(questions, asked, (*EXAMINATIONS, "OneSafe"))
        ]
    assert len(answers) == len(expected)
    assert dict(answers) == expected
    assert len(made) == 1 or (engine == "auto" and not made)


@pytest.mark.parametrize("engine", ENGINES)
@given(SAFE | token_nets())
def test_a_space_that_is_there_says_whether_its_net_is_1_safe(engine: Asked, net: PetriNet) -> None:
    assume(_small(net))
    questions = Questions(net, engine=engine)
    assert questions.space.everything.count() == len(edges_of(net))
    assert questions.one_safe() == all(max(marking) <= 1 for marking in edges_of(net))


def _small(net: PetriNet) -> bool:
    found, _, safe = reachable(net)
    if safe:
        return True
    markings, stack = set(found), list(found)
    while stack and len(markings) < 300:
        marking = stack.pop()
        after = {net.fire(marking, t) for t in net.enabled(marking)} - markings
        markings |= after
        stack.extend(after)
    return not stack


NET = "net buffer\npl ready (1)\ntr make ready -> full\ntr take full -> ready\n"
FILE = """<property-set xmlns="http://mcc.lip6.fr/"><property><id>{name}</id>
<description/><formula>{formula}</formula></property></property-set>"""
FULL = (
    "<exists-path><finally><integer-le><integer-constant>1</integer-constant>"
    "<tokens-count><place>{place}</place></tokens-count></integer-le></finally></exists-path>"
)
BOUND = "<place-bound><place>ready</place><place>{place}</place></place-bound>"

AGAIN = (
    "<all-paths><globally><exists-path><finally><integer-le><tokens-count><place>p</place></tokens-count>"
    "<tokens-count><place>q</place></tokens-count></integer-le></finally></exists-path></globally></all-paths>"
)
"""Where ever more tokens come to two places, no walk and no equation tells."""


@pytest.fixture
def given_files(tmp_path: Path) -> Path:
    (tmp_path / "net.net").write_text(NET)
    (tmp_path / "a.xml").write_text(FILE.format(name="reached", formula=FULL.format(place="full")))
    (tmp_path / "b.xml").write_text(FILE.format(name="most", formula=BOUND.format(place="full")))
    return tmp_path


def asking(folder: Path, *names: str) -> list[object]:
    return ["ask", folder / "net.net", *(part for name in names for part in ("--properties", folder / name))]


def test_files_and_examinations_share_a_call(given_files: Path) -> None:
    asked = asking(given_files, "a.xml", "b.xml")
    run = mcpn(*asked, "--examination", "Liveness", "--examination", "OneSafe")
    assert run.returncode == 0
    answers = {line.split()[1]: line.split()[2] for line in run.stdout.splitlines()}
    assert answers == {
        "reached": "TRUE",
        "most": "1",
        "buffer-Liveness": "TRUE",
        "buffer-OneSafe": "TRUE",
    }
    found = output(*asked, "--examination", "Liveness", "AG EF full")
    assert [answer["formula"] for answer in found][-1] == "AG EF full"
    assert {answer["formula"]: answer["holds"] for answer in found} == {
        "reached": True,
        "most": None,
        "buffer-Liveness": True,
        "AG EF full": True,
    }
    # A file that is named twice is one file.
    assert len(output(*asked, "--properties", given_files / "a.xml")) == 2


def test_answers_come_in_the_order_of_the_files(given_files: Path) -> None:
    """Also where a later one is known first: it waits; and where the rest ends in an error it is told."""
    first, *rest = ("EF", ("place", "full")), ("true",), ("false",)
    asked = [Property(f"p{n}", read(f, _buffer()), Source("a.xml")) for n, f in enumerate([first, *rest])]
    found = [verdict.name for verdict in answer_all(Questions(_buffer()), asked)]
    assert found[0] != "p0"  # the others need no search
    body = "".join(
        FILE.format(name=f"p{n}", formula=formula).partition('/">')[2].removesuffix("</property-set>")
        for n, formula in enumerate([FULL.format(place="full"), "<true/>", "<false/>"])
    )
    (given_files / "c.xml").write_text(f'<property-set xmlns="http://mcc.lip6.fr/">{body}</property-set>')
    run = mcpn(*asking(given_files, "c.xml", "a.xml"), "--examination", "OneSafe")
    names = ["p0", "p1", "p2", "reached", "buffer-OneSafe"]
    assert [line.split()[1] for line in run.stdout.splitlines()] == names
    told = output(*asking(given_files, "c.xml", "a.xml"), "--examination", "OneSafe")
    assert [answer["formula"] for answer in told] == names


def _buffer() -> PetriNet:
    builder = NetBuilder("buffer")
    builder.place("ready", initial=1)
    builder.place("full")
    builder.transition("make", consume=["ready"], produce=["full"])
    return builder.build()


def test_what_is_known_is_told_where_the_rest_is_not(tmp_path: Path) -> None:
    """A net without bound, of which one question needs all markings: the answers to the others are told."""
    (tmp_path / "net.net").write_text("net grows\ntr t -> p\ntr u p -> q\ntr v q ->\n")
    body = "".join(
        FILE.format(name=name, formula=formula).partition('/">')[2].removesuffix("</property-set>")
        for name, formula in (("again", AGAIN), ("yes", "<true/>"))
    )
    (tmp_path / "a.xml").write_text(f'<property-set xmlns="http://mcc.lip6.fr/">{body}</property-set>')
    run = mcpn(*asking(tmp_path, "a.xml"), "--max-states", 1000)  # else it goes on for 125,000,000 steps
    assert run.returncode == 1
    assert run.stdout.split() == ["FORMULA", "yes", "TRUE", "TECHNIQUES", *run.stdout.split()[4:]]
    assert "unbounded" in run.stderr


def test_errors_of_several_formulas_say_which(given_files: Path) -> None:
    run = mcpn(
        "ask", given_files / "net.net", "AG EF full", "EF fall", "EF (full &&", "EF a_name_that_is_long"
    )
    assert (run.returncode, run.stdout) == (2, "")
    for words in (
        "formula 2, 'EF fall': column 4: no place is named fall; did you mean full",
        "formula 3, 'EF (full &&': column 12: found the end",
        "formula 4, 'EF a_name_that_is_long': column 4: no place is named a_name_that_is_long",
    ):
        assert words in run.stderr
    assert "formula 1" not in run.stderr
    alone = mcpn("ask", given_files / "net.net", "EF fall")
    assert "formula, column 4: no place is named fall" in alone.stderr


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            FILE.format(name="x", formula=BOUND.format(place="fall")),
            "x: no place is named fall; did you mean full",
        ),
        (
            FILE.format(name="x", formula=FULL.format(place="fall")),
            "x: no place is named fall; did you mean full",
        ),
        (FILE.format(name="reached", formula=FULL.format(place="full")), "a second time, expected"),
        (FILE.format(name="x", formula="<finally/>"), "found <finally>, expected"),
        ("<property-set", "b.xml:1"),
    ],
)
def test_an_error_in_one_file_is_found_before_any_is_answered(
    given_files: Path, text: str, words: str
) -> None:
    (given_files / "b.xml").write_text(text)
    run = mcpn(*asking(given_files, "a.xml", "b.xml"), "--examination", "Liveness")
    assert (run.returncode, run.stdout) == (2, "")
    assert words in run.stderr
    assert "b.xml:" in run.stderr
    assert mcpn(*asking(given_files, "a.xml", "b.xml"), "--json").stdout == ""
