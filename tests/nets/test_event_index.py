"""The index of transitions by event says what asking each transition says."""

from hypothesis import given
from hypothesis import strategies as st

from mcpn.events import START, Event, What
from mcpn.nets.event_index import EventIndex

OF_OBJECTIVES = st.builds(
    Event, st.sampled_from((What.SUCCESS, What.FAILURE, What.TIMEOUT)), st.sampled_from("ab")
)
FOR_REASONS = st.builds(
    Event, st.just(What.FAILURE), st.sampled_from("ab"), st.sampled_from(("cold", "dark"))
)
EVENTS = st.one_of(st.none(), st.just(START), OF_OBJECTIVES, FOR_REASONS)


@given(st.lists(EVENTS, max_size=12), st.lists(OF_OBJECTIVES | FOR_REASONS, max_size=3, unique=True))
def test_as_each_transition_is_asked(carried: list[Event | None], asked: list[Event]) -> None:
    """Whichever way it is asked: by events, by what happens, and by what happens to an element."""
    index = EventIndex(carried)
    pairs = [(t, event) for t, event in enumerate(carried) if event is not None]
    assert list(index.pairs) == pairs
    assert index.carried == dict(pairs)
    assert list(index) == list(dict.fromkeys(event for _, event in pairs))
    assert index.internal == tuple(t for t, event in enumerate(carried) if event is None)
    assert sorted(index.of(*asked)) == [t for t, event in pairs if event in asked]
    assert all((event in index) == (event in carried) for event in asked)
    for what in What:
        assert sorted(index.carrying(what)) == [t for t, event in pairs if event.what is what]
        for element in ("",) if what is What.START else ("a", "b"):
            own = [t for t, event in pairs if (event.what, event.element) == (what, element)]
            assert sorted(index.of_element(what, element)) == own
