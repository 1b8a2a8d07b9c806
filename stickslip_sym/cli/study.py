"""``stickslip study``: everything about an operating point, as one page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import points, reading_of
from stickslip_sym.cli.fit import fit_file, laws_to_fit
from stickslip_sym.cli.options import Given, option
from stickslip_sym.cli.output import echo_all, show_progress
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.seconds import SECONDS_OF_PART

_PAGE, _PAGES = "study.html", (".html", ".htm", ".xhtml")


@options.command(
    options.AT, options.DAMPING,
    option("--fit", type=Path, metavar="FILE", help="Measured friction to fit LAW, or the catalogue, to."),
    options.file_option("--output", "-o", endings=_PAGES, help=f"The page ({_PAGE})."),
    options.file_option("--pdf", endings=(".pdf",), help="Print the page too, by chromium or chrome."),
    options.file_option(
        "--explore", endings=_PAGES[:2], help="A page with sliders, in place of the study's, or with -o beside it."
    ),
    options.time_limit_option(f"Seconds for each part ({SECONDS_OF_PART:.0f})."),
)  # fmt: skip
def run(given: Given) -> None:
    """Write one page on one operating point: law, thresholds, motions, uncertainty, margins, formulas.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -c "2.3(1)". Several --point files make a page
    each, with their names. --name is the title of the page. The page of --explore computes criteria and the motion
    in the browser, at what its sliders say.

    Example: stickslip study exponential -V 0.5 -c 2.3 -p mu_s=0.50+/-0.02 -o study.html --pdf study.pdf
    """
    from stickslip_sym.motion.margins.margins import carried_by
    from stickslip_sym.output.files import write_text
    from stickslip_sym.views.drawing import require_matplotlib
    from stickslip_sym.views.pages.browser import require_browser
    from stickslip_sym.views.pages.explorer import explorer
    from stickslip_sym.views.pages.render import require_templates

    require_templates()
    limit = given["time_limit"]
    name = given["name"]
    output = given["output"]
    pdf = given["pdf"]
    explore = given["explore"]
    if output is None and (explore is None or pdf is not None):
        output = options.read_file(_PAGE, "--output", endings=_PAGES)
    if output is not None:
        require_matplotlib()
    file = given["fit"]
    measured_file = given["from_csv"]
    if pdf is not None:
        require_browser()
    fits = None
    measured = None
    if file is None:
        at = points(given, c="0")
        given.reject_unused()
        if measured_file is not None:
            measured = ss.read_measurements(measured_file, **reading_of(given)).averaged()
    elif measured_file is not None:
        raise InputError("the measurements are given twice, by --fit and by --from-csv; give them once")
    else:
        laws = laws_to_fit([given["law"]] if given["law"] else (), given)
        at = points(given, c="0", law=laws[0])
        fits = fit_file(file, laws, given)
        at = [replace(point, law=fits.best.law) for point in at]
    stems = [point.file.stem for point in at if point.file is not None]
    if twice := sorted({stem for stem in stems if stems.count(stem) > 1}):
        raise InputError(f"several files of values are called {twice[0]!r}, as their pages would be; rename one")
    contents = []
    texts = []
    for point in at:
        suffix = ""
        if len(at) > 1 and point.file is not None:
            suffix = f"-{point.file.stem}"
        page, paper, sliders = (path and path.with_stem(path.stem + suffix) for path in (output, pdf, explore))
        osc = ss.Oscillator(**point.numbers)
        written = list[str]()
        contents.append({"operating_point": point, "page": page, "pdf": paper})
        if page is not None:
            with show_progress("study"):
                study = ss.study(
                    fits or point.law, osc, errors=point.texts, measured=measured, name=name,
                    defaults=(*point.typical, *point.defaults), time_limit=limit,
                )  # fmt: skip
            study.save(page)
            written += study.findings
            written.append(f"{page}: {len(study.page) / 1000:.0f} kB, in {study.seconds:.1f} s")
            contents[-1]["study"] = study
            if paper is not None:
                study.print(paper)
                written.append(f"{paper}: the same, printed")
        if sliders is not None:
            with show_progress("the page with sliders"):
                best = fits.best if fits is not None else None
                explored = explorer(
                    point.law if best is None else best.law.bind(**best.uncertain), osc, title=name or "",
                    errors=carried_by(osc, point.texts), measured=measured if best is None else best.measured,
                    time_limit=limit or SECONDS_OF_PART,
                )  # fmt: skip
            write_text(sliders, explored)
            written.append(f"{sliders}: {len(explored) / 1000:.0f} kB, with sliders")
            contents[-1]["explorer"] = sliders
        texts.append("\n".join([f"{point}\n", *written]))
    echo_all(given, contents, texts)
