"""What a check finds, as places in files: SARIF for tools, workflow commands for GitHub."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias
from urllib.parse import quote

from mcpn import __version__
from mcpn.answers.claims.of_check import of_verdict
from mcpn.answers.kinds.by_name import OF_VERDICTS
from mcpn.answers.verdicts.mission import required_of
from mcpn.errors import Problem, Source
from mcpn.report.words import in_words

if TYPE_CHECKING:
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.spaces.run import Run
    from mcpn.trees.ledger import Ledger

Level: TypeAlias = Literal["error", "warning", "note"]
AnnotationForm: TypeAlias = Literal["sarif", "github"]

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


class Annotation(NamedTuple):
    """Something that a check says of a place in a file.

    Args:
        level: An error fails the check; a note says how an answer is to be taken.
        rule: What was asked: a verdict's name, ``requirement``, ``warning``, ``tree`` or ``input``.
        message: What was found.
        source: Where.
    """

    level: Level
    rule: str
    message: str
    source: Source


def annotated(check: MissionCheck, path: str) -> Iterator[Annotation]:
    """Every required verdict and requirement that fails or is not known, and every warning.

    Args:
        check: The check.
        path: The mission's file, where something has no place of its own.
    """
    net, whole = check.mission_net, Source(path, 1)
    for name in required_of(net):
        verdict = check.verdicts[name]
        if not verdict.holds:
            said = of_verdict(verdict).sentence
            runs = verdict.runs_of_events[:1]
            yield Annotation("error", name, _with_run(check, said, *runs), net.mission.source or whole)
    for answer in check.requirements:
        if not answer.met:
            reason = answer.reason or f"{answer.asked.text} {'holds' if answer.holds else 'fails'}"
            said = f"requirement {answer.asked.name} is not met: {answer.asked.words} ({reason})"
            runs = () if answer.witness is None else (answer.witness.run,)
            place = answer.asked.requirement.source or whole
            level: Level = "error" if answer.required else "warning"
            yield Annotation(level, "requirement", _with_run(check, said, *runs), place)
    yield from of_problems(check.warnings, "warning", whole)


def of_ledger(check: MissionCheck, ledger: Ledger, whole: Source) -> Iterator[Annotation]:
    """What a ledger says of a behaviour tree that was checked as a mission.

    Args:
        check: The check.
        ledger: What each node became.
        whole: The tree's file.

    Yields:
        What libraries read otherwise, which answers hold of the tree, each node that is not exact.
    """
    from mcpn.trees.ledger import WORDS, of_translated

    yield from of_problems(ledger.warnings, "warning", whole)
    if not ledger.inexact:
        return
    mission = check.mission_net.mission
    for translated in mission.translated:
        made, survives = of_translated(translated)
        said = f"{made[0].upper()}{made[1:]}. {survives}"
        yield Annotation("note", "tree", said, mission.source or whole)
    for entry in ledger.inexact:
        why = f": {entry.why}" if entry.why else ""
        said = f"{entry.node.title} is {WORDS[entry.kind]}{why}"
        yield Annotation("note", "tree", said, entry.node.source)


def of_problems(problems: Iterable[Problem], level: Level, whole: Source) -> Iterator[Annotation]:
    """Warnings, or what is wrong with an input.

    Args:
        problems: What is said of it.
        level: Which they are.
        whole: The file of those that name none.
    """
    rule = "input" if level == "error" else "warning"
    for problem in problems:
        yield Annotation(level, rule, problem.message, problem.source or whole)


def _with_run(check: MissionCheck, said: str, *runs: Run) -> str:
    """A sentence, and the run that shows it, an event a line."""
    steps = [
        f"{number}. {words}"
        for run in runs
        for number, (_, words) in enumerate(in_words(check.mission_net, run), 1)
    ]
    return "\n".join([said, *steps])


def written(form: AnnotationForm, found: Iterable[Annotation]) -> str:
    """Annotations as the text that a tool reads."""
    from json import dumps

    if form == "sarif":
        return dumps(sarif(found), indent=2, ensure_ascii=False)
    return "\n".join(map(_command, found))


def sarif(found: Iterable[Annotation]) -> dict[str, Any]:
    """Annotations as a log of SARIF 2.1.0."""
    found = [*found]
    rules = {
        name: OF_VERDICTS[name].holds if name in OF_VERDICTS else _RULES[name]
        for name in (a.rule for a in found)
    }
    return {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "mcpn",
                        "version": __version__,
                        "rules": [
                            {"id": name, "shortDescription": {"text": text}} for name, text in rules.items()
                        ],
                    }
                },
                "results": [
                    {
                        "ruleId": each.rule,
                        "level": each.level,
                        "message": {"text": each.message},
                        "locations": [_location(each.source)],
                    }
                    for each in found
                ],
            }
        ],
    }


_RULES = {
    "requirement": "A requirement of the mission.",
    "warning": "What is suspicious in a mission, though it can be verified.",
    "tree": "What of a behaviour tree the mission that was verified does not say exactly.",
    "input": "A file that cannot be read as what it is to be.",
}


def _location(source: Source) -> dict[str, Any]:
    uri = quote(source.file.replace("\\", "/"))
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": {"startLine": source.line or 1}}}


def _command(each: Annotation) -> str:
    """One workflow command, where a note is a notice; what ends a property or a line in it is escaped."""
    properties = {"file": each.source.file, "line": str(each.source.line or 1), "title": f"mcpn {each.rule}"}
    said = ",".join(f"{key}={_escaped(text, ':,')}" for key, text in properties.items())
    return f"::{'notice' if each.level == 'note' else each.level} {said}::{_escaped(each.message)}"


def _escaped(text: str, also: str = "") -> str:
    r"""A text of a workflow command.

    >>> _escaped("50 %\nof a:b", ":")
    '50 %25%0Aof a%3Ab'
    """
    return "".join(f"%{ord(c):02X}" if c in f"%\r\n{also}" else c for c in text)
