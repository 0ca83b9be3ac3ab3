"""What a check of many sites makes, counted: nothing that its answers do not need."""

from __future__ import annotations

import pytest

from experiments.growth.growth import of_natural
from mcpn.answers.claims.made import claims_of
from mcpn.answers.verdicts.mission import check
from mcpn.answers.verdicts.unreachable import never_happens
from mcpn.drawing.compose import compose
from mcpn.events import Event
from mcpn.spaces.projections import ImageStore


def test_what_never_happens_is_found_without_making_events(monkeypatch: pytest.MonkeyPatch) -> None:
    made = list[str]()
    counts = []
    for sites in (4, 8):
        net = compose(of_natural("sites")(sites))
        space = check(net).alternatives
        assert space is not None
        firings = space.firings(space.everything)
        never_happens(net, space, firings)
        with monkeypatch.context() as patched:
            patched.setattr(Event, "__post_init__", lambda event: made.append(event.element))
            made.clear()
            never_happens(net, space, firings)
        counts.append(len(made))
    assert counts == [0, 0]


def test_a_check_keeps_no_images_of_all_that_places_say(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes, initialise = list[int](), ImageStore.__init__

    def noted(images: ImageStore, levels: int) -> None:
        sizes.append(levels)
        initialise(images, levels)

    monkeypatch.setattr(ImageStore, "__init__", noted)
    net = compose(of_natural("sites")(4))
    assert claims_of(check(net))
    assert len(net.roles) not in sizes
