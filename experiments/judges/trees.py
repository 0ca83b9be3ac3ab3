"""A family of behaviour trees in mcpn and in BehaVerify: answers side by side, and CPU seconds.

Usage: ``python experiments/judges/trees.py [--sizes N...] --behaverify PROGRAM --smv PROGRAM [--seconds S]``

A tree of size N is a sequence of N fallbacks, each of a check and of a repair, whose leaves succeed, fail or
run on as they like. BehaVerify (``pip install behaverify``) writes a model of it for nuXmv; ``--smv`` is that
or NuSMV, whose input is the same for these models. mcpn reads the tree as BehaviorTree.CPP writes it. Three
questions are asked of both, whose answers must be the same: the tree can succeed, it can fail, and its last
check can be asked while the first one runs, which it cannot. Programs that are not given are
left out. States are not compared: a state of BehaVerify's is a tick, one of mcpn's an answer of a leaf.
It takes some two minutes.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.nets.peers import measure
from experiments.shared.limits import Result, measured
from mcpn.study import Study
from mcpn.trees.importing import translate
from mcpn.trees.reading import read_forest

ANSWERS = (True, True, False)
"""To the three questions: known, since each leaf answers as it likes."""


LARGER = re.compile(r"\bmax\(([\w.]+), ([\w.]+)\)")
"""The larger of two numbers, which NuSMV does not know, as it is written for it."""


def of_btcpp(size: int) -> str:
    """The tree for BehaviorTree.CPP."""
    pairs = "".join(f'<Fallback name="either{i}"><Check{i}/><Repair{i}/></Fallback>' for i in range(size))
    root = '<root BTCPP_format="4"><BehaviorTree ID="Whole"><Sequence name="whole">'
    return f"{root}{pairs}</Sequence></BehaviorTree></root>"


def of_behaverify(size: int) -> str:
    """The tree in BehaVerify's language, with the questions."""
    leaves = [f"{kind}{i}" for i in range(size) for kind in ("check", "repair")]
    variables = "".join(
        f"variable {{ local of_{leaf} VAR {{'s', 'f', 'r'}} assign {{ result {{ 's' }} }} }}\n"
        for leaf in leaves
    )
    actions = "".join(
        f"action {{ {leaf} arguments {{}} local_variables {{ of_{leaf} }} read_variables {{}}\n"
        " write_variables {} initial_values {} update {\n"
        f" variable_statement {{ of_{leaf} assign {{ result {{ 's', 'f', 'r' }} }} }}\n"
        f" return_statement {{ case {{ (eq, of_{leaf}, 's') }} result {{ success }}\n"
        f" case {{ (eq, of_{leaf}, 'f') }} result {{ failure }} result {{ running }} }} }} }}\n"
        for leaf in leaves
    )
    memory = "with_partial_memory children"
    pairs = "".join(
        f"composite {{ either{i} selector {memory} {{ check{i} {{}} repair{i} {{}} }} }}\n"
        for i in range(size)
    )
    both = f"(exists_finally, (and, (running, check0), (active, check{size - 1})))"
    questions = ("(exists_finally, (success, whole))", "(exists_finally, (failure, whole))", both)
    asked = "".join(f"CTLSPEC {{ {question} }}\n" for question in questions)
    return (
        f"configuration {{}} enumerations {{ 's', 'f', 'r' }} constants {{}} variables {{\n{variables}}}\n"
        "environment_update {} checks {} environment_checks {}\n"
        f"actions {{\n{actions}}} sub_trees {{}}\n"
        f"tree {{ composite {{ whole sequence {memory} {{\n{pairs}}} }} }}\n"
        f"tick_prerequisite {{ True }} specifications {{\n{asked}}}\n"
    )


def asked_here(path: Path, size: int) -> Result:
    """The answers of mcpn."""
    study = Study(translate(read_forest(path), "whole", path.name).mission)
    both = f"EF (objective(Check0) & objective(Check{size - 1}))"
    questions = ("EF success", "EF failure", both)
    return {"answers": tuple(study.ctl(question).holds for question in questions)}


def rows(sizes: list[int], behaverify: str | None, smv: str | None, seconds: float) -> Iterator[list[str]]:
    """For each size: nodes, seconds of mcpn, of BehaVerify, and of the model checker."""
    for size in sizes:
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            (folder / "tree.xml").write_text(of_btcpp(size))
            (folder / "tree.tree").write_text(of_behaverify(size))
            here = measured(asked_here, folder / "tree.xml", size, seconds=seconds)
            assert here.get("answers", ANSWERS) == ANSWERS, here
            row = [f"{size}", f"{3 * size + 1}", f"{here['seconds']:.2f}" if "seconds" in here else "-"]
            model = None
            if behaverify is not None:
                command = [behaverify, "nuxmv", str(folder / "tree.tree"), str(folder / "out"), "--generate"]
                written = measure(command, 20 * seconds, 4)
                model = next(folder.glob("out/**/*.smv"), None)
                row.append(f"{written.cpu:.2f}" if model else f"- ({written.ended})")
            if smv is not None and model is not None:
                model.write_text(LARGER.sub(r"((\1 > \2) ? \1 : \2)", model.read_text()))
                found = measure([smv, str(model)], seconds, 4)
                answers = re.findall(r"-- specification .* is (true|false)", found.output)
                done = len(answers) == len(ANSWERS)
                assert not done or tuple(a == "true" for a in answers) == ANSWERS, found.output
                row.append(f"{found.cpu:.2f}" if done else f"- ({found.ended})")
            yield row


def main() -> None:
    """Prints the table."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--sizes", type=int, nargs="+", default=[2, 4, 8, 16, 32, 64])
    parser.add_argument("--behaverify", default=shutil.which("behaverify"), help="the program of BehaVerify")
    parser.add_argument(
        "--smv", default=shutil.which("nuXmv") or shutil.which("NuSMV"), help="nuXmv or NuSMV"
    )
    parser.add_argument("--seconds", type=float, default=60, help="for each run (default 60)")
    asked = parser.parse_args()
    heads = ["fallbacks", "nodes", "mcpn, CPU s"]
    heads += ["BehaVerify, CPU s"] if asked.behaverify else []
    heads += ["its model checked, CPU s"] if asked.behaverify and asked.smv else []
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    for row in rows(asked.sizes, asked.behaverify, asked.smv, asked.seconds):
        print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
