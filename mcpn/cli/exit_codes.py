"""Exit codes of commands: which error ends a command with which, and with what message.

0: all that is required holds. 1: a verdict or a requirement fails, or the semantics do not allow an answer.
2: something is wrong with the input, the options or the machine, and a sentence says what. 128 and the number
of a signal: it ended the command (:mod:`mcpn.cli`, :mod:`mcpn.cli.robot.run`).
"""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress

import click

from mcpn.errors import InputError, McpnError
from mcpn.report.terminal import plain

TRACEBACK = "MCPN_TRACEBACK"
"""Variable of the environment that shows where an internal error comes from."""
EXIT_FAILED, EXIT_BAD_INPUT = 1, 2
EXIT_SIGNAL = 128
"""And the number of the signal that ended the command."""
EXIT_PIPE = EXIT_SIGNAL + signal.SIGPIPE
"""As of a program that the signal ends: who reads its output has read enough, as head does."""
_OUTPUT = "standard output:"
_NO_ROOM = "failed to map segment"


def exit_code(command: Callable[[], None]) -> int:
    """Calls a command, and says on standard error what is wrong.

    Returns:
        The exit code. Nothing but an interruption is raised.
    """
    try:
        code = _answer(command)
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:  # readers and writers of files tell theirs
        told = _refusal(error)
        if isinstance(error, BrokenPipeError) and told.startswith(_OUTPUT):  # whoever read has read enough
            _forget_output()
            return EXIT_PIPE
        tell(told)
        _forget_output()
        return EXIT_BAD_INPUT
    return code


def _answer(command: Callable[[], None]) -> int:
    try:
        command()
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
            tell(str(problem))
    except McpnError as error:
        tell(str(error))
    except MemoryError as error:  # of a diagram store, whose limit it names, or of this process
        tell(f"out of memory: {str(error) or 'this process has no more'}")
    except RecursionError:
        tell("nested too deep for this process")
    except OSError:
        raise
    except Exception as error:
        # Of the loader of libraries; hashlib keeps to itself why it could not load one.
        if isinstance(error, ImportError) and (_NO_ROOM in str(error) or error.name == "hashlib"):
            tell(f"out of memory: a library cannot be loaded: {str(error).splitlines()[-1]}")
            return EXIT_BAD_INPUT
        if os.environ.get(TRACEBACK):
            raise
        where = _where(error)
        what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        tell(f"internal error, a fault of mcpn: {what} ({where}; {TRACEBACK}=1 shows where it comes from)")
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


def tell(message: str) -> None:
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
