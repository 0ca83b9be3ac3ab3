"""Tests, and what they start, see the installed package, which has the kernel, before the checkout's own."""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
sys.path[:] = [*(path for path in sys.path if Path(path or ".").resolve() != ROOT), str(ROOT)]
os.environ["PYTHONSAFEPATH"] = "1"
