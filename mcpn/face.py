"""What a Python user types first: the functions that ``mcpn`` itself offers.

Each takes a mission, or its net where one has been composed already, and builds what it needs. Who asks
several questions of one mission opens a study, which keeps what was built: :class:`mcpn.study.Study`.

>>> import mcpn
>>> mission = mcpn.read_mission("experiments/ulysse/mission.xml")
>>> mcpn.states(mission).states
44299
>>> answer = mcpn.ctl(mission, "EF (failure & oos(GPS_sensor))", engine="local")
>>> answer.holds
True
>>> [str(event) for event in answer.witness.run.events][0]
'MISSION_EV_START'
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission as _read
from mcpn.net.petri import PetriNet
from mcpn.study import Study

if TYPE_CHECKING:
    from mcpn.check.causes.find import Causes
    from mcpn.check.engines import Asked, On
    from mcpn.check.logic.questions import Answer
    from mcpn.check.sizes import Counting
    from mcpn.net.compose import MissionNet
    from mcpn.report.pictures.drawing import Drawing
    from mcpn.space.markings.graph import StateGraph
    from mcpn.space.summary import SpaceSummary


def read_mission(path: str | Path) -> Mission:
    """Reads a mission file, with what it imports.

    Args:
        path: The file.

    Raises:
        InputError: The file is no valid mission, with every problem and its line.

    Examples:
        >>> mission = read_mission("experiments/ulysse/mission.xml")
        >>> mission.name, [block.name for block in mission.blocks]
        ('ulysse', ['coral_head', 'transect'])
    """
    return _read(Path(path))


def states(
    of: Mission | MissionNet | PetriNet, *, engine: Counting = "auto", on: On | None = None
) -> SpaceSummary:
    """Counts the reachable states of a mission or of a net, exactly.

    Args:
        of: The mission or the net.
        engine: ``symbolic``, ``explicit``, ``local`` or ``pyeda``; ``auto``: the first of them that answers.
        on: ``markings`` for all markings, ``alternatives`` for the stable states of a mission alone. By
            default all markings of a net and of a small mission, and the stable states of a larger one.

    Raises:
        SemanticsError: The net is not 1-safe, or of stable states, internal evolution is not confluent.
        LimitError: A limit was hit.

    Examples:
        >>> found = states(read_mission("experiments/ulysse/mission.xml"), engine="explicit")
        >>> found.states, found.stable_states
        (44299, 260)
    """
    return Study(of).states(engine=engine, on=on)


def graph(
    of: Mission | MissionNet | PetriNet | Study,
    on: On = "alternatives",
    *,
    max_states: int | None = None,
) -> StateGraph:
    """Lists the states of a mission or a net one by one, with the edges between them.

    Args:
        of: The mission, the net, or a study of one.
        on: ``alternatives`` for stable states and events, of a mission; ``markings`` for all markings.
        max_states: The most states that it may have.

    Returns:
        The graph in arrays; :meth:`mcpn.space.markings.graph.StateGraph.to_networkx` makes one of networkx.

    Raises:
        SemanticsError: The net is not 1-safe, or of stable states, internal evolution is not confluent.
        LimitError: There are more states than allowed.

    Examples:
        >>> import networkx
        >>> stable = graph(read_mission("experiments/ulysse/mission.xml")).to_networkx()
        >>> stable.number_of_nodes(), stable.number_of_edges()
        (260, 1332)
        >>> ends = [state for state, marked in stable.nodes(data="marking") if "MISSION_success" in marked]
        >>> len(ends), networkx.has_path(stable, 0, ends[0])
        (8, True)
    """
    from mcpn.check.engines import Choice
    from mcpn.space.arrays import ArraySpace
    from mcpn.space.stable.listing import written_out

    study = of if isinstance(of, Study) else Study(of)
    if on == "markings":
        space = study.spaces.space(Choice("explicit", max_states=max_states), "markings")
    else:
        space = study.alternatives(max_states=max_states)
    return space.graph if isinstance(space, ArraySpace) else written_out(space, "listed", max_states)


def ctl(
    of: Mission | MissionNet | PetriNet,
    formula: str,
    *,
    on: On | None = None,
    fair: tuple[str, ...] = (),
    engine: Asked = "auto",
) -> Answer:
    """Answers a formula of temporal logic, with a run that shows why.

    Args:
        of: The mission or the net.
        formula: As :mod:`mcpn.check.logic.syntax` describes it.
        on: Whether it speaks of all ``markings``, or of ``alternatives``: stable states and events. By
            default the latter of a mission, the former of a net.
        fair: ``progress``, or formulas that hold again and again on the paths that count.
        engine: ``explicit``, ``symbolic``, or ``local`` for the alternatives graph of a mission; ``auto``:
            the first of them that answers.

    Raises:
        InputError: The formula is none, or does not fit the net.
        SemanticsError: The net is not 1-safe, or internal evolution is not confluent.
        LimitError: A limit was hit.

    Examples:
        >>> mission = read_mission("experiments/ulysse/mission.xml")
        >>> ctl(mission, "AF (success | failure)").holds  # a sensor may fail and recover for ever
        False
        >>> ctl(mission, "AF (success | failure)", fair=("progress",)).holds
        True
    """
    return Study(of).ctl(formula, on=on, fair=fair, engine=engine)


def picture(
    of: Mission | MissionNet | PetriNet, kind: str = "mission", section: str | None = None
) -> Drawing:
    """Draws a mission or a net; a notebook shows the picture, and ``save`` writes it as SVG or PNG.

    Args:
        of: The mission, or a net.
        kind: What is drawn of a mission: ``mission``, ``objectives``, ``net``, ``alternatives`` or
            ``controller``.
        section: Draw this section alone: its net, its local graph or its controller.

    Raises:
        InputError: There is no such section, or there is no such picture of a section.
        LimitError: The picture is too large to be read, or the extra ``pictures`` is missing.

    Examples:
        >>> drawing = picture(read_mission("experiments/ulysse/mission.xml"))
        >>> "going_up" in drawing.svg
        True
    """
    return Study(of).picture(None if isinstance(of, PetriNet) else kind, section)


def causes(of: Mission | MissionNet, *, engine: Asked = "auto") -> Causes:
    """Finds what makes a mission and its objectives fail: critical events and minimal cut sets.

    Args:
        of: The mission.
        engine: ``explicit``, ``symbolic`` or ``local``; ``auto``: the first of them that answers.

    Raises:
        SemanticsError: The mission is not safe or not confluent.
        LimitError: A limit was hit.

    Examples:
        >>> found = causes(read_mission("experiments/ulysse/mission.xml"))
        >>> [sorted(cut) for cut in found.mission.cut_sets]
        [['thruster_actuator'], ['GPS_sensor', 'IMU_sensor']]
    """
    return Study(of).causes(engine=engine)
