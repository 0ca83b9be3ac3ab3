"""The 55 formulas of Dwyer, Avrunin and Corbett against what they mean, on all short words."""

from __future__ import annotations

import pytest

from mcpn.answers.patterns import catalogue
from mcpn.answers.patterns.catalogue import MENDED, PUBLISHED, SCOPES, after_step, used
from tests.answers.patterns.scoped import MEANT, bounded, meant
from tests.answers.patterns.words import Words, short

OF_SCOPES = {"globally": "", "before": "r", "after": "q", "between": "qr", "after_until": "qr"}
LENGTHS = {1: (6, None), 2: (6, None), 3: (5, None), 4: (4, None), 5: (4, 2), 6: (4, 2)}
"""By the number of atoms: how long words are, and how many atoms may be true at once (None: all)."""
ALL = [(pattern, scope) for pattern in PUBLISHED for scope in SCOPES]


def words_of(pattern: str, scope: str) -> list[Words]:
    atoms = MEANT[pattern][0] + OF_SCOPES[scope]
    return list(short(atoms, *LENGTHS[len(atoms)]))


def test_there_are_eleven_patterns_in_five_scopes() -> None:
    assert len(ALL) == 55
    assert set(PUBLISHED) == set(MEANT)


@pytest.mark.parametrize(("pattern", "scope"), ALL)
def test_what_is_used_is_what_is_meant(pattern: str, scope: str) -> None:
    for words in words_of(pattern, scope):
        differing = words.satisfying(used(pattern, scope)) ^ meant(words, scope, MEANT[pattern][1])
        assert not differing.any(), words.shown(differing)


@pytest.mark.parametrize(("pattern", "scope"), [each for each in ALL if "q" in OF_SCOPES[each[1]]])
def test_after_an_event_a_scope_begins_one_state_later(pattern: str, scope: str) -> None:
    """``q`` is true of the state that the event leaves: by the same plain definitions, one position on."""
    for words in words_of(pattern, scope):
        found = words.satisfying(after_step(used(pattern, scope)))
        differing = found ^ meant(words, scope, MEANT[pattern][1], later=1)
        assert not differing.any(), words.shown(differing)


@pytest.mark.parametrize(("pattern", "scope"), [(p, s) for p, scopes in MENDED.items() for s in scopes])
def test_what_is_mended_was_wrong(pattern: str, scope: str) -> None:
    assert any(
        (words.satisfying(PUBLISHED[pattern][scope]) ^ meant(words, scope, MEANT[pattern][1])).any()
        for words in words_of(pattern, scope)
    )


@pytest.mark.parametrize("most", [1, 2, 3])
@pytest.mark.parametrize("scope", SCOPES)
def test_any_number_may_bound_existence(scope: str, most: int) -> None:
    for words in short("p" + OF_SCOPES[scope], 6 if len(OF_SCOPES[scope]) < 2 else 5):
        differing = words.satisfying(catalogue.bounded(most)[scope]) ^ meant(words, scope, bounded(most))
        assert not differing.any(), words.shown(differing)
