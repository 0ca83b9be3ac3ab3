"""The token game at a prompt: internal transitions too, one by one, back and forward."""

from __future__ import annotations

from mcpn.cli.play.prompt import Prompt
from mcpn.errors import DivergenceError, LimitError
from mcpn.nets.game import TokenGame
from mcpn.report.nets import arcs_in_words, marking_in_words, tokens_of
from mcpn.report.terminal import plain

HELP_WITH_TOKENS = """\
a transition's number, its name, or the beginning of its name: it fires
back                 take back the last firing
forward              fire again what was taken back
settle               fire internal transitions until none is enabled
restart              go back to the initial marking
run                  the transitions fired so far
state                the tokens, and what may fire
help, quit"""


class TokenSession(Prompt):
    """A net that is played, and what is printed of it.

    Args:
        game: The net.
        quiet: Whether nothing is printed but errors.
    """

    what = "a transition"
    words = ("back", "forward", "settle", "restart", "run", "state", "help", "quit")

    def __init__(self, game: TokenGame, quiet: bool) -> None:
        super().__init__(quiet)
        self.game = game
        self._transitions = game.net.transitions

    def possible(self) -> list[str]:
        """Names of the enabled transitions."""
        return [self._transitions[t].name for t in self.game.enabled]

    def show(self) -> None:
        """Prints the tokens, and what may fire with its arcs."""
        self.say(
            plain(f"marked  {marking_in_words(tokens_of(self.game.net, self.game.marking)) or 'nothing'}")
        )
        enabled = self.game.enabled
        if not enabled:
            self.say("no transition is enabled")
        for number, transition in enumerate(enabled, 1):
            self.say(plain(f"{number:4}  {arcs_in_words(self.game.net, transition)}"))

    def fire(self, transition: int) -> None:
        """Fires an enabled transition, and says what it changed."""
        before = self.game.marking
        self.game.fire(transition)
        self._tell(before, transition)

    def _tell(self, before: tuple[int, ...], transition: int) -> None:
        changed = [
            f"{place.name} {old} -> {new}"
            for place, old, new in zip(self.game.net.places, before, self.game.marking, strict=True)
            if old != new
        ]
        self.say(plain(f"{self._transitions[transition].name}: {', '.join(changed) or 'nothing changes'}"))

    def command(self, text: str) -> str | None:
        """Carries out a command, or says what is wrong with it."""
        before = self.game.marking
        match text.split():
            case [] | ["state"]:
                pass
            case ["help"]:
                self.say(HELP_WITH_TOKENS)
                return None
            case ["run"]:
                for transition in self.game.run:
                    self.say(plain(f"    {self._transitions[transition].name}"))
                return None
            case ["restart"]:
                self.game.restart()
            case ["back" | "forward" as way]:
                moved = self.game.back() if way == "back" else self.game.forward()
                if moved is None:
                    return f"nothing to go {way} to"
                self._tell(before, moved)
            case ["settle"]:
                try:
                    fired = self.game.settle()
                except (DivergenceError, LimitError) as error:
                    return str(error)
                for transition in fired:
                    self.say(plain(f"    {self._transitions[transition].name}"))
            case _:
                chosen = self.chosen(text)
                if isinstance(chosen, str):
                    return chosen
                self.fire(self.game.enabled[chosen])
        self.show()
        return None
