"""The controller of a mission in a form that is asked for, refused or told where it is too large."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Literal, Unpack, overload

from mcpn.answers.spaces_by_engine import MissionSubject, spaces_of
from mcpn.composite.clash_sentences import in_mission_words
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.section_type import SectionType
from mcpn.controller.document import document
from mcpn.controller.hierarchy import TableController, flat_controller, hierarchical_controller
from mcpn.controller.modular import AnyController, ModularController
from mcpn.controller.rules import modular_controller
from mcpn.controller.sizes import (
    MAX_TABLE_STATES,
    has_rules,
    rather_rules,
    representatives,
    rules_instead,
    table_edges,
    too_large,
)
from mcpn.errors import LimitError
from mcpn.spaces.engine_names import Limited
from mcpn.spaces.stable.run_to_completion import MAX_STABLE_STATES

Form = Literal["flat", "hierarchical", "modular"]

BYTES_OF_EDGE = 150
"""Which an edge takes in a file, at least: two states, its event, some actions."""

MOST_BYTES = 100_000_000
"""Of a file of tables, where the user does not say how many states a machine may have."""

MOST_UNTOLD = 10_000
"""States of a section up to which it is listed without a call of ``told``."""


@overload
def generate(
    subject: MissionSubject,
    form: Literal["flat", "hierarchical"] = "hierarchical",
    *,
    told: Callable[[str], object] | None = None,
    **within: Unpack[Limited],
) -> TableController: ...
@overload
def generate(
    subject: MissionSubject,
    form: Literal["modular"],
    *,
    told: Callable[[str], object] | None = None,
    **within: Unpack[Limited],
) -> ModularController: ...
@overload
def generate(
    subject: MissionSubject,
    form: Form | Literal["auto"],
    *,
    told: Callable[[str], object] | None = None,
    **within: Unpack[Limited],
) -> AnyController: ...
def generate(
    subject: MissionSubject,
    form: Form | Literal["auto"] = "hierarchical",
    *,
    told: Callable[[str], object] | None = None,
    **within: Unpack[Limited],
) -> AnyController:
    """Generates the controller of a mission.

    Args:
        subject: The mission's spaces, or its net.
        form: Hierarchical, whose size is the sum of the sizes of types of sections; modular, of rules; flat;
            or ``auto``: hierarchical unless a section has many states, then modular.
        told: Called with the sizes, in words, before large sections are listed, and where ``auto`` takes
            the modular form.
        **within: How many states a machine may have.

    Raises:
        SemanticsError: The mission is not safe or not confluent, or a section hands on more than hardware.
        LimitError: A machine would have more states than allowed; the message says how many.

    See Also:
        :func:`mcpn.controller.minimise.minimise`: fewer states that do the same.
        :mod:`mcpn.robot.targets`: the files that robots read.
    """
    spaces = spaces_of(subject, **within)
    mission_net, max_states = spaces.mission, spaces.max_states
    if form == "flat":
        faulty = sum(h.faulty for h in mission_net.core.hardware)
        limit = MAX_STABLE_STATES if max_states is None else max_states
        if 1 << faulty > limit:
            raise LimitError(
                f"{faulty} hardware resources that may fail have 2^{faulty} states and a flat controller has "
                f"more, the limit is {limit}: the hierarchical one needs no such product"
            )
        with in_mission_words(mission_net):
            return flat_controller(mission_net, spaces.bound(max_states=limit).listed())
    with in_mission_words(mission_net):
        composite = spaces.composite()
    if form == "modular":
        return modular_controller(composite)
    name_of_type = representatives(composite)
    if form == "auto" and (error := rather_rules(name_of_type, max_states)):
        if told:
            told(f"{error}: a modular controller is made instead")
        return modular_controller(composite)
    refuse_or_tell(composite, max_states, told)
    listed = {type_: type_.listed() for type_ in name_of_type}
    return hierarchical_controller(composite, listed)


def refuse_or_tell(
    composite: CompositeSpace, max_states: int | None, told: Callable[[str], object] | None
) -> None:
    """Refuses a hierarchical controller that is too large, or says how large it will be, before it is listed.

    Args:
        composite: The mission's composite.
        max_states: How many states a machine may have; where given, its file may have any size.
        told: Called with what there is to say of a large one.

    Raises:
        LimitError: It is too large; the message says what the modular form takes, or that it lists nothing.
    """
    names = representatives(composite)
    if error := too_large(names, MAX_TABLE_STATES if max_states is None else max_states):
        raise LimitError(f"{error}{'; --form modular lists none' if has_rules(names) else ''}")
    largest = max(names, key=lambda type_: type_.size)
    if largest.size <= MOST_UNTOLD:
        return
    edges = sum(map(table_edges, names))
    said = (
        f"{len(names)} machines of sections list {sum(type_.size for type_ in names):,} states, the largest, "
        f"of section {names[largest]}, {largest.size:,}, and {edges:,} edges, in a file of more than "
        f"{edges * BYTES_OF_EDGE / 1e6:,.1f} MB"
    )
    if max_states is None and edges * BYTES_OF_EDGE > MOST_BYTES:
        raise LimitError(
            f"{said}; the limit is {MOST_BYTES / 1e6:,.0f} MB, and --max-states {largest.size} goes on all "
            f"the same{_modular_instead(composite, names)}"
        )
    if told is not None:
        told(f"{said}{rules_instead(names)}")


def _modular_instead(composite: CompositeSpace, names: Mapping[SectionType, str]) -> str:
    """How large the modular form is, where there is one: it is made to see."""
    if not has_rules(names):
        return ""
    text = json.dumps(document(modular_controller(composite), composite.mission_net))
    return f"; --form modular takes {len(text) / 1e3:,.0f} kB"
