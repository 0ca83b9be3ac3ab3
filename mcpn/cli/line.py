"""The commands under one name, and how errors become messages and exit codes."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections import UserDict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any

import click

from mcpn.cli.options import EXIT_BAD_INPUT, EXIT_FAILED, json_asked
from mcpn.cli.printed import emit_json
from mcpn.errors import ConfluenceError, InputError, McpnError, SemanticsError
from mcpn.report.terminal import LEAST_WIDTH, WIDTH, plain
from mcpn.version import VERSION

TRACEBACK = "MCPN_TRACEBACK"
"""Variable of the environment that shows where an internal error comes from."""


EXIT_PIPE = 128 + signal.SIGPIPE
"""As of a program that the signal ends: who reads its output has read enough, as head does."""
_OUTPUT = "standard output:"
_NO_ROOM = "failed to map segment"

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
                _tell(str(error))
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
    try:
        code = _answer(sys.argv[1:] if arguments is None else list(arguments))
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:  # readers and writers of files tell theirs
        told = _refusal(error)
        if isinstance(error, BrokenPipeError) and told.startswith(_OUTPUT):  # whoever read has read enough
            _forget_output()
            return EXIT_PIPE
        _tell(told)
        _forget_output()
        return EXIT_BAD_INPUT
    return code


def _answer(arguments: list[str]) -> int:
    try:
        with command_line.make_context("mcpn", arguments) as context:
            command_line.invoke(context)
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else EXIT_BAD_INPUT
    except click.Abort as error:
        raise KeyboardInterrupt from error
    except click.ClickException as error:
        _show(error)
    except InputError as error:
        for problem in error.problems:
            _tell(str(problem))
    except McpnError as error:
        _tell(str(error))
    except MemoryError as error:  # of a diagram store, whose limit it names, or of this process
        _tell(f"out of memory: {str(error) or 'this process has no more'}")
    except RecursionError:
        _tell("nested too deep for this process")
    except OSError:
        raise
    except Exception as error:
        # Of the loader of libraries; hashlib keeps to itself why it could not load one.
        if isinstance(error, ImportError) and (_NO_ROOM in str(error) or error.name == "hashlib"):
            _tell(f"out of memory: a library cannot be loaded: {str(error).splitlines()[-1]}")
            return EXIT_BAD_INPUT
        if os.environ.get(TRACEBACK):
            raise
        where = _where(error)
        what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        _tell(f"internal error, a fault of mcpn: {what} ({where}; {TRACEBACK}=1 shows where it comes from)")
    else:
        return 0
    return EXIT_BAD_INPUT


def _where(error: BaseException) -> str:
    """The file and line that raised an error."""
    from traceback import extract_tb

    last = extract_tb(error.__traceback__)[-1]
    return f"{os.path.basename(last.filename)}:{last.lineno}"


def _refusal(error: OSError) -> str:
    """What the system has refused: to write the output, or something else that the error names."""
    reason = error.strerror or str(error) or type(error).__name__
    if error.errno == errno.ENOMEM:  # whatever file or folder it was about to read
        return f"out of memory: {reason}"
    if error.filename is not None:
        return f"{error.filename}: {reason}"
    raised = error.__traceback__
    while raised is not None and raised.tb_next is not None:
        raised = raised.tb_next
    by = "" if raised is None else str(raised.tb_frame.f_globals.get("__name__"))
    if by == __name__ or by.partition(".")[0] == "click":
        return f"{_OUTPUT} cannot be written: {reason}"
    return f"the operating system refuses what this command needs: {reason} ({_where(error)})"


def _tell(message: str) -> None:
    """Says on standard error what is wrong, if anybody can hear it."""
    with suppress(OSError):
        for line in f"error: {message}".split("\n"):
            click.echo(plain(line), err=True)


def _show(error: click.ClickException) -> None:
    if isinstance(error, click.NoSuchOption) and error.ctx is not None and error.ctx.parent is None:
        # Options of commands stand behind their names; click would look for a near one among its own.
        name = error.option_name
        told = f"found {name} before a command, expected it behind: mcpn check mission.xml {name}"
        error = click.UsageError(told, error.ctx)
    with suppress(OSError):
        error.show()


def _forget_output() -> None:
    """Keeps the interpreter from writing, at its end, what could not be written."""
    with suppress(OSError, ValueError):  # no file may stand behind it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
