"""``stickslip study``: everything about an operating point, as one page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.fit import fitted, laws_to_fit
from stickslip_sym.cli.options import Given, option
from stickslip_sym.cli.output import echo_all, in_options
from stickslip_sym.cli.reading import points, reading_of
from stickslip_sym.core.errors import InputError


@options.command(
    options.AT, options.DAMPING,
    option("--fit", type=Path, metavar="FILE", help="Measured friction to fit LAW, or the catalogue, to."),
    options.file_option(
        "--output", "-o", endings=(".html", ".htm", ".xhtml"), default="study.html", help="The page (study.html)."
    ),
    options.file_option("--pdf", endings=(".pdf",), help="Print the page too, by chromium or chrome."),
    options.time_limit("Seconds for each part (20)."),
)  # fmt: skip
def run(given: Given) -> None:
    """Write one page on one operating point: law, thresholds, motions, uncertainty, margins, formulas.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -c "2.3(1)". Several --point files make a page
    each, with their names. --name is the title of the page.

    Example: stickslip study exponential -V 0.5 -c 2.3 -p mu_s=0.50+/-0.02 -o study.html --pdf study.pdf
    """
    from stickslip_sym.output.browser import require_browser
    from stickslip_sym.output.drawing import require_matplotlib
    from stickslip_sym.output.page.render import require_templates

    require_matplotlib()
    require_templates()
    limit, output, pdf, name = given["time_limit"], given["output"], given["pdf"], given["name"]
    file, measured_file = given["fit"], given["from_csv"]
    if pdf is not None:
        require_browser()
    fits, measured = None, None
    if file is None:
        at = points(given, c="0")
        given.all_used()
        if measured_file is not None:
            measured = ss.read_measurements(measured_file, **reading_of(given)).averaged()
    elif measured_file is not None:
        raise InputError("the measurements are given twice, by --fit and by --from-csv; give them once")
    else:
        laws = laws_to_fit([given["law"]] if given["law"] else (), given)
        at = points(given, c="0", law=laws[0])
        fits = fitted(file, laws, given)
        at = [replace(one, law=fits.best.law) for one in at]
    stems = [one.file.stem for one in at if one.file is not None]
    if twice := sorted({stem for stem in stems if stems.count(stem) > 1}):
        raise InputError(f"several files of values are called {twice[0]!r}, as their pages would be; rename one")
    contents, texts = [], []
    for one in at:
        suffix = f"-{one.file.stem}" if len(at) > 1 and one.file is not None else ""
        page, paper = (path and path.with_stem(path.stem + suffix) for path in (output, pdf))
        found = ss.study(
            fits or one.law, ss.Oscillator(**one.numbers), errors=one.texts, measured=measured, name=name,
            defaults=(*one.typical, *one.defaults), time_limit=limit,
        )  # fmt: skip
        found.save(page)
        written = f"{page}: {len(found.page) / 1000:.0f} kB, in {found.seconds:.1f} s"
        if paper is not None:
            found.print(paper)
            written += f"\n{paper}: the same, printed"
        contents.append({"operating_point": one, "study": found, "page": page, "pdf": paper})
        texts.append("\n".join([f"{one}\n", *map(in_options, found.findings), written]))
    echo_all(given, contents, texts)
