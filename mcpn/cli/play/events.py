"""A mission played at a prompt, or from a file of events."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcpn.errors import InputError, LimitError, Source
from mcpn.events import Event, What
from mcpn.robot.runtime.actions import spelled

if TYPE_CHECKING:
    from mcpn.controller.simulator import Change, Simulation
from mcpn.cli.play.event_files import events_of_file
from mcpn.cli.play.prompt import Prompt

HELP = """\
an event's number, its name, or the beginning of its name: it happens
undo                 take back the last event
restart              go back to the beginning
goto success         take the events of a shortest run to the mission's success
goto failure         the same to its failure
goto abort           the same to its abort
goto cut set         let fail the fewest hardware that rules out success
goto cut set A B     let fail these
run                  the events taken so far
state                what runs and what may happen
help, quit"""


class EventSession(Prompt):
    """A mission that is played, and what is printed of it.

    Args:
        simulation: The mission.
        quiet: Whether nothing is printed but errors.
    """

    what = "an event"
    words = (
        "undo",
        "restart",
        "goto success",
        "goto failure",
        "goto abort",
        "goto cut set",
        "run",
        "state",
        "help",
        "quit",
    )

    def __init__(self, simulation: Simulation, quiet: bool) -> None:
        super().__init__(quiet)
        self.simulation = simulation
        self.taken: list[Change] = []

    def possible(self) -> list[str]:
        """Names of the events that may happen now."""
        return [str(event) for event in self.simulation.possible]

    def show(self) -> None:
        """Prints what runs, and what may happen."""
        from mcpn.report.simulation import state_lines

        for line in state_lines(self.simulation):
            self.say(line)

    def take(self, event: Event) -> bool:
        """Takes an event and says what it changes; whether it was possible."""
        from mcpn.report.simulation import change_lines

        change = self.simulation.take(event)
        if change is None:
            return False
        self.taken.append(change)
        for line in change_lines(change, self.simulation.mission_net):
            self.say(line)
        return True

    def play_nominal(self) -> None:
        """Takes the run on which nothing fails, and says where it does not succeed."""
        from mcpn.robot.bench.nominal_run import nominal_run

        simulation = self.simulation

        def take(event: Event) -> int:
            self.take(event)
            return simulation.marking

        hardware = simulation.mission_net.core.hardware
        back = frozenset(h.name for h in hardware if h.initial == "oos" and h.repairable)
        nominal_run(lambda: simulation.possible, take, back)
        if simulation.situation.outcome is None:
            self.say("the run without failures goes on for ever, or nothing can succeed here: see mcpn check")

    def replay(self, path: Path) -> None:
        """Takes the events of a file.

        Raises:
            InputError: A line holds no event, one that is not possible there, or one that was refused by a
                controller and is possible.
        """
        known = set(map(str, self.simulation.mission_net.net.events))
        for line, said, refused in events_of_file(path):
            event = None if said is None else Event.parse(spelled(str(said), known))
            if event is None:
                self.simulation.restart()
                self.taken.clear()
            elif refused:
                if event in self.simulation.possible:
                    message = f"found {event} refused by the controller, which is possible here"
                    raise InputError.at(Source(str(path), line), message)
            elif not self.take(event):
                possible = ", ".join(map(str, self.simulation.possible)) or "none"
                message = f"found {event}, which is not possible here; expected one of: {possible}"
                raise InputError.at(Source(str(path), line), message)

    def command(self, text: str) -> str | None:
        """Carries out a command, or says what is wrong with it."""
        words = text.split()
        match words:
            case [] | ["state"]:
                self.show()
            case ["help"]:
                self.say(HELP)
            case ["undo"]:
                return self.undo()
            case ["restart"]:
                self.simulation.restart()
                self.taken.clear()
                self.show()
            case ["run"]:
                for event in self.simulation.run:
                    self.say(f"    {event}")
            case ["goto", ("success" | "failure" | "abort") as outcome]:
                return self.goto(outcome)
            case ["goto", "cut", "set", *hardware]:
                return self.fail(hardware)
            case ["goto", *_]:
                return "found another goto, expected success, failure, abort or cut set"
            case [word]:
                return self.one_event(word)
            case _:
                return f"found {text[:80]!r}, expected an event or a command (help shows them)"
        return None

    def undo(self) -> str | None:
        """Takes back the last event."""
        event = self.simulation.undo()
        if event is None:
            return "nothing to undo"
        self.taken.pop()
        self.say(f"taken back: {event}")
        self.show()
        return None

    def one_event(self, word: str) -> str | None:
        """Takes an event by number or name, or says what is wrong."""
        chosen = self.chosen(word)
        if isinstance(chosen, str):
            return chosen
        self.take(self.simulation.possible[chosen])
        self.show()
        return None

    def goto(self, outcome: str) -> str | None:
        """Takes the events of a shortest run to an end of the mission."""
        if self.simulation.situation.outcome:
            return "the mission has ended; undo or restart first"
        try:
            way = self.simulation.way_to(outcome)
        except LimitError as error:
            return str(error)
        if way is None:
            return f"no run leads to {outcome} from here"
        self.take_all(way)
        return None

    def fail(self, hardware: list[str]) -> str | None:
        """Lets hardware fail: what is named, or a smallest cut set."""
        from mcpn.events import Event

        if self.simulation.situation.outcome:
            return "the mission has ended; undo or restart first"
        working = [e.element for e in self.simulation.possible if e.what is What.OUT_OF_SERVICE]
        chosen: tuple[str, ...] | None = tuple(dict.fromkeys(hardware))
        if not hardware:
            try:
                chosen = self.simulation.cut_set()
            except LimitError as error:
                return str(error)
        if chosen is None:
            return "no small set of hardware resources rules out success from here"
        if not chosen:
            return "success is ruled out already unless something is repaired"
        for name in chosen:
            if name not in working:
                return f"found {name[:80]!r}, expected hardware in service: {', '.join(working) or 'none'}"
        self.take_all([Event(What.OUT_OF_SERVICE, name) for name in chosen])
        return None

    def take_all(self, events: list[Event]) -> None:
        """Takes events one after the other, and says each."""
        for event in events:
            self.say(f"> {event}")
            self.take(event)
        self.show()
