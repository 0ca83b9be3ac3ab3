"""What mkdocs needs to make one site of pages that lie in several folders of the checkout.

Links between pages are those of the checkout (``../papers/causes.md``), so that they work there as well; in
the site the pages of ``docs/`` stand at the top. A link to a file that is no page becomes its path.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
BESIDE = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "experiments/README.md", "papers/*.md")
"""Pages outside ``docs/``, by their place in the checkout and in the site."""

LINK = re.compile(r"\[([^\]]*)\]\(([^)#\s]*)(#[^)\s]*)?\)")


def on_files(files: Files, config: Any, **_: Any) -> Files:
    """Takes in the pages outside ``docs/``."""
    for pattern in BESIDE:
        for path in sorted(ROOT.glob(pattern)):
            name = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, files: Files, **_: Any) -> str:
    """Turns links between files of the checkout into links between pages."""
    place = page.file.src_uri
    outside = place in {
        path.relative_to(ROOT).as_posix() for pattern in BESIDE for path in ROOT.glob(pattern)
    }
    here = posixpath.dirname(place if outside else f"docs/{place}")
    there = posixpath.dirname(place)

    def linked(match: re.Match[str]) -> str:
        text, target, anchor = match[1], match[2], match[3] or ""
        if not target or "://" in target:
            return match[0]
        path = posixpath.normpath(posixpath.join(here, target))
        name = path.removeprefix("docs/")
        if files.get_file_from_path(name) is None:
            assert (ROOT / path).exists(), f"{place}: {target}"
            return text if text.strip("`") == path else f"{text} (`{path}`)"
        return f"[{text}]({posixpath.relpath(name, there or '.')}{anchor})"

    return LINK.sub(linked, markdown)
