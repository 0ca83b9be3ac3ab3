"""How many states an engine lists of a second graph, beside the one that it was chosen for."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.spaces.engines import Choice

LIMITS = st.none() | st.integers(1, 100)


@given(LIMITS, LIMITS, st.integers(1, 100))
def test_few_states_do_not_limit_what_they_were_chosen_before(
    allowed: int | None, own: int | None, most: int
) -> None:
    """Where states are few their limit is low; that of another graph is the user's, or ``most``."""
    brief = Choice("explicit", "the stable states are few", own, allowed, brief=True)
    found = brief.second_limit(most)
    assert found in ({most} if allowed is None else {most, allowed})
    assert found <= most
    assert allowed is None or found <= allowed
    named = Choice("explicit", max_states=own)
    assert named.second_limit(most) == named.limit
