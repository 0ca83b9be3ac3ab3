"""The test models and queries of TAPAAL's engine: what is read is answered as another evaluator does.

The ids of its queries end in a verdict, which is that of the net with time that a model was made of: of 70
of 488 queries it is another one than that of the model. So the judge lists markings by itself.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from lxml import etree

from mcpn.errors import InputError
from mcpn.logic.answering import answer_all
from mcpn.logic.contest import read_properties
from mcpn.logic.questions import Questions
from mcpn.nets.formats import read_net
from tests.logic import judge_of_queries as judge


@pytest.mark.parametrize("most", [200, pytest.param(20_000, marks=pytest.mark.slow)])
def test_every_answer_is_that_of_the_judge(tapaal: Path, most: int) -> None:
    counts = Counter[str]()
    for folder in sorted((tapaal / "test_models").iterdir()):
        graph = judge.graph(folder / "model.pnml", most)
        if graph is None:
            counts["larger"] += 1
            continue
        net = read_net(folder / "model.pnml")  # its markings are few: inhibitor arcs have bounds
        questions = Questions(net)
        properties = read_properties(folder / "query.xml", questions.names)
        asked = {
            (each.findtext("{*}id") or "").strip(): judge.satisfying(each, graph)
            for each in etree.parse(folder / "query.xml").iter("{*}property")
        }
        assert [each.name for each in properties] == list(asked), folder.name
        for verdict in answer_all(questions, properties):
            expected = str(graph.first in asked[verdict.name]).upper()
            assert verdict.value == expected, (folder.name, verdict.name)
            counts["answers"] += 1
        counts["models"] += 1
    assert counts["models"] > 100
    assert counts["answers"] > counts["models"]


@pytest.mark.parametrize("one_in", [6, pytest.param(1, marks=pytest.mark.slow)])
def test_every_model_is_read_or_refused_for_an_inhibitor_arc(
    tapaal: Path, fresh_seed: int, one_in: int
) -> None:
    read = refused = 0
    for folder in sorted((tapaal / "test_models").iterdir())[fresh_seed % one_in :: one_in]:
        if not any(
            arc.get("type") == "inhibitor" for arc in etree.parse(folder / "model.pnml").iter("{*}arc")
        ):
            questions = Questions(read_net(folder / "model.pnml"))
        else:
            try:
                questions = Questions(read_net(folder / "model.pnml"))
            except InputError as error:
                (problem,) = error.problems
                assert "found an inhibitor arc" in problem.message, folder.name
                assert problem.source is not None
                assert problem.source.line
                refused += 1
                continue
        assert read_properties(folder / "query.xml", questions.names)
        read += 1
    assert read > 20 * refused
