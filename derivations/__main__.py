"""Run the derivations: ``python -m derivations [NAME] [--latex | --certificate]``."""

import argparse
import sys

from derivations import CHAPTERS, chapter
from stickslip_sym import InputError, Status
from stickslip_sym.certificates.derivations import certificate_of_derivation


def main() -> int:
    """List the chapters with their verdicts, or print the steps of one."""
    parser = argparse.ArgumentParser(prog="python -m derivations", description="Prove the paper's mathematics.")
    parser.add_argument("name", nargs="?", choices=CHAPTERS, help="a chapter; all are listed if none is given")
    parser.add_argument("--latex", action="store_true", help="print the steps as LaTeX")
    parser.add_argument("--certificate", action="store_true", help="print a proof that needs nothing but SymPy")
    options = parser.parse_args()
    if options.name is not None:
        derivation = chapter(options.name)({})
        if options.certificate:
            try:
                print(certificate_of_derivation(derivation), end="")
            except InputError as failure:
                parser.error(str(failure))
            return 0
        print(derivation.latex() if options.latex else derivation.text())
        return 0 if derivation.status is Status.PROVED else 1
    if options.latex or options.certificate:
        parser.error("--latex and --certificate need the name of a chapter")
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
