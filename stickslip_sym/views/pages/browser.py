"""A page on paper, by a browser that is there already.

Chromium sets the page's own formulas, tables and drawings on sheets as its style says, so that what is printed is
what was looked at. matplotlib writes PDF too, but sets no tables and no MathML: the page would be made twice.
"""

import re
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.seconds import SECONDS_OF_PART
from stickslip_sym.output.files import write_text

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_OTHERWISE = "open the page in any browser, and print it to a file there"
_SMALL_LETTERS = 6.5  # points, of letters that are 8 as a rule; smaller ones are not read
_SHEET = re.compile(rb"/Type\s*/Page\b")
_SECONDS_FOR_PAGE = 3 * SECONDS_OF_PART  # as many as figures, formulas and tables may take; usually 2
_OPTIONS = (
    # The sandbox needs rights that containers do not give; the page has no script and refers to nothing.
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-sync", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--no-pdf-header-footer",
)  # fmt: skip


def find_browser() -> str | None:
    """Return the first browser on the path that prints without a window, or None."""
    return next(filter(None, map(shutil.which, _NAMES)), None)


def require_browser() -> str:
    """Return the browser that prints, or refuse where there is none."""
    browser = find_browser()
    if browser is None:
        raise InputError(f"a PDF needs chromium or chrome, and none is on the path; {_OTHERWISE}")
    return browser


def print_to_pdf(page: str, path: Path, *, sheets: int) -> None:
    """Print a page to a PDF file; what was there before stays if that fails.

    `sheets` are as many as it should take: it has small letters where it takes more.
    """
    content = _as_pdf(page)
    if len(_SHEET.findall(content)) > sheets:
        small = f"<style>@media print {{ html {{ font-size: {_SMALL_LETTERS}pt }} }}</style></head>"
        content = _as_pdf(page.replace("</head>", small, 1))
    write_text(path, content)


def _as_pdf(page: str) -> bytes:
    """Return a page as PDF."""
    browser = require_browser()
    with TemporaryDirectory() as folder:
        source = Path(folder, "page.html")
        printed = Path(folder, "page.pdf")
        source.write_text(page, encoding="utf-8")
        profile = f"--user-data-dir={Path(folder, 'profile')}"
        command = [browser, *_OPTIONS, profile, f"--print-to-pdf={printed}", source.as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, timeout=_SECONDS_FOR_PAGE, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InputError(f"{Path(browser).name} did not print: {error}; {_OTHERWISE}") from None
        content = printed.read_bytes() if printed.is_file() else b""
        if not content.startswith(b"%PDF"):
            raise InputError(f"{Path(browser).name} did not print, exit code {done.returncode}; {_OTHERWISE}")
    return content
