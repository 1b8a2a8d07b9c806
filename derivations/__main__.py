"""Run the derivations: ``python -m derivations [NAME] [--latex]``."""

import argparse
import sys

from derivations import CHAPTERS, chapter
from stickslip_sym import Status


def main() -> int:
    """List the chapters with their verdicts, or print the steps of one."""
    parser = argparse.ArgumentParser(prog="python -m derivations", description="Prove the paper's mathematics.")
    parser.add_argument("name", nargs="?", choices=CHAPTERS, help="a chapter; all are listed if none is given")
    parser.add_argument("--latex", action="store_true", help="print the steps as LaTeX")
    options = parser.parse_args()
    if options.name is not None:
        derivation = chapter(options.name)({})
        print(derivation.latex() if options.latex else derivation.text())
        return 0 if derivation.status is Status.PROVED else 1
    if options.latex:
        parser.error("--latex needs the name of a chapter")
    proved = True
    for name in CHAPTERS:
        derivation = chapter(name)({})
        proved &= derivation.status is Status.PROVED
        print(
            f"{name:18} {derivation.status.value:8} {len(derivation.steps):2} steps  {derivation.title}",
            flush=True,
        )
    return 0 if proved else 1


if __name__ == "__main__":
    sys.exit(main())
