"""One mission or net with the spaces that were built of it: what commands, notebooks and scripts ask.

>>> import mcpn
>>> study = mcpn.open("experiments/ulysse/mission.xml")
>>> study.check().passed
True
>>> study.ctl("AF (success | failure)").holds  # a sensor may fail and recover for ever
False
>>> study.ctl("AF (success | failure)", fair=["progress"]).holds
True
>>> [sorted(cut) for cut in study.causes().mission.cut_sets]
[['thruster_actuator'], ['GPS_sensor', 'IMU_sensor']]

Each space is built once (:mod:`mcpn.spaces.registry`): these questions share a list of stable states.

:func:`open_study`, which users call as ``mcpn.open``, makes a study of a file.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, Unpack

from mcpn.errors import InputError, Source
from mcpn.nets.petri import PetriNet
from mcpn.spaces.engine_names import EXPLICIT

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from mcpn.answers.causes.find import Causes
    from mcpn.answers.safety import SafetyAnswer
    from mcpn.answers.spaces_by_engine import MissionSpaces
    from mcpn.answers.state_sets import FoundStates
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.controller.generate import Form
    from mcpn.controller.modular import AnyController
    from mcpn.drawing.compose import MissionNet
    from mcpn.drawing.templates import TemplateSet
    from mcpn.findings import Findings
    from mcpn.logic.behaviour import NetCheck
    from mcpn.logic.questions import Questions
    from mcpn.logic.session import Answer
    from mcpn.logic.structure import Structure
    from mcpn.mission.model import Mission
    from mcpn.report.pictures.drawing import Drawing
    from mcpn.spaces.algebra import Space
    from mcpn.spaces.engine_names import Asking, Counting, Limited, On
    from mcpn.spaces.engines import Choice
    from mcpn.spaces.markings.graph import StateGraph
    from mcpn.spaces.registry import Spaces
    from mcpn.spaces.summary import SpaceSummary
    from mcpn.trees.ledger import Ledger
    from mcpn.trees.options import TreeOptions


# Methods import the modules that they need, so that each question loads no more than it needs.


class Study:
    """A mission, or a net, with its spaces: each is built when a question first needs it, and then kept.

    Engines are ``explicit``, ``symbolic`` and ``local``; ``auto`` is the first of them that answers. A limit
    ``max_states`` is on states that are listed one by one. What is asked of missions alone is an
    :class:`mcpn.errors.InputError` for a net.

    Args:
        subject: The mission, its net where it has been composed already, or a net of no mission.
        templates: The templates to compose with, or that the net was composed with; the paper's by default.
        file: Where it has been read from; errors say so. An attribute, too.
        ledger: What each node became of the behaviour tree that the mission was read from; ``None`` of what
            was read from no tree. An attribute, too.

    Examples:
        >>> from mcpn.mission.xml import read_mission
        >>> study = Study(read_mission(Path("experiments/ulysse/mission.xml")))
        >>> study.check(engine="local").passed, study.controller().sections[0].name
        (True, 'coral_head.manual_moving')
    """

    def __init__(
        self,
        subject: Mission | MissionNet | PetriNet,
        *,
        templates: TemplateSet | None = None,
        file: Path | None = None,
        ledger: Ledger | None = None,
    ) -> None:
        self._subject = subject
        self._templates = templates
        self.file = file
        self.ledger = ledger
        self._asked: Asking = {}
        self._questions: dict[object, Questions] = {}

    def bound(self, **asked: Unpack[Asking]) -> Self:
        """The same study, whose questions are asked of an engine, or within a limit, unless they say another.

        Examples:
            >>> import mcpn
            >>> study = mcpn.open("experiments/ulysse/mission.xml").bound(engine="local")
            >>> study.check().choice.engine, study.causes().choice.engine
            ('local', 'local')
        """
        other = copy.copy(self)
        other._asked = {**self._asked, **asked}
        vars(other).pop("spaces", None)
        return other

    def __repr__(self) -> str:
        subject = self._subject
        what = "net" if isinstance(subject, PetriNet) else "mission"
        return (
            f"<study of the {what} {subject.mission.name if hasattr(subject, 'mission') else subject.name}>"
        )

    @property
    def is_net(self) -> bool:
        """Whether it is a net of no mission."""
        return isinstance(self._subject, PetriNet)

    @property
    def mission(self) -> Mission:
        """The mission as its author wrote it.

        Raises:
            InputError: It is a net of no mission.
        """
        from mcpn.mission.model import Mission

        if isinstance(self._subject, Mission):
            return self._subject
        return self.mission_net.mission

    @cached_property
    def spaces(self) -> Spaces:
        """Its spaces, built or not, bound to who is asked."""
        return self._spaces.bound(**self._asked)

    @cached_property
    def _spaces(self) -> Spaces:
        """The same, bound to nobody; here the net of a mission is composed."""
        if isinstance(self._subject, PetriNet):
            from mcpn.spaces.registry import Spaces

            return Spaces(self._subject)
        from mcpn.answers.spaces_by_engine import MissionSpaces
        from mcpn.drawing.compose import MissionNet, compose

        mission_net = (
            self._subject
            if isinstance(self._subject, MissionNet)
            else compose(self._subject, self._templates)
        )
        return MissionSpaces(mission_net, templates=self._templates)

    @property
    def net(self) -> PetriNet:
        """The net, or that of the mission."""
        return self.spaces.net

    @property
    def mission_net(self) -> MissionNet:
        """The mission's net, with what its places mean.

        Raises:
            InputError: It is a net of no mission.
        """
        return self.mission_spaces().mission

    def mission_spaces(self, question: str = "this") -> MissionSpaces:
        """The spaces of the mission, for a question that is asked of missions alone.

        Raises:
            InputError: It is a net of no mission; the error says which question was asked.
        """
        if self.is_net:
            source = None if self.file is None else Source(str(self.file))
            raise InputError.at(source, f"found a net, expected a mission: {question} is asked of missions")
        from mcpn.answers.spaces_by_engine import spaces_of

        return spaces_of(self.spaces)

    def check(
        self,
        **asked: Unpack[Asking],
    ) -> MissionCheck | NetCheck:
        """Decides the verdicts of a mission, or the behaviour of a net.

        Args:
            **asked: Who answers for a mission, and within what limit; a net is reached as a diagram.

        Raises:
            LimitError: A limit was hit.

        Examples:
            >>> from mcpn.testing.nets import philosophers
            >>> found = Study(philosophers(2)).check()
            >>> found.safe, found.deadlock_free, found.reversible
            (True, False, False)
        """
        if self.is_net:
            return self.bound(**asked).behaviour()
        return self.verdicts(**asked)

    def verdicts(
        self,
        **asked: Unpack[Asking],
    ) -> MissionCheck:
        """What :meth:`check` gives of a mission: verdicts with their runs, sizes, functioning modes."""
        from mcpn.answers.verdicts.mission import check

        return check(self.mission_spaces("whether a mission can succeed"), **asked)

    def behaviour(self, **within: Unpack[Limited]) -> NetCheck:
        """What :meth:`check` gives of a net: bounds, deadlocks, liveness; of a mission, those of its net.

        Examples:
            >>> from mcpn.testing.nets import philosophers
            >>> Study(philosophers(2)).behaviour().deadlock
            ('wake0', 'left0', 'wake1', 'left1')
        """
        from mcpn.logic.behaviour import check_net

        return check_net(self.spaces.bound(**within))

    def structure(self) -> Structure:
        """What the arcs of the net prove without its markings.

        Examples:
            >>> from mcpn.testing.nets import token_ring
            >>> len(Study(token_ring(3)).structure().p_semiflows)
            1
        """
        from mcpn.logic.structure import Structure

        return Structure(self.net)

    def states(
        self, *, engine: Counting | None = None, on: On | None = None, **within: Unpack[Limited]
    ) -> SpaceSummary:
        """Counts the reachable states, exactly.

        Args:
            engine: ``symbolic``, ``explicit``, ``local`` or ``pyeda``; ``auto``, the default: the first that
                answers.
            on: ``markings`` for all markings, ``alternatives`` for the stable states of a mission alone. By
                default all markings of a net and of a small mission, and the stable states of a larger one.
            **within: Limit on states that are listed.

        Raises:
            SemanticsError: The net is not 1-safe, or of stable states, internal evolution is not confluent.
            LimitError: A limit was hit.

        Examples:
            >>> from mcpn.testing.nets import kanban
            >>> Study(kanban(2)).states().states
            4600
        """
        return self.sizes(engine=engine, on=on, **within)[0]

    def sizes(
        self,
        *,
        engine: Counting | None = None,
        on: On | None = None,
        **within: Unpack[Limited],
    ) -> tuple[SpaceSummary, Choice | None]:
        """The sizes of the states, and the engine that was chosen; see :func:`mcpn.spaces.sizes.sizes`."""
        from mcpn.spaces.sizes import sizes

        return sizes(self.spaces, engine=engine, on=on, **within)

    def questions(
        self,
        *,
        on: On | None = None,
        fair: Sequence[str] = (),
        **asked: Unpack[Asking],
    ) -> Questions:
        """What answers formulas; those that are asked alike share what has been found out.

        Examples:
            >>> from mcpn.testing.nets import philosophers
            >>> questions = Study(philosophers(2)).questions()
            >>> questions.answer("EF deadlock").holds
            True
        """
        from mcpn.logic.questions import Questions

        spaces = self.spaces.bound(**asked)
        key = on, tuple(fair), spaces.engine, spaces.max_states
        if key not in self._questions:
            self._questions[key] = Questions(spaces, on=on, fair=fair)
        return self._questions[key]

    def ctl(
        self,
        formula: str,
        *,
        on: On | None = None,
        fair: Sequence[str] = (),
        **asked: Unpack[Asking],
    ) -> Answer:
        """Answers a formula of temporal logic, with a run that shows why.

        Args:
            formula: As :mod:`mcpn.logic.syntax` describes it.
            on: Whether it speaks of all ``markings``, or of ``alternatives``: stable states and events. By
                default the latter of a mission, the former of a net.
            fair: ``progress``, or formulas that hold again and again on the paths that count.
            **asked: Who answers, and within what limit.

        Raises:
            InputError: The formula is none, or does not fit the net.
            SemanticsError: The net is not 1-safe, or internal evolution is not confluent.
            LimitError: A limit was hit.

        Examples:
            >>> from mcpn.testing.nets import philosophers
            >>> study = Study(philosophers(2))
            >>> study.ctl("EF deadlock").holds, study.ctl("AG EF think1").holds
            (True, False)
        """
        return self.questions(on=on, fair=fair, **asked).answer(formula)

    def satisfying(
        self,
        formula: str = "true",
        *,
        on: On | None = None,
        fair: Sequence[str] = (),
        **asked: Unpack[Asking],
    ) -> FoundStates:
        """The states that satisfy a formula, to be counted, sampled, walked, or handed to other libraries.

        Args:
            formula: As of :meth:`ctl`; by default all states.
            on: As of :meth:`ctl`.
            fair: As of :meth:`ctl`.
            **asked: Who holds the states, and within what limit.

        Raises:
            InputError: The formula is none, or does not fit the net.
            SemanticsError: The net is not 1-safe, or internal evolution is not confluent.
            LimitError: A limit was hit.

        Examples:
            >>> import mcpn
            >>> study = mcpn.open("experiments/ulysse/mission.xml")
            >>> able = study.satisfying("EF success", engine="symbolic")
            >>> able.count, able.sample(1, seed=3)[0].out_of_service
            (244, ('GPS_sensor',))
        """
        from mcpn.answers.state_sets import FoundStates

        questions = self.questions(on=on, fair=fair, **asked)
        states = questions.evaluation.states(questions.formula(formula))
        mission_net = None if self.is_net else self.mission_net
        return FoundStates(formula, questions.space, states, questions.choice.engine, mission_net)

    def causes(
        self,
        **asked: Unpack[Asking],
    ) -> Causes:
        """Finds what makes the mission and its objectives fail: critical events and minimal cut sets.

        Raises:
            SemanticsError: The mission is not safe or not confluent.
            LimitError: A limit was hit.

        Examples:
            >>> from mcpn.mission.model import Objective
            >>> from mcpn.testing.by_hand import activity, hw, mission, robot
            >>> film = activity("film", ("camera",), ("sonar",))
            >>> see = Objective(name="see", activities=("film",))
            >>> small = mission(robot(hw("camera", "sonar"), film), see)
            >>> Study(small).causes().mission.cut_sets
            [('camera', 'sonar')]
        """
        from mcpn.answers.causes.find import find_causes

        return find_causes(self.mission_spaces("what makes it fail"), **asked)

    def robot_safety(
        self,
        *,
        dangerous: Sequence[str] = (),
        stops: Sequence[str] = (),
        **asked: Unpack[Asking],
    ) -> list[SafetyAnswer]:
        """Asks the questions of a safety engineer; see :func:`mcpn.answers.safety.robot_safety`."""
        from mcpn.answers.safety import robot_safety

        spaces = self.mission_spaces("whether the robot is safe")
        return robot_safety(spaces, dangerous=dangerous, stops=stops, **asked)

    def alternatives(self, **asked: Unpack[Asking]) -> Space[Any]:
        """The alternatives graph of the mission: its stable states, and an edge for each event.

        Raises:
            SemanticsError: The mission is not safe or not confluent.
            LimitError: A limit was hit.
        """
        from mcpn.spaces.engines import answered

        spaces = self.mission_spaces("the alternatives graph").bound(**asked)

        def ask(choice: Choice) -> Space[Any]:
            return spaces.space(choice, "alternatives")

        return answered(ask, spaces.choices("alternatives"))[0]

    def graph(self, on: On = "alternatives", **within: Unpack[Limited]) -> StateGraph:
        """Lists the states one by one, with the edges between them.

        Args:
            on: ``alternatives`` for stable states and events, of a mission; ``markings`` for all markings.
            **within: The most states that it may have.

        Returns:
            The graph in arrays, which goes to networkx; of a mission with what each state says of it.

        Raises:
            InputError: There is no such graph.
            SemanticsError: The net is not 1-safe, or of stable states, internal evolution is not confluent.
            LimitError: There are more states than allowed.

        Examples:
            >>> import mcpn
            >>> stable = mcpn.open("experiments/ulysse/mission.xml").graph().to_networkx()
            >>> stable.number_of_nodes(), stable.number_of_edges()
            (260, 1332)
            >>> stable.nodes[0]["out_of_service"], stable.nodes[0]["mode"]
            ((), {})
        """
        from mcpn.spaces.arrays import ArraySpace
        from mcpn.spaces.engines import Choice, refuse_unknown
        from mcpn.spaces.stable.written_out import written_out

        refuse_unknown(on=on)
        max_states = self.spaces.bound(**within).max_states
        if on == "markings":
            space = self.spaces.space(Choice(EXPLICIT, max_states=max_states), "markings")
        else:
            space = self.alternatives(**within)
        graph = space.graph if isinstance(space, ArraySpace) else written_out(space, "listed", max_states)
        if self.is_net:
            return graph
        from mcpn.answers.verdicts.modes import in_fields, situation

        mission_net = self.mission_net
        return replace(graph, told=lambda marking: in_fields(situation(mission_net, marking)))

    def controller(
        self,
        form: Form | Literal["auto"] = "hierarchical",
        *,
        told: Callable[[str], object] | None = None,
        **within: Unpack[Limited],
    ) -> AnyController:
        """Generates the controller of the mission; see :func:`mcpn.controller.generate.generate`.

        Raises:
            SemanticsError: The mission is not safe or not confluent.
            LimitError: A machine would have more states than allowed.
        """
        from mcpn.controller.generate import generate

        return generate(self.mission_spaces("a controller"), form, told=told, **within)

    def picture(self, kind: str | None = None, section: str | None = None) -> Drawing:
        """Draws the mission or the net; a notebook shows the picture, and ``save`` writes it as SVG or PNG.

        Args:
            kind: What is drawn of a mission: ``mission`` (as it is written, the default), ``objectives``,
                ``net``, ``alternatives`` (that of a section by default), ``controller``, or ``run`` (a
                counterexample); of a net ``net``.
            section: Draw this section alone.

        Raises:
            InputError: There is no such section, or there is no such picture.
            LimitError: The picture is too large to be read, or the extra ``pictures`` is missing.
        """
        from mcpn.report.pictures.choice import drawn
        from mcpn.report.pictures.nets import net_drawing

        if self.is_net and kind in (None, "net") and section is None:
            return net_drawing(self.net)
        kind = kind or ("mission" if section is None else "alternatives")
        return drawn(self.mission_spaces("this picture"), kind, section)

    def findings(self, **asked: Unpack[Asking]) -> Findings:
        """What a report says of the mission; see :func:`mcpn.findings.findings`."""
        from mcpn.findings import findings

        return findings(self.mission_spaces("a report"), **asked)

    def report(self, path: str | Path) -> None:
        """Writes a report of the mission as one HTML page, as ``mcpn report`` does.

        Args:
            path: The page.

        Raises:
            SemanticsError: A section hands on more than the state of its hardware.
            LimitError: A limit was hit.
        """
        from mcpn.files import write_atomically
        from mcpn.report.page import page

        write_atomically(Path(path), page(self.findings()))


def open_study(
    subject: str | Path | Mission | MissionNet | PetriNet,
    *,
    import_root: str | Path | None = None,
    templates: TemplateSet | None = None,
    **tree: Unpack[TreeOptions],
) -> Study:
    """Opens a mission or a net to ask questions about it; ``mcpn.open`` is its name for users.

    Args:
        subject: The file of a mission, of a behaviour tree or of a net (``.net``, ``.pnml``, ``.json``), a
            folder of behaviour trees, or what is read already.
        import_root: The directory that imports must stay in; by default that of the file.
        templates: What draws the net of a mission; the paper's by default.
        tree: How a behaviour tree is read: ``library=["nav2=1.5"]``, ``main``, ``nodes``, ``faulty_leaves``.

    Raises:
        InputError: No valid mission, or no net, with every problem and its line; or templates for a net, or
            options of trees for what is none.

    Examples:
        >>> study = open_study("experiments/ulysse/mission.xml")
        >>> study
        <study of the mission ulysse>
        >>> study.states().states, study.check().stable_sizes
        (44299, (260, 1332))
    """
    file = Path(subject) if isinstance(subject, (str, Path)) else None
    root = None if import_root is None else Path(import_root)
    found, ledger = _read(Path(subject), root, tree) if isinstance(subject, (str, Path)) else (subject, None)
    source = None if file is None else Source(str(file))
    if isinstance(found, PetriNet) and templates is not None:
        raise InputError.at(source, "found a net, expected a mission: templates draw missions")
    if ledger is None and (said := [f"--{name.replace('_', '-')}" for name, value in tree.items() if value]):
        what = "net" if isinstance(found, PetriNet) else "mission"
        raise InputError.at(source, f"found a {what}, expected a behaviour tree: {said[0]} is of trees")
    return Study(found, templates=templates, file=file, ledger=ledger)


def _read(file: Path, root: Path | None, options: TreeOptions) -> tuple[Mission | PetriNet, Ledger | None]:
    """What a file holds; of a tree its mission, and what each node became."""
    from mcpn.nets.formats import READABLE, read_net, refuse_foreign

    if file.suffix.lower() in READABLE:
        return read_net(file), None
    refuse_foreign(file)
    from mcpn.mission.xml import read_mission

    try:
        return read_mission(file, import_root=root), None
    except InputError as error:
        from mcpn.trees.reading import is_tree

        if is_tree(file):
            from mcpn.trees.importing import imported_of

            made = imported_of(file, root=root, **options)
            return made.mission, made.ledger
        from mcpn.answers.formula_errors import with_formulas

        raise with_formulas(error) from None
