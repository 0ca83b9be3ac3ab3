"""Trees that others wrote, where their folder is given: translated, or refused with a line."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.errors import InputError
from mcpn.trees.importing import translate
from mcpn.trees.ledger import Kind
from mcpn.trees.reading import read_forest


def test_trees_of_others_are_translated_or_refused_with_a_line(request: pytest.FixtureRequest) -> None:
    given = request.config.getoption("--trees")
    if not given:
        pytest.skip("needs a folder of behaviour trees: --trees")
    large, unplaced = list[Kind](), list[Path]()
    for path in sorted(Path(given).rglob("*.xml")):
        try:
            forest = read_forest(path)
            made = translate(forest, "others", path.name)
        except InputError as error:
            unplaced += [path for problem in error.problems if not problem.source or not problem.source.line]
            continue
        if len(made.ledger.entries) >= 10:
            large.append(made.ledger.kind)
        # Every node of the trees that are used is in the ledger, once.
        assert len({id(entry.node) for entry in made.ledger.entries}) == len(made.ledger.entries)
    assert unplaced == []
    assert 3 * sum(kind in (Kind.EXACT, Kind.TIME) for kind in large) >= 2 * len(large) > 0
