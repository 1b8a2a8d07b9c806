"""The score by folder and by file, and the mutants that nothing noticed."""

from collections import Counter
from pathlib import Path

from equivalents import Equivalents
from mutants import Mutant

OUTCOMES = ("killed", "at import", "hangs", "equivalent", "survived", "not yet")
"""What may become of a mutant. All but the last two count for the tests."""


def table(title: str, groups: dict[str, Counter[str]]) -> str:
    """Return a table of counts with a row for each group."""
    width = max(map(len, [*groups, title, "all"]))
    total = sum(groups.values(), Counter[str]())
    rows = [f"{title:{width}}  " + "".join(f"{name:>12}" for name in OUTCOMES) + f"{'score':>9}"]
    for name, counts in [*sorted(groups.items()), ("all", total)]:
        tried = counts.total() - counts["not yet"]
        score = f"{1 - counts['survived'] / tried:9.0%}" if tried else f"{'-':>9}"
        rows.append(f"{name:{width}}  " + "".join(f"{counts[outcome]:12d}" for outcome in OUTCOMES) + score)
    return "\n".join(rows)


def report(mutants: list[Mutant], trials: dict[str, dict[str, object]]) -> str:
    """Return what became of the mutants."""
    equivalents = Equivalents()
    folders: dict[str, Counter[str]] = {}
    files: dict[str, Counter[str]] = {}
    survivors = []
    seconds = 0.0
    for mutant in mutants:
        trial = trials.get(mutant.name)
        outcome = str(trial["outcome"]) if trial else "not yet"
        if outcome in ("survived", "not yet") and equivalents.why(mutant):
            outcome = "equivalent"
        if outcome == "survived" and trial:
            before, after = mutant.change
            place = f"{mutant.path}:{mutant.line} {mutant.definition or 'module'}"
            passed = f"{len(trial['tests'])} tests pass, {trial['seconds']:.0f} s"
            survivors.append(f"{place} [{mutant.operator.partition('/')[2]}] {passed}\n  - {before}\n  + {after}")
        seconds += float(trial["seconds"]) if trial else 0.0
        folder = mutant.path.parent
        folders.setdefault(str(folder), Counter())[outcome] += 1
        files.setdefault(str(mutant.path), Counter())[outcome] += 1
    worst = {path: counts for path, counts in files.items() if counts["survived"]}
    parts = ["Survivors", "", *survivors, "", table("file with survivors", worst), "", table("folder", folders)]
    many = {folder for folder in map(Path, folders) if len({p for p in files if Path(p).parent == folder}) > 20}
    if many:
        parts += ["", table("file", files)]
    return "\n".join([*parts, "", f"{seconds / 60:.0f} CPU minutes"])
