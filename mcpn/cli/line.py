"""The commands under one name, each loaded when it is called."""

from __future__ import annotations

import os
import sys
from collections import UserDict
from collections.abc import Iterator, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import click

from mcpn.cli.exit_codes import EXIT_FAILED, exit_code, tell
from mcpn.cli.options import json_asked
from mcpn.cli.printed import emit_json
from mcpn.errors import ConfluenceError, SemanticsError
from mcpn.report.terminal import LEAST_WIDTH, WIDTH
from mcpn.version import VERSION

COMMANDS = {
    "alternatives": "alternatives",
    "ask": "ask",
    "bench": "robot.bench",
    "causes": "causes",
    "check": "check",
    "compare": "compare",
    "controller": "controller",
    "convert": "convert",
    "init": "init",
    "lsp": "lsp",
    "monitor": "robot.monitor",
    "report": "report",
    "run": "robot.run",
    "schema": "schema",
    "serve": "report",
    "simulate": "simulate",
    "states": "states",
    "tests": "robot.sequences",
}
"""By command, the module of this package that has it."""
OTHER_WORDS = {
    "analyse": "causes",
    "create": "init",
    "draw": "convert",
    "execute": "run",
    "export": "convert",
    "fmea": "causes",
    "fmeca": "causes",
    "generate": "controller",
    "help": "--help",
    "import": "check",
    "lint": "check",
    "new": "init",
    "plot": "convert",
    "query": "ask",
    "render": "convert",
    "start": "run",
    "test": "tests",
    "validate": "check",
    "verify": "check",
    "view": "report",
}
"""By a command that other tools have, what does it here."""
ALIASES = {"ctl": "ask"}
"""By an older name of a command, its name."""


def _keep_width(context: click.Context, _: click.Parameter, width: int | None) -> None:
    if width is not None:
        context.meta[WIDTH] = width


def _width() -> click.Option:
    """The option that stands before a command or after it."""
    return click.Option(
        ["--width"],
        type=click.IntRange(LEAST_WIDTH, 10_000),
        expose_value=False,
        callback=_keep_width,
        help="Characters of a line (default: the terminal's; in a pipe lines are whole).",
    )


class _Commands(UserDict[str, click.Command]):
    """The commands, each loaded when it is asked for."""

    def __missing__(self, name: str) -> click.Command:
        if name in ALIASES:
            return self[ALIASES[name]]
        command: click.Command = getattr(import_module(f"mcpn.cli.{COMMANDS[name]}"), name)
        command.params.append(_width())
        self[name] = command
        return command

    def __contains__(self, name: object) -> bool:
        return name in COMMANDS or name in ALIASES

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


class _CommandLine(click.Group):
    """Semantics that allow no answer are an answer of their own, in JSON where that is asked for."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] in OTHER_WORDS:
            ctx.fail(f"No such command {args[0]!r}. Did you mean 'mcpn {OTHER_WORDS[args[0]]}'?")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except SemanticsError as error:
            # Of two runs that part inside the net, the events are what its user can follow.
            runs = [error.events] if isinstance(error, ConfluenceError) and error.events else error.runs
            if json_asked(ctx):
                emit_json({"error": error.kind, "message": str(error), "runs": runs})
            else:
                tell(str(error))
                for number, run in enumerate(runs, 1):
                    click.echo(f"  run {number}: {' '.join(run)}", err=True)
            ctx.exit(EXIT_FAILED)


@click.group(
    cls=_CommandLine,
    commands=_Commands(),
    params=[_width()],
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(VERSION, prog_name="mcpn")
def command_line() -> None:
    """Verify robot missions and generate their controllers."""


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs one command.

    Args:
        arguments: What follows the program's name; by default those of this process.

    Returns:
        The exit code. Nothing but an interruption is raised.
    """
    if "_MCPN_COMPLETE" in os.environ:
        command_line.main(prog_name="mcpn")  # answers a shell that completes a command, and exits
    return exit_code(partial(_invoke, sys.argv[1:] if arguments is None else list(arguments)))


def _invoke(arguments: list[str]) -> None:
    with command_line.make_context("mcpn", arguments) as context:
        command_line.invoke(context)
