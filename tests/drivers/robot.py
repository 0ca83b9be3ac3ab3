"""A part of a robot, as a process: it notes its number, and ends when a file of its name says so."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

name, *options = sys.argv[1:]
if "stubborn" in options:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
children = []
if "parent" in options:  # one in the group of its parent, one in a session of its own
    children = [subprocess.Popen(["sleep", "1000"], start_new_session=own) for own in (False, True)]
numbers = Path(f"{name}.pids")
with numbers.open("a") as file:
    file.write("".join(f"{number}\n" for number in (os.getpid(), *(child.pid for child in children))))


def say(text: str) -> None:
    """Writes a line that is read at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


say(f"{name} runs")
order = Path(f"{name}.order")  # what to print, or a status to end with
while True:
    if order.exists():
        text = order.read_text()
        if not text:
            continue  # it has been made, and is not written yet
        order.unlink()
        if text.isdigit():
            sys.exit(int(text))
        say(text)
    time.sleep(0.01)
