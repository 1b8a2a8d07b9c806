"""Pages of text in sections, from which scripts and code are made."""

from pathlib import Path


def sections(page: Path) -> dict[str, str]:
    """Return the sections of a page of text, each of which begins with a line "@@ name", by their names."""
    parts = page.read_text(encoding="utf-8").split("@@ ")[1:]
    return dict(part.split("\n", 1) for part in parts)
