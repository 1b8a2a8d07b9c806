"""Draw a sample of mutants, run for each the tests that may notice it, and report what became of them."""

import argparse
import compileall
import json
import os
import py_compile
import random
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from choosing import Covering
from covering import MUTATED, cover_all, text_of
from equivalents import Equivalents
from mutants import Mutant, mutants_of, sampled
from report import report


class Session:
    """What was tried before, kept line by line, so that a run can be ended and taken up at any time."""

    def __init__(self, path: Path, ground: str) -> None:
        self._path, self._ground = path, ground
        self._lock = threading.Lock()
        self.trials: dict[str, dict[str, object]] = {}
        for line in path.read_text().splitlines() if path.exists() else ():
            kept = json.loads(line)
            if kept.pop("ground") == ground:
                self.trials[str(kept.pop("name"))] = kept

    def keep(self, mutant: Mutant, trial: dict[str, object]) -> None:
        """Note what became of a mutant."""
        with self._lock:
            self.trials[mutant.name] = trial
            with self._path.open("a") as file:
                file.write(json.dumps({"name": mutant.name, "ground": self._ground, **trial}) + "\n")


def texts_of(tests: list[str]) -> dict[str, str]:
    """Return a fingerprint of each test: its name and its file's text."""
    files = {file: text_of([Path(file)]) for file in {test.partition("::")[0] for test in tests}}
    return {test: f"{test} {files[test.partition('::')[0]]}" for test in tests}


def drawn(sources: list[Path], seed: str, count: int, kept: Path) -> list[Mutant]:
    """Return the sample, as it was kept if it was drawn before."""
    if not kept.exists():
        everything = [mutant for path in sources for mutant in mutants_of(path)]
        sample = sampled(everything, seed, count)
        found = [asdict(mutant) | {"path": str(mutant.path)} for mutant in sample]
        kept.write_text(json.dumps({"all": len(everything), "sample": found}))
    known = json.loads(kept.read_text())
    print(f"{known['all']} mutants of {len(sources)} files; {len(known['sample'])} drawn with the seed {seed}")
    return [Mutant(**of | {"path": Path(of["path"])}) for of in known["sample"]]


def copied(place: Path, number: int) -> Path:
    """Return a copy of the folder we are in, compiled, for one worker."""
    root = place / f"worker{number}"
    shutil.copytree(".", root, ignore=shutil.ignore_patterns("__pycache__"))
    for folder in MUTATED:
        mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
        compileall.compile_dir(root / folder, quiet=1, invalidation_mode=mode)
    return root


def try_all(
    mutants: list[Mutant], covering: Covering, session: Session, *, place: Path, jobs: int, budget: float
) -> None:
    """Try every mutant for which some test was not run yet."""
    workers = threading.local()
    numbers = iter(range(jobs))
    equivalents = Equivalents()

    def begin() -> None:
        command = [sys.executable, str(Path(__file__).with_name("worker.py")), str(copied(place, next(numbers)))]
        workers.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def attempt(mutant: Mutant) -> None:
        before = session.trials.get(mutant.name)
        if (before and before["outcome"] != "survived") or equivalents.why(mutant):
            return
        texts = texts_of(covering.chosen(mutant, budget))
        passed = set(before["tests"]) if before else set()
        tests = [test for test, text in texts.items() if text not in passed]
        if before and not tests:
            return
        usual = {test: covering.seconds[test] for test in tests}
        told = {"path": str(mutant.path), "mutated": mutant.text, "tests": tests, "usual": usual}
        process = workers.process
        process.stdin.write(json.dumps(told) + "\n")
        process.stdin.flush()
        answer = process.stdout.readline()
        if not answer:
            raise RuntimeError(f"The worker ended at {mutant}")
        trial = json.loads(answer)
        trial["tests"] = sorted(passed | {texts.get(test, test) for test in trial["tests"]})
        trial["seconds"] += before["seconds"] if before else 0.0
        session.keep(mutant, trial)
        place_ = f"{mutant.path}:{mutant.line}"
        print(
            f"{len(session.trials)} {trial['outcome']} {place_} {trial['by']} {trial['seconds']:.1f} s", flush=True
        )

    with ThreadPoolExecutor(jobs, initializer=begin) as pool:
        for done in [pool.submit(attempt, mutant) for mutant in mutants]:
            done.result()


def main() -> None:
    """Do what the arguments ask, in a copy of the sources that is the folder we are in."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--session", type=Path, required=True)
    parser.add_argument("--place", type=Path, required=True)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--budget", type=float, default=60.0)
    parser.add_argument("--longest", type=float, default=30.0)
    parser.add_argument("--only-report", action="store_true")
    asked = parser.parse_args()
    sources = sorted(path for folder in MUTATED for path in Path(folder).rglob("*.py"))
    ground = text_of(sources)
    sample = drawn(sources, asked.seed, asked.count, asked.session / f"{ground}-{asked.seed}-{asked.count}.json")
    session = Session(asked.session / "trials.jsonl", ground)
    if not asked.only_report:
        covering = Covering(cover_all(asked.session / "covering", asked.jobs, asked.longest), sources)
        # Whoever ends a run early has seen a part of every folder.
        order = random.Random(asked.seed).sample(sample, len(sample))
        try_all(order, covering, session, place=asked.place, jobs=asked.jobs, budget=asked.budget)
    print(report(sample, session.trials))


if __name__ == "__main__":
    main()
