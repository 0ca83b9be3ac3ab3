"""Tests see the installed package, which has the native kernel: the checkout's own comes after it, here and in
what tests start.
"""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
sys.path[:] = [*(path for path in sys.path if Path(path or ".").resolve() != ROOT), str(ROOT)]
os.environ["PYTHONSAFEPATH"] = "1"
