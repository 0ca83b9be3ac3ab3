"""The token game: a net played transition by transition, back and forward (Murata 1989, section II).

>>> from mcpn.testing.nets import philosophers
>>> game = TokenGame(philosophers(2))
>>> [game.net.transitions[t].name for t in game.enabled]
['wake0', 'wake1']
>>> game.fire(game.enabled[0])
>>> game.back(), game.marking == game.net.initial
(0, True)
>>> game.forward(), game.run
(0, (0,))
"""

from __future__ import annotations

from mcpn.errors import DivergenceError, LimitError
from mcpn.nets.petri import Marking, PetriNet

MOST_FIRED = 100_000
"""Firings of one run to completion: where it does not end, nothing else stops it."""


class TokenGame:
    """A net that is played; priorities are respected, and places may hold any number of tokens.

    Args:
        net: The net.

    Attributes:
        net: The same.
        marking: The tokens now.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self.marking: Marking = net.initial
        self._past: list[tuple[Marking, int]] = []
        self._undone: list[int] = []

    @property
    def run(self) -> tuple[int, ...]:
        """The transitions fired, those taken back left out."""
        return tuple(transition for _, transition in self._past)

    @property
    def enabled(self) -> list[int]:
        """The transitions that may fire now."""
        return self.net.enabled(self.marking)

    def fire(self, transition: int) -> None:
        """Fires an enabled transition; what was taken back is forgotten."""
        self._undone.clear()
        self._fire(transition)

    def _fire(self, transition: int) -> None:
        self._past.append((self.marking, transition))
        self.marking = self.net.fire(self.marking, transition)

    def back(self) -> int | None:
        """Takes back the last firing, and says which; ``None`` at the beginning."""
        if not self._past:
            return None
        self.marking, transition = self._past.pop()
        self._undone.append(transition)
        return transition

    def forward(self) -> int | None:
        """Fires again what was taken back last, and says which; ``None`` where nothing was."""
        if not self._undone:
            return None
        transition = self._undone.pop()
        self._fire(transition)
        return transition

    def restart(self) -> None:
        """Goes back to the initial marking; :meth:`forward` leads on from there."""
        while self.back() is not None:
            pass

    def settle(self) -> tuple[int, ...]:
        """Fires internal transitions, the first that is enabled each time, until none is.

        Returns:
            The transitions fired.

        Raises:
            DivergenceError: It comes back to a marking, so does not end; nothing has changed then.
            LimitError: It has not ended; nothing has changed then.
        """
        before, seen = len(self._past), set[Marking]()
        while (enabled := self.enabled) and self.net.transitions[enabled[0]].internal:
            fired, again = len(self._past) - before, self.marking in seen
            if again or fired == MOST_FIRED:
                for _ in range(fired):
                    self.back()
                self._undone.clear()
                if again:
                    raise DivergenceError(f"internal evolution never ends: firing {fired} comes back")
                raise LimitError(f"no stable marking after {MOST_FIRED} internal firings: the limit was hit")
            seen.add(self.marking)
            self.fire(enabled[0])
        return self.run[before:]
