"""`Study`: everything about one operating point, and the page that tells it."""

from functools import cached_property
from pathlib import Path

from stickslip_sym.comparison.study.findings import Findings
from stickslip_sym.comparison.study.sections import page
from stickslip_sym.output.browser import print_to_pdf
from stickslip_sym.output.files import write_text

__all__ = ["Study"]


class Study(Findings):
    """Everything about one operating point, and its page; `Findings` has the attributes."""

    @cached_property
    def page(self) -> str:
        """The page: HTML that is XML too, needs no script, and refers to nothing elsewhere.

        Raises
        ------
        InputError
            If matplotlib, which draws the figures, is not installed.
        """
        return page(self)

    def save(self, path: str | Path) -> Path:
        """Write the page to a file.

        Raises
        ------
        InputError
            If it cannot be written, or matplotlib is not installed.
        """
        target = Path(path)
        write_text(target, self.page)
        return target

    def print(self, path: str | Path) -> Path:
        """Print the page to a PDF file of A4 sheets, by a chromium that is on the path.

        Raises
        ------
        InputError
            If there is no browser, it cannot print, or the file cannot be written.
        """
        target = Path(path)
        print_to_pdf(self.page, target)
        return target

    def __repr__(self) -> str:
        return f"Study: {'; '.join(str(self).splitlines())}"
