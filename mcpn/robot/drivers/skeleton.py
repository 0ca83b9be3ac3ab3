"""A file of drivers to start from: each activity of a mission is a program that is still to be written."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping

from mcpn.robot.drivers.mapping import FAILURE, OTHER, SUCCESS, endings
from mcpn.robot.runtime.actions import START
from mcpn.robot.runtime.controller_tables import Tables

HEAD = """# What each activity of {mission} is, and where each event comes from: see docs/drivers.md.
# Write the programs, or name what there is (python = "module:function", mqtt = {{ ... }}); then
#   mcpn run MISSION --drivers FILE --check
# says what is still missing.

# Events that nothing on this robot tells. One that a driver tells is taken out here and named there,
# in its lines = {{ "what it prints" = "event" }} or ends = {{ other = "event" }}.
never = [{never}]
"""


def skeleton(tables: Tables) -> str:
    """The text of a file of drivers for a mission's controller; what is missing are the programs."""
    events = sorted(e for e in tables.known if not e.startswith("OBJ_") and e != START)
    never = "".join(f"\n    {_text(event)}," for event in events)
    rows = [HEAD.format(mission=tables.mission, never=f"{never}\n" if never else "")]
    ends = endings(tables.known)
    activities = ("\n".join(_activity(tables, name, ends)) + "\n" for name in tables.laws.activities)
    return "\n".join((*rows, *activities))


def _activity(tables: Tables, name: str, ends: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    laws = tables.laws
    row = laws.activities[name]
    objectives = [objective for objective, said in laws.objectives.items() if name in said["activities"]]
    given = [
        {value.name for value in laws.of(name, way, objective)}
        for way in row["alternatives"]
        for objective in (*objectives,) or (None,)
    ]
    command = [f"./{name}", *(("{alternative}",) if len(row["alternatives"]) > 1 else ())]
    # "--x={x}", not "{x}": a value such as -1.5 would be an option of the program.
    command += [
        f"--{hole}={{{hole}}}" for hole in sorted(set.intersection(*given)) if re.fullmatch(r"\w+", hole)
    ]
    yield f"[activities.{_key(name)}]"
    if objectives:
        shown = ", ".join(objectives[:5]) + (f" and {len(objectives) - 5} others" if objectives[5:] else "")
        yield f"# of the objectives {shown}"
    if consumed := sorted({what for way in row["alternatives"].values() for what in way["consumes"]}):
        yield f"# consumes {', '.join(consumed)}"
    yield f"process = [{', '.join(map(_text, command))}]"
    if objectives:
        words = {word for objective in objectives for word in ends.get(objective, {}).values()}
        reasons = enumerate(sorted(words - {SUCCESS, FAILURE}), 3)
        named = "".join(f', {number} = "{word}"' for number, word in reasons)
        yield f'ends = {{ 0 = "{SUCCESS}"{named}, {OTHER} = "{FAILURE}" }}'
        yield 'repeat = "fail" # or "safe": it may be begun again when a run that was interrupted goes on'


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
