"""Questions about a net or a mission in temporal logic, asked one at a time."""

from __future__ import annotations

from mcpn.logic.questions import Answer, Session
from mcpn.logic.verdicts import answer_typed


class Questions(Session):
    """Answers questions about one net: those that are asked of one object share its space."""

    def answer(self, text: str) -> Answer:
        """Answers a formula, and shows by a run why; see :func:`mcpn.logic.verdicts.answer_typed`."""
        return answer_typed(self, [text])[0]
