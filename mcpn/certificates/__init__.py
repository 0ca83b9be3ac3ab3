"""Certificates: claims about a mission with evidence that a small program checks.

:mod:`mcpn.certificates.writing` writes them; :mod:`mcpn.certificates.certcheck` checks them and imports
nothing but Python's standard library. The format is described in docs/certificates.md.
"""

from __future__ import annotations
