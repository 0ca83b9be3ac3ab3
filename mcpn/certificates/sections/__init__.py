"""Claims about missions of many sections, which their types prove, and the checker of these."""

from __future__ import annotations
