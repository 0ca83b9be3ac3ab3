"""Runs properties on drawn missions; what breaks one is shrunk to the smallest mission that does.

>>> from mcpn.drawing.templates import PaperTemplates
>>> broken(PaperTemplates(), profile="dev", properties={"one_safe": one_safe}) is None
True
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from mcpn.drawing.templates import PaperTemplates, TemplateSet
from mcpn.errors import InputError, LimitError
from mcpn.mission.model import Mission
from mcpn.testing import Shape, missions
from mcpn.testing.awkward_names import renamed
from mcpn.testing.data import data_sharing_missions
from mcpn.testing.kit.corpus import MISSIONS, NEEDED_WHOLE
from mcpn.testing.kit.language import as_the_language_says
from mcpn.testing.kit.properties import PROPERTIES, Property, behaves_as, no_dead_transition
from mcpn.testing.kit.properties import one_safe as one_safe
from mcpn.testing.kit.smaller_missions import smaller_missions
from mcpn.testing.kit.subject import MOST_MARKINGS, Subject, Violation
from mcpn.testing.printing import as_xml
from mcpn.testing.shape import UNCONTENDED

MOST_SHRUNK = 200
"""Missions on which properties are asked while hypothesis shrinks one."""

MOST_OF_THE_CORPUS = 50_000
"""Markings that a mission of the corpus may have."""

SMALL = replace(UNCONTENDED, producers=2, alternatives=2, activities=3, sections=4, objectives=2)
"""Missions in which nothing contends, most with less than a thousand markings."""

_LEAST = replace(SMALL, hardware=2, producers=1, activities=2, outputs=1)

SMALL_SHAPES: Mapping[str, Shape] = {
    "plain": SMALL,
    "events": replace(_LEAST, events=1, interrupted=True),
    "facts": replace(_LEAST, facts=2, events=1, guards=3, becoming=3),
    "losses": replace(_LEAST, lasting=True, faults=1, crashes=True),
    "late": replace(_LEAST, hardware=1, late=True),
    "ends": replace(_LEAST, branches=3, aborts=3, early=5, timeouts=4, timed_blocks=2, reasons=3, events=1),
    "pauses": replace(_LEAST, pauses=8, recovers=3, led=3, events=1, rounds=False),
    "contended": replace(_LEAST, own_hardware=False, shared_activities=True, events=1),
}
"""Small missions by what is drawn in them besides: together, every element of the language."""

PROFILES: Mapping[str, settings] = {
    name: settings(
        max_examples=examples,
        derandomize=fixed,
        deadline=None,
        database=None,
        report_multiple_bugs=False,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    for name, examples, fixed in (("dev", 25, False), ("ci", 75, True), ("nightly", 10_000, False))
}
"""How many missions are drawn, and whether always the same ones."""


ALL: Mapping[str, Property] = {
    **PROPERTIES,
    "behaves_as": behaves_as(PaperTemplates(), name="paper"),
    "as_the_language_says": as_the_language_says,
    "no_dead_transition": no_dead_transition,
}
"""The properties that the kit tests."""


def small_missions() -> tuple[st.SearchStrategy[Mission], ...]:
    """Strategies of small missions with every element of the language, those that shrink best first.

    Among them some whose branches share data, and some in which activities contend.
    """
    return (*map(missions, SMALL_SHAPES.values()), data_sharing_missions())


@dataclass(frozen=True)
class BrokenProperty:
    """A property that some templates break.

    Args:
        property: Its name.
        mission: The smallest mission that was found.
        violation: What is wrong with it.
    """

    property: str
    mission: Mission
    violation: Violation

    def __str__(self) -> str:
        return f"{self.property} is broken: {self.violation}\n\non this mission:\n\n{as_xml(self.mission)}"


def broken(
    templates: TemplateSet, *, profile: str = "dev", properties: Mapping[str, Property] = ALL
) -> BrokenProperty | None:
    """Looks for a mission on which some templates break a property.

    Missions are drawn first, for what they show is shrunk; then those of the corpus are tried, one for each
    form of template, the smallest first.

    Args:
        templates: The templates.
        profile: One of :data:`PROFILES`.
        properties: By name; the first that is broken on a mission is told. ``no_dead_transition`` is asked
            of those missions of the corpus that need all of what is drawn.

    Returns:
        The smallest mission found with what is wrong; ``None`` if all properties hold.

    Raises:
        InputError: There is no such profile.
    """
    if profile not in PROFILES:
        raise InputError.at(None, f"found the profile {profile!r}, expected one of: {', '.join(PROFILES)}")
    asked = {name: holds for name, holds in properties.items() if name != "no_dead_transition"}
    strategies = small_missions()
    for strategy in strategies if asked else ():
        chosen = PROFILES[profile]
        share = settings(chosen, max_examples=-(-chosen.max_examples // len(strategies)))
        found = _smallest(strategy, share, templates, asked)
        if found is not None:
            return found
    found = next(of_the_corpus(templates, properties), None)
    return found and without_leftovers(found, templates, properties, MOST_OF_THE_CORPUS)


class _Enough(BaseException):
    """Stops hypothesis, which goes on after each exception of the usual kind."""


def _smallest(
    strategy: st.SearchStrategy[Mission],
    within: settings,
    templates: TemplateSet,
    properties: Mapping[str, Property],
) -> BrokenProperty | None:
    """The smallest mission of a strategy on which a property is broken.

    Hypothesis would shrink for minutes. After :data:`MOST_SHRUNK` missions it is stopped; what it has left
    over :func:`without_leftovers` takes out, in fewer steps.
    """
    last: BrokenProperty | None = None
    shrunk = 0

    @within
    @given(strategy)
    def holds(mission: Mission) -> None:
        nonlocal last, shrunk
        if last is not None:
            if shrunk == MOST_SHRUNK:
                raise _Enough
            shrunk += 1
        found = first_broken(mission, templates, properties)
        if found is not None:
            last = found  # hypothesis tries the smallest one last
            raise found.violation

    try:
        holds()
    except (Violation, _Enough):
        assert last is not None, "it has been noted before it was raised"
        return numbered_anew(without_leftovers(last, templates, properties), templates, properties)
    return None


def without_leftovers(
    found: BrokenProperty,
    templates: TemplateSet,
    properties: Mapping[str, Property],
    most: int = MOST_MARKINGS,
) -> BrokenProperty:
    """The same on a mission without the elements that the violation does not need, as far as one finds."""
    if found.property == "no_dead_transition":
        return found  # asked of missions that need all that is drawn
    for smaller in smaller_missions(found.mission):
        again = first_broken(smaller, templates, properties, most)
        if again is not None and again.property == found.property:
            return without_leftovers(again, templates, properties, most)
    return found


def numbered_anew(
    found: BrokenProperty, templates: TemplateSet, properties: Mapping[str, Property]
) -> BrokenProperty:
    """The same with elements numbered from 0 by kind, where what was left out leaves gaps."""
    given: dict[tuple[str, str], str] = {}
    count: Counter[tuple[str, str]] = Counter()

    def rename(kind: str, name: str) -> str:
        if (kind, name) not in given:
            plain = name.rstrip("0123456789")
            given[kind, name] = f"{plain}{count[kind, plain]}" if plain != name else name
            count[kind, plain] += 1
        return given[kind, name]

    again = first_broken(renamed(found.mission, rename), templates, properties)
    return again if again is not None and again.property == found.property else found


def of_the_corpus(
    templates: TemplateSet, properties: Mapping[str, Property] = ALL
) -> Iterator[BrokenProperty]:
    """What some templates break on the missions of the corpus, the first property on each."""
    asked = {name: holds for name, holds in properties.items() if name != "no_dead_transition"}
    for name, mission in MISSIONS.items():
        found = first_broken(mission, templates, asked, MOST_OF_THE_CORPUS)
        if found is None and name in NEEDED_WHOLE and "no_dead_transition" in properties:
            found = first_broken(mission, templates, {"no_dead_transition": no_dead_transition})
        if found is not None:
            yield found


def first_broken(
    mission: Mission,
    templates: TemplateSet,
    properties: Mapping[str, Property] = PROPERTIES,
    most: int = MOST_MARKINGS,
) -> BrokenProperty | None:
    """The first property that some templates break on one mission; missions that are too large pass."""
    try:
        subject = (
            Subject(mission, templates) if most is None else Subject(mission, templates, max_states=most)
        )
    except LimitError:
        return None  # an element is too wide for its template
    except InputError as error:
        return BrokenProperty("composes", mission, Violation(f"the templates do not fit together: {error}"))
    for name, holds in properties.items():
        try:
            holds(subject)
        except Violation as violation:
            return BrokenProperty(name, mission, violation)
        except LimitError:
            return None
    return None
