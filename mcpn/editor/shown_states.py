"""What an editor shows beside a mission's names, of its states: found by a process that can be ended.

``python -m mcpn.editor.shown_states mission.xml`` prints one JSON object: ``names``, Markdown by objective
and hardware; ``problems``, each with file, line and message, of verdicts and requirements that do not
hold and of what never happens.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from mcpn.errors import McpnError


def findings(file: Path) -> dict[str, Any]:
    """Modes and cut sets by objective, what each hardware resource can make fail, and problems."""
    from mcpn.answers.claims import claims_of_causes
    from mcpn.answers.claims.claim import sentences
    from mcpn.answers.claims.of_check import of_verdict
    from mcpn.mission.core.copies import grouped
    from mcpn.report.failures.sentences import conditions, losses
    from mcpn.report.words import modes_in_words
    from mcpn.study import open_study

    study = open_study(file)
    checked = study.verdicts()
    names = {
        objective: [f"Mode: {way or 'the alternatives named like their activities'}." for way in ways]
        for objective, modes in checked.modes.items()
        if (ways := modes_in_words(modes))
    }
    if checked.passed:
        causes = study.causes()
        hardware = {each.name for each in study.mission_net.core.hardware}
        claims = claims_of_causes(causes)
        own = {causes.mission.name: losses(claims, "defeat")}
        own |= {name: conditions(goal, name) for name, goal in causes.objectives.items() if goal.cut_sets}
        own |= {
            name: sentences((c for c in claims if c.holds and c.subject[:1] == (name,)), differ=1)
            for name in hardware
        }
        for name, said in own.items():
            names.setdefault(name, []).extend(said)
    problems = [
        {"file": at and at.file, "line": at and at.line, "message": problem.message}
        for problem in (*checked.unselectable, *checked.futile)
        for at in (problem.source,)
    ]
    problems += [
        {"file": str(file), "line": 1, "message": of_verdict(checked.verdicts[name]).sentence}
        for name in checked.failing
    ]
    copies, every = study.mission_net.graph.copies, [answer.asked.name for answer in checked.requirements]
    for met, word in ((False, "met"), (None, "decided")):
        asked = [answer.asked for answer in checked.requirements if answer.met is met]
        for source, same in grouped(asked, lambda each: each.requirement.source).items():
            if source is not None:
                subject, several = copies.subject("requirement", [each.name for each in same], every)
                message = f"{subject} {'are' if several else 'is'} not {word}"
                problems.append({"file": source.file, "line": source.line, "message": message})
    return {"names": {name: "\n\n".join(said) for name, said in names.items() if said}, "problems": problems}


def main() -> int:
    """Prints the findings of the file that the command line names; 1 where there are none."""
    try:
        found = findings(Path(sys.argv[1]))
    except McpnError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    sys.stdout.write(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
