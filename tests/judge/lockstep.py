"""A mission in lockstep: the interpreter beside all that plays it in mcpn, over every pair of states."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.testing.judge import lockstep
from mcpn.testing.judge.lockstep import MOST_STATES, Mismatch, TooLargeError
from tests.judge.players import controllers, graphs

MOST_TRANSITIONS = 2_000
"""Larger nets are not judged: a proof on their diagrams takes minutes."""


@dataclass
class Verdict:
    """How a mission was judged.

    Args:
        kind: ``agree``; ``undetermined``, where something is contended at one moment and all agree elsewhere;
            ``too large``.
        states: Stable states of the interpreter.
        pairs: Pairs of a state of the interpreter and one of a player, by player.
    """

    kind: str
    states: int = 0
    pairs: Counter[str] = field(default_factory=Counter)


class Judge(lockstep.Judge):
    """Holds the interpreter against all ways in which mcpn plays a mission."""

    def judge(self, mission_net: MissionNet | None = None, most: int = MOST_STATES) -> Verdict:
        """Judges the mission.

        Args:
            mission_net: Its net, where that has been made.
            most: A mission of more stable states is too large.

        Raises:
            Mismatch: Somebody differs from the interpreter.
        """
        try:
            determined = self.explore(most)
            mission_net = mission_net or compose(self.mission)
            if len(mission_net.net.transitions) > MOST_TRANSITIONS:
                return Verdict("too large")
        except (TooLargeError, LimitError):
            return Verdict("too large")
        verdict = Verdict("agree" if determined else "undetermined", len(self._after))
        try:
            for players in (graphs, controllers):
                for who, player in players(mission_net, 4 * most):
                    verdict.pairs[who] = self.lockstep(who, player)
        except SemanticsError as error:
            if determined:
                raise Mismatch("an engine", "confluence", [], "confluent", error) from error
        except LimitError:
            verdict.kind = "too large"
        return verdict
