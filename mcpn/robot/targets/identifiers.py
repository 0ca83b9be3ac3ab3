"""Names of a mission as identifiers of other languages: escaped, never equal, never a keyword."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from keyword import kwlist, softkwlist

C_KEYWORDS = frozenset(
    word
    for line in (
        "auto break case char const continue default do double else enum extern float for goto if inline int",
        "long register restrict return short signed sizeof static struct switch typedef union unsigned void",
        "volatile while _Bool _Complex _Imaginary asm typeof bool true false NULL main errno and and_eq",
        "bitand bitor catch class compl const_cast constexpr decltype delete dynamic_cast explicit export",
        "friend mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public",
        "reinterpret_cast static_assert static_cast template this thread_local throw try typeid typename",
        "using virtual wchar_t xor xor_eq",
    )
    for word in line.split()
)
"""Of C99 and of C++, since headers are read by both."""

C_PREFIX_RESERVED = C_KEYWORDS | frozenset(
    word
    for line in (
        # The standard's headers: a file of their name would be read in their place.
        "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg",
        "stdbool stddef stdint stdio stdlib string tgmath time wchar wctype",
        # Before the names of the interface these give names that the templates use themselves.
        "action local move print",
    )
    for word in line.split()
)
"""What a mission's name must not become, which stands before each name of the interface in C."""

PYTHON_KEYWORDS = frozenset((*kwlist, *softkwlist))

C_SIGNIFICANT = 63
"""Characters that C99 promises to tell apart in an identifier (5.2.4.1)."""


def identifiers(
    names: Iterable[str],
    *,
    prefix: str = "",
    keywords: Collection[str] = (),
    taken: Iterable[str] = (),
    longest: int | None = None,
) -> dict[str, str]:
    """An identifier for each name, the same for the same names.

    What no identifier may hold becomes ``_``. Names that would then be equal, whatever the case of their
    letters, are numbered in their order; so are those equal to a keyword or to an identifier that is taken.

    Args:
        names: Any texts, each once.
        prefix: Put before each.
        keywords: What must not come out.
        taken: Identifiers that are in use.
        longest: How many characters an identifier may have; longer ones are cut.

    Returns:
        Identifiers by name, in the order of the names.
    """
    used = {text.lower() for text in (*keywords, *taken)}
    found: dict[str, str] = {}
    for name in names:
        whole = prefix + re.sub(r"[^A-Za-z0-9_]", "_", name)
        if not whole or whole[0].isdigit():
            whole = f"_{whole}" if prefix else f"x_{whole}"
        candidate, number = whole[:longest], 1
        while candidate.lower() in used:
            number += 1
            ending = f"_{number}"
            candidate = whole[: longest - len(ending) if longest else None] + ending
        used.add(candidate.lower())
        found[name] = candidate
    return found


def c_string(text: str) -> str:
    """A text as a C string literal of UTF-8 bytes, in which nothing can end it or start a trigraph."""
    parts = []
    for byte in text.encode("utf-8", "replace"):
        character = chr(byte)
        if character in '"\\?' or not 32 <= byte < 127:
            parts.append(f"\\{byte:03o}")
        else:
            parts.append(character)
    return '"' + "".join(parts) + '"'


def comment(text: str) -> str:
    """A text for one line of a comment, in which nothing can end the comment."""
    # Backslashes first, so that the slashes that stand for them end nothing either.
    return re.sub(r"[^\x20-\x7e]", "?", text).replace("\\", "/").replace("*/", "* /").replace("/*", "/ *")
