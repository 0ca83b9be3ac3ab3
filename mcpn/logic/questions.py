"""The object that is asked formulas one at a time, with a run for each."""

from __future__ import annotations

from mcpn.logic.answering import answer_typed
from mcpn.logic.session import Answer, Session


class Questions(Session):
    """Answers questions about one net: those that are asked of one object share its space."""

    def answer(self, text: str) -> Answer:
        """Answers a formula, and shows by a run why; see :func:`mcpn.logic.answering.answer_typed`."""
        return answer_typed(self, [text])[0]
