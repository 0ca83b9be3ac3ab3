"""Generated SCXML on the runs of a bench, in an interpreter by others: python-statemachine's."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from contextlib import redirect_stdout
from typing import Any

from lxml import etree

from mcpn.errors import LimitError
from mcpn.robot.bench.controller_places import ControllerPlace
from mcpn.robot.runtime.actions import Action
from mcpn.robot.targets import files
from mcpn.robot.targets.scxml import Regions, event_name


def interpreted(text: str) -> Any:
    """A processor of python-statemachine that has read a document.

    Args:
        text: The document.

    Raises:
        LimitError: The interpreter is not installed.
    """
    try:
        from statemachine.io.scxml.processor import SCXMLProcessor
    except ImportError as error:
        raise LimitError("--against scxml needs python-statemachine: pip install 'mcpn[scxml]'") from error
    processor: Any = SCXMLProcessor()
    processor.parse_scxml("controller", text)
    return processor


def answer(machine: Any, event: str) -> tuple[list[str], frozenset[str]]:
    """The labels that a machine logs on an event, and its active states that have none inside."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        machine.send(event)
    active = {name for name in machine.configuration_values if "." in name or name in _LEAVES}
    return [line.split(": ")[0] for line in printed.getvalue().splitlines()], frozenset(active)


_LEAVES = frozenset(("before", "success", "failure", "abort"))


class Statechart:
    """The SCXML of a controller; timers run in virtual time, so that its own send nothing.

    It says nothing of events that it ignores: what is logged and where it is are compared.

    Args:
        document: The controller's, which is not modular.

    Raises:
        LimitError: The interpreter is not installed.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        (text,) = files(document, "scxml").values()
        root = etree.fromstring(text.encode())
        for sending in list(root.iter("{*}send", "{*}cancel")):
            parent = sending.getparent()
            assert parent is not None
            parent.remove(sending)
        self._processor = interpreted(etree.tostring(root, encoding="unicode"))
        self._regions = Regions(document)
        self._timers = frozenset(self._regions.timers.values())

    def answers(self, runs: list[list[str]]) -> list[str]:
        """What it logs on the events of some runs, and where it is then, a line for each."""
        found = []
        for run in runs:
            with redirect_stdout(io.StringIO()):
                machine = self._processor.start()
            for event in run:
                labels, active = answer(machine, event_name(event))
                timed = (name for name in active if name.partition(".")[0] not in self._timers)
                found.append(_line(labels, timed))
        return found

    def expected(self, _status: str, actions: Sequence[Action], place: ControllerPlace) -> str:
        """The actions, and the states that are active."""
        active = self._regions.active(place.section, place.outcome, place.gone, place.true)
        return _line(map(str, actions), active)


def _line(labels: Iterable[str], active: Iterable[str]) -> str:
    return f"{'; '.join(labels)} | {' '.join(sorted(active))}"
