"""Formulas and properties: answers with the runs that show them; and the words that formulas are made of."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import choice_object, emit_json

if TYPE_CHECKING:
    from mcpn.answers.safety import SafetyAnswer
    from mcpn.drawing.compose import MissionNet
    from mcpn.logic.open_questions import ContestAnswer
    from mcpn.logic.questions import Questions
    from mcpn.logic.session import Answer
    from mcpn.logic.witness import Witness
    from mcpn.nets.petri import PetriNet
    from mcpn.spaces.engine_names import Asked, On

EXAMINATIONS = ("ReachabilityDeadlock", "QuasiLiveness", "Liveness", "OneSafe", "StableMarking")


@click.command()
@click.argument("file", type=FILE)
@click.argument("formulas", nargs=-1, metavar="FORMULA...")
@click.option(
    "--properties",
    multiple=True,
    type=FILE,
    help="Answer a property file of the Model Checking Contest; may be repeated.",
)
@click.option(
    "--examination",
    "examinations",
    multiple=True,
    type=click.Choice(EXAMINATIONS),
    help="Answer an examination of the contest; may be repeated.",
)
@click.option(
    "--on",
    "graph",
    type=click.Choice(["markings", "alternatives"]),
    help="Evaluate on all markings (the default of a net), or on stable states and events (of a mission).",
)
@click.option("--fair", multiple=True, help="'progress', or a formula that holds again and again on paths.")
@engine_option("search")
@click.option("--robot-safety", is_flag=True, help="Ask the questions of a safety engineer of a mission.")
@click.option("--dangerous", multiple=True, metavar="ACTIVITY", help="What must not run after a --stop.")
@click.option("--stop", "stops", multiple=True, metavar="EVENT", help="Stops the robot; may be repeated.")
@click.option("--hoa", is_flag=True, help="Print the automaton of each FORMULA on paths, and answer none.")
@click.option("--scn", type=FILE, help="Write the run of the one FORMULA as a firing sequence.")
@question(workers=True)
def ask(
    question: Question,
    file: Path,
    formulas: tuple[str, ...],
    properties: tuple[Path, ...],
    examinations: tuple[str, ...],
    graph: On | None,
    fair: tuple[str, ...],
    engine: Asked,
    robot_safety: bool,
    dangerous: tuple[str, ...],
    stops: tuple[str, ...],
    hoa: bool,
    scn: Path | None,
) -> None:
    """Answer formulas of CTL and LTL on FILE: the stable states of a mission, or the markings of a net.

    With no FORMULA, list the words of the mission that formulas are made of. All that one call asks shares
    one space, and what a search or the state equation decides needs none. Exit code 1 if some FORMULA does
    not hold; property files and examinations answer with 0 either way.
    """
    if scn and len(formulas) != 1:
        raise click.UsageError("--scn goes with one FORMULA")
    if robot_safety and (formulas or properties or examinations or hoa or graph or fair):
        raise click.UsageError("--robot-safety asks questions of its own: no FORMULA goes with it")
    if (dangerous or stops) and not robot_safety:
        raise click.UsageError("--dangerous and --stop go with --robot-safety")
    from mcpn.logic.answering import answer_typed

    with question.progress():
        study = question.study(file, engine)
    question.keep_apart(file, study, scn)
    if robot_safety:
        with question.work():
            found = study.robot_safety(dangerous=dangerous, stops=stops)
        _tell_safety(found, study.mission_net, question.as_json)
        return
    if not (formulas or properties or examinations):
        if study.is_net:
            raise click.UsageError("a FORMULA, --properties or --examination is needed to ask about a net")
        _list_words(study.mission_net, question.as_json)
        return
    answers: Sequence[Answer] = ()
    with question.workers():
        questions = study.questions(on=graph, fair=fair)
        # Everything asked is understood before anything is answered.
        questions.formulas(formulas)
        if hoa:
            _print_automata(questions, formulas, question.as_json)
            return
        with question.progress():
            objects = _tell_contest(questions, properties, examinations, question.as_json)
        if formulas:
            with question.progress():
                answers = answer_typed(questions, formulas)
    if scn:
        _write_scenario(answers[0], scn)
    if question.as_json:
        emit_json([*objects, *(_answer_object(answer, study.net) for answer in answers)])
    elif answers:
        from mcpn.report.text import print_answers

        print_answers(answers, study.net, None if study.is_net else study.mission_net)
    if not all(answer.holds for answer in answers):
        sys.exit(EXIT_FAILED)


def _tell_safety(found: Sequence[SafetyAnswer], mission_net: MissionNet, as_json: bool) -> None:
    if as_json:
        emit_json(
            [
                {
                    "question": each.name,
                    "sentence": each.sentence,
                    "holds": each.holds,
                    "applies": each.applies,
                    "why": list(each.why),
                    "notes": list(each.notes),
                    "run": None if each.run is None else [str(event) for event in each.run.events],
                }
                for each in found
            ]
        )
    else:
        from mcpn.report.checked import print_safety

        print_safety(found, mission_net)
    if any(each.is_open for each in found):
        sys.exit(EXIT_FAILED)


def _print_automata(questions: Questions, formulas: tuple[str, ...], as_json: bool) -> None:
    """The automata of formulas on paths, in the Hanoi format."""
    from mcpn.errors import InputError
    from mcpn.logic.ltl.automaton import translated
    from mcpn.logic.ltl.formula_classes import classes
    from mcpn.logic.ltl.formulas import is_of_paths, normal
    from mcpn.logic.ltl.hoa import write_hoa
    from mcpn.logic.syntax import parse_open
    from mcpn.logic.writing import show

    found = []
    for text in formulas:
        formula = parse_open(text, questions.names)
        if not is_of_paths(formula):
            raise InputError.at(None, f"{text}: expected a formula on one path, of X F G U W R")
        formula = normal(formula)
        automaton = write_hoa(translated(formula), text, formula, lambda f: show(f, questions.names))
        found.append({"formula": text, "classes": classes(formula), "hoa": automaton})
    if as_json:
        emit_json(found)
    else:
        for each in found:
            click.echo(each["hoa"], nl=False)


def _list_words(mission_net: MissionNet, as_json: bool) -> None:
    """The words that formulas about a mission are made of."""
    from mcpn.answers.vocabulary import vocabulary

    words = vocabulary(mission_net)
    if as_json:
        emit_json(asdict(words))
    else:
        from mcpn.report.text import print_vocabulary

        print_vocabulary(words)


def _tell_contest(
    questions: Questions, properties: tuple[Path, ...], examinations: tuple[str, ...], as_json: bool
) -> list[dict[str, Any]]:
    """Answers property files, all of which are understood first, and examinations, in their order.

    An answer waits for those before it, and is told however the rest ends.
    """
    if not (properties or examinations):
        return []
    from mcpn.logic.answering import answer_all, examination
    from mcpn.logic.contest import read_properties

    files = dict.fromkeys(properties)
    of_files = [each for path in files for each in read_properties(path, questions.names)]
    order = [*(each.name for each in of_files), *(examination(questions, name) for name in examinations)]
    waiting: dict[str, ContestAnswer] = {}
    objects = []

    def tell(name: str) -> None:
        verdict = waiting.pop(name)
        objects.append(_contest_object(verdict))
        if not as_json:
            click.echo(str(verdict))

    rest = dict.fromkeys(order)
    try:
        for found in answer_all(questions, of_files, examinations):
            waiting[found.name] = found
            while (first := next(iter(rest), None)) in waiting:
                del rest[first]
                tell(first)
    finally:
        for name in [name for name in rest if name in waiting]:
            tell(name)
    return objects


def _write_scenario(answer: Answer, path: Path) -> None:
    from mcpn.files import write_atomically
    from mcpn.logic.witness import scenario

    write_atomically(path, scenario(answer.witness))


def _contest_object(verdict: ContestAnswer) -> dict[str, Any]:
    """The answer to a property of the contest: a truth value, or a bound."""
    truth = {"TRUE": True, "FALSE": False}.get(verdict.value)
    answer: dict[str, Any] = {"formula": verdict.name, "holds": truth, "witness": None}
    answer["techniques"] = list(verdict.techniques)
    if truth is not None:
        return answer
    unbounded = verdict.value == "INF"
    return {**answer, "value": None if unbounded else int(verdict.value), "unbounded": unbounded}


def witness_object(witness: Witness, net: PetriNet) -> dict[str, Any]:
    """The run that shows an answer."""
    return {
        "events": [str(event) for event in witness.run.events],
        "firings": [net.transitions[t].name for t in witness.firings],
        "cycle": witness.cycle_firing,
        "notes": witness.notes,
    }


def _answer_object(answer: Answer, net: PetriNet) -> dict[str, Any]:
    shown = witness_object(answer.witness, net)
    found = {"formula": answer.formula, "holds": answer.holds, "witness": shown}
    return {**found, **choice_object(answer.choice), "techniques": list(answer.techniques)}
