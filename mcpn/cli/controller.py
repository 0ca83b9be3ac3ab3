"""The controller of a mission, written as files."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Literal

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json
from mcpn.cli.verified_first import require_verified
from mcpn.errors import SemanticsError
from mcpn.robot.targets import OF_RULES, TARGETS, files

REFUSED = "not written: mcpn check says no (--unverified writes it all the same)"
MANY_BYTES = 2_000_000
"""Bytes of a controller's files from which the form is named that is smaller."""


def _once() -> Callable[[str], None]:
    """Says on standard error what has not been said before."""
    said = set[str]()

    def tell(text: str) -> None:
        if text not in said:
            click.echo(text, err=True)
        said.add(text)

    return tell


@click.command()
@click.argument("mission", type=FILE)
@click.option(
    "--target",
    type=click.Choice([*TARGETS]),
    default="json",
    show_default=True,
    help="btcpp: a node of BehaviorTree.CPP 4, around c; ros2: a package with a node, around python.",
)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the controller to.")
@click.option(
    "--form",
    type=click.Choice(["auto", "hierarchical", "minimised", "modular", "flat"]),
    default="auto",
    show_default=True,
    help="A machine for each type of section, the same without states that no run of events tells apart, "
    "rules for each, or one machine; auto: hierarchical where it fits, else modular.",
)
@click.option("--hierarchical", "form", flag_value="hierarchical", help="The same as --form hierarchical.")
@click.option("--flat", "form", flag_value="flat", help="The same as --form flat.")
@click.option("--unverified", is_flag=True, help="Do not verify the mission first; the files say so.")
@click.option(
    "--certificate",
    type=FILE,
    metavar="OUT",
    help="Write the mission's net and claims to OUT, and have a checker walk controller.json beside it.",
)
@question(workers=True, trees=False)
def controller(
    question: Question,
    mission: Path,
    target: str,
    output: Path,
    form: Literal["auto", "hierarchical", "minimised", "modular", "flat"],
    unverified: bool,
    certificate: Path | None,
) -> None:
    """Generate the controller of MISSION: state machines, or rules, that do what was verified.

    A mission that mcpn check says no to is reported, and nothing is written: exit code 1.
    """
    from mcpn.controller.document import document_in_rows
    from mcpn.controller.generate import refuse_or_tell
    from mcpn.controller.hierarchy import TableController
    from mcpn.controller.minimise import minimise
    from mcpn.controller.sizes import MAX_TABLE_STATES
    from mcpn.files import write_atomically, write_folder

    study = question.study(mission)
    question.keep_apart(mission, study, certificate, made=output)
    tables = form == "auto" and target not in OF_RULES
    made = "hierarchical" if form == "minimised" or tables else form
    told, most, walked = _once(), question.max_states, None
    if form == "minimised" and most is None:  # whose file is small whatever is listed for it
        most = MAX_TABLE_STATES
    with question.work():
        if not unverified and not study.is_net:
            if made == "hierarchical":
                composite = study.mission_spaces("a controller").composite
                with suppress(SemanticsError):  # which verification reports with more
                    refuse_or_tell(composite(), most, told)
            require_verified(study, question, REFUSED)
        found = study.controller(made, max_states=most, told=told)
    size = found.size
    if form == "minimised" and isinstance(found, TableController):
        found = minimise(found)
        size = f"{size}; minimised: {found.states} states, {found.moves} edges"
    texts = files(document_in_rows(found, study.mission_net, verified=not unverified), target)
    question.keep_apart(mission, study, *(output / name for name in texts), certificate, made=output)
    written = None
    if certificate is not None:
        from mcpn.certificates.writing import certificate_of

        with question.work():
            written = certificate_of(study.verdicts(), question.max_states)
    write_folder(output, texts)
    if certificate is not None and written is not None:
        write_atomically(certificate, written.to_bytes())
        walked = _walked(
            certificate, output / "controller.json" if target == "json" else None, written.listed
        )
    bytes_ = sum(len(text if text.isascii() else text.encode()) for text in texts.values())
    if bytes_ > MANY_BYTES and found.form != "modular" and target in OF_RULES:
        mb = bytes_ / 1e6
        click.echo(f"note: {mb:,.0f} MB; --form modular has rules in place of tables, mostly less", err=True)
    paths = [str(output / name) for name in texts]
    if question.as_json:
        said = {} if walked is None else {"walked": walked.partition(": ")[2]}
        emit_json({"mission": found.mission, "form": found.form, "size": size, "files": paths, **said})
    else:
        click.echo(f"{found.form} controller of {found.mission}: {size}")
        for path in (*paths, *([] if walked is None else [walked])):
            click.echo(path)
    if walked is not None and walked.partition(": ")[2].startswith("refuted"):
        sys.exit(EXIT_FAILED)


def _walked(certificate: Path, controller: Path | None, listed: bool) -> str:
    """What a checker says of a controller beside a certificate, and how it is asked elsewhere.

    Args:
        certificate: The certificate.
        controller: The controller's document, if it is written.
        listed: Whether the states of the certificate's net can be listed; else sections are walked by type.
    """
    from mcpn.certificates import ctlcheck
    from mcpn.certificates.checked_claims import GAVE_UP, MOST, SECONDS, gave_up
    from mcpn.certificates.sections import sectionctl

    program: ModuleType = ctlcheck if listed else sectionctl
    name = program.__name__.rpartition(".")[2]
    if controller is None:
        return f"{name}: not checked: it walks controller.json, which --target json writes"
    try:
        ((how, _, why),) = program.checked(str(certificate), str(controller), most=MOST, seconds=SECONDS)
    except GAVE_UP as error:
        how, why = "not checked", gave_up(error)
    return f"{name}: {how}: {why} (python -m {program.__name__} {certificate} {controller})"
