"""Keys that several formats have."""

from __future__ import annotations

from mcpn.runtime.shapes import Nullable, Number, OneOf, String

ENGINES = ("auto", "explicit", "symbolic", "local", "pyeda")
ANSWERED = {
    "engine": OneOf("The engine that answered.", *ENGINES),
    "why": Nullable(String("Why it was chosen; null where it was named.")),
    "seconds": Number("How long it took.", least=0),
}
"""Which engine answered."""
OUTCOME = OneOf("How the mission has ended; null while it runs.", "success", "failure", "abort", None)
