"""What defeats Nav2's default navigation, with an assumed robot and our questions; SUAVE's job natively.

Usage: ``python experiments/robots/nav2.py --trees FOLDER [--tree NAME] [-o DIR] [--write]``

FOLDER (or ``MCPN_TREES``) has the trees that Nav2 ships, by themselves or in folders; none of them is part of
the project. The robot is in ``nav2/robot.xml``, the mission with SUAVE's job in ``suave/pipeline.xml``. It
takes some seconds, a minute with ``-o``, which keeps the mission of Nav2's tree, its ledger and the report.
``--write`` puts what was found into papers/nav2.md. Without ``--trees`` it is SUAVE alone.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from mcpn.errors import InputError
from mcpn.files import write_folder
from mcpn.study import Study, open_study
from mcpn.trees.importing import Imported, files_of, translate
from mcpn.trees.ledger import SURVIVES, WORDS
from mcpn.trees.reading import read_forest
from mcpn.xmlio import parse_xml

HERE = Path(__file__).parents[1]
ROBOT = HERE / "nav2" / "robot.xml"
PAGE = HERE.parent / "papers" / "nav2.md"
SUAVE = HERE / "suave" / "pipeline.xml"
DEFAULT = "navigate_to_pose_w_replanning_and_recovery"
VERSIONS = ("1.4", "1.5")
"""Of Nav2: between them RoundRobin got another meaning."""
ORDER = ("hardware", "fault", "software", "fact", "event", "activity")
QUESTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "It ends, if what runs ends some day": (
        "A F (success | failure)",
        ("progress",),
    ),
    "The robot moves without costmaps": (
        "E F ((activity(FollowPath) | activity(Spin) | activity(BackUp)) & !available(costmaps))",
        (),
    ),
    "A path is followed by dead reckoning": (
        "E F (activity(FollowPath) & alternative(localization)=dead_reckoning)",
        (),
    ),
    "While the lidar is out of service the robot may arrive": (
        "E F (oos(lidar) & !(success | failure) & E [(oos(lidar) & !failure) U (oos(lidar) & success)])",
        (),
    ),
    "After a new goal is heard in a recovery, recovery is over at once": (
        "A G (happens(GoalUpdated_succeeds) -> X !(objective(Spin) | objective(BackUp) | objective(Wait)))",
        (),
    ),
}
"""By what is asked, the formula and its fairness."""


def tree_in(folder: Path, name: str) -> Path:
    """The file of a tree in a folder."""
    found = sorted(path for path in folder.rglob("*.xml") if path.stem.endswith(name))
    if not found:
        raise SystemExit(f"{folder} has no file {name}.xml: give the folder of Nav2's trees")
    return found[0]


def robot_of(generated: str) -> str:
    """The robot that the import has written, with what we assume of its activities and resources."""
    made = etree.fromstring(generated.encode())
    ours = [child for child in parse_xml(ROBOT, 1 << 20) if isinstance(child.tag, str)]
    known = {child.get("name") for child in ours}
    kept = [child for child in made if isinstance(child.tag, str) and child.get("name") not in known]
    names = {child.get("name") for child in made if isinstance(child.tag, str)}
    used = [child for child in ours if child.get("name") in names or _is_resource(child)]
    made[:] = sorted([*kept, *used], key=lambda child: ORDER.index(etree.QName(child).localname))
    return etree.tostring(made, encoding="unicode") + "\n"


def _is_resource(child: etree._Element) -> bool:
    """Whether it is no activity of a leaf: hardware, software, or what produces software."""
    return etree.QName(child).localname != "activity" or child.get("produces") is not None


def mission_in(folder: Path, tree: Path, version: str) -> tuple[Imported, Study]:
    """The tree as a mission of the robot, read as a version of Nav2 and written into a folder."""
    imported = translate(read_forest(tree, library=[f"nav2={version}"]), "nav2", tree.name)
    files = files_of(imported)
    files["robot.xml"] = robot_of(files["robot.xml"])
    write_folder(folder, files)
    return imported, open_study(folder / "mission.xml")


def side_by_side(folder: Path, tree: Path) -> Iterator[str]:
    """What the tree is in each version."""
    yield "| Nav2 | " + " | ".join(VERSIONS) + " |\n|---|" + "---|" * len(VERSIONS)
    columns = []
    for version in VERSIONS:
        imported, study = mission_in(folder / version, tree, version)
        checked = study.verdicts()
        warned = [problem.message for problem in checked.warnings if "by its success" in problem.message]
        counts = imported.ledger.counts
        columns.append(
            (
                ", ".join(f"{count} {WORDS[kind]}" for kind, count in counts.items() if count),
                "; ".join(warned) or "nothing",
                f"{checked.stable_sizes[0]:,}",
            )
        )
    titles = ("nodes", "`check` warns of recoveries that do not help", "stable states")
    for title, *cells in zip(titles, *columns, strict=True):
        yield f"| {title} | {' | '.join(cells)} |"
    yield ""


def lines(imported: Imported, study: Study) -> Iterator[str]:
    """What was found, as a page says it."""
    begun = time.process_time()
    counts = imported.ledger.counts
    told = ", ".join(f"{count} {WORDS[kind]}" for kind, count in counts.items() if count)
    yield f"{len(imported.ledger.entries)} nodes: {told}. {SURVIVES[imported.ledger.kind]}\n"
    checked = study.verdicts()
    causes = study.causes()
    spent = time.process_time() - begun
    yield "| verdict | | |\n|---|---|---|"
    for verdict in checked.verdicts.values():
        if verdict.holds or verdict.required:
            yield f"| `{verdict.name}` | {_answer(verdict.holds)} | {verdict.explanation} |"
    sets = " or ".join(_set(names) for names in causes.mission.cut_sets)
    yield f"\nThe mission fails by the loss of {sets}.\n"
    yield "| leaf | fails by the loss of |\n|---|---|"
    seen = dict[str, str]()
    for name, goal in causes.objectives.items():
        plain = study.mission_net.graph.copies.plain(name).rpartition(".")[2]
        seen.setdefault(plain, " or ".join(_set(names) for names in goal.cut_sets) or "nothing")
    yield from (f"| {name} | {sets} |" for name, sets in seen.items() if sets != "nothing")
    yield "\n| question | formula | |\n|---|---|---|"
    for asked, (formula, fair) in QUESTIONS.items():
        try:
            answer = _answer(study.ctl(formula, fair=fair).holds)
        except InputError as error:  # the tree has not what the question is about
            answer = str(error).partition("\n")[0]
        code = formula.replace("|", "\\|")
        yield f"| {asked} | `{code}`{', fair: ' + ' '.join(fair) if fair else ''} | {answer} |"
    yield f"\n{checked.stable_sizes[0]:,} stable states, {spent:.1f} s of CPU for verdicts and causes."


def modes() -> Iterator[str]:
    """The functioning modes of our mission with SUAVE's job, beside what its authors' tree changes to."""
    checked = open_study(SUAVE).verdicts()
    yield "| objective | `f_maintain_motion` | `f_generate_search_path` |\n|---|---|---|"
    for objective, found in checked.modes.items():
        for mode in found:
            motion, path = (mode.get(name, "") for name in ("maintain_motion", "generate_search_path"))
            yield f"| {objective} | {motion} | {path} |"
    yield f"\n{len(checked.modes['search'])} while it searches; {checked.stable_sizes[0]:,} stable states."


def put(page: str, name: str, text: str) -> str:
    """A page with a text where it was measured before."""
    block = re.compile(rf"(<!-- measured: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    return block.sub(lambda found: found[1] + text + found[2], page)


def _answer(holds: bool | None) -> str:
    return "unknown" if holds is None else "yes" if holds else "no"


def _set(names: frozenset[str] | tuple[str, ...]) -> str:
    return " and ".join(f"`{name}`" for name in sorted(names))


def main() -> None:
    """Says what was found, and writes it into the page where that is asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trees", type=Path, default=os.environ.get("MCPN_TREES"))
    parser.add_argument("--tree", default=DEFAULT, help="name of the file, without .xml")
    parser.add_argument("-o", "--output", type=Path, help="folder for mission, ledger and report")
    parser.add_argument("--write", action="store_true", help="put what was found into papers/nav2.md")
    asked = parser.parse_args()
    measured = {"suave": "\n".join(modes()) + "\n"}
    if asked.trees is not None:
        measured["nav2"] = of_tree(Path(asked.trees), asked.tree, asked.output)
    print("\n".join(measured.values()))
    if asked.write:
        page = PAGE.read_text()
        for name, text in measured.items():
            page = put(page, name, text)
        PAGE.write_text(page)


def of_tree(folder: Path, tree: str, output: Path | None) -> str:
    """What was found of a tree, and its mission with the report, where they are kept."""
    with tempfile.TemporaryDirectory() as scratch:
        kept = output or Path(scratch) / "nav2"
        both = "\n".join(side_by_side(Path(scratch), tree_in(folder, tree)))
        imported, study = mission_in(kept, tree_in(folder, tree), VERSIONS[-1])
        found = both + "\n" + "\n".join(lines(imported, study)) + "\n"
        if output is not None:
            study.report(kept / "report.html")
    return found


if __name__ == "__main__":
    sys.exit(main())
