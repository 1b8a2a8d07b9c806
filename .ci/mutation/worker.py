"""A worker has a copy of the sources of its own; it is told mutants on its input, and says what became of each."""

import json
import sys
from dataclasses import asdict
from pathlib import Path

from trying import Trial, in_place, run, warm_up


class Worker:
    """A copy of the sources, and the tests that are known to pass on it."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._sound: set[str] = set()
        self._unsound: set[str] = set()

    def tried(self, path: Path, mutated: str, tests: list[str], usual: dict[str, float]) -> Trial:
        """Return what becomes of a mutant. A test that fails without one as well is not asked."""
        while True:
            asked = [test for test in tests if test not in self._unsound]
            with in_place(self.root / path, mutated):
                trial = run(self.root, asked, usual)
            self._sound.update(trial.tests)
            noticed = trial.by or (asked[0] if trial.outcome == "at import" else "")
            if not noticed or noticed in self._sound or self._passes(noticed):
                return trial
            if noticed in self._unsound:
                raise RuntimeError(f"{noticed} fails without a mutant")
            self._unsound.add(noticed)

    def _passes(self, test: str) -> bool:
        """Tell whether a test passes on the sources as they are."""
        if run(self.root, [test], {}).outcome == "survived":
            self._sound.add(test)
        return test in self._sound


def main() -> None:
    """Answer each line of the input by one of the output."""
    root = Path(sys.argv[1])
    warm_up()
    worker = Worker(root)
    for line in sys.stdin:
        told = json.loads(line)
        trial = worker.tried(Path(told["path"]), told["mutated"], told["tests"], told["usual"])
        print(json.dumps(asdict(trial)), flush=True)


if __name__ == "__main__":
    main()
