"""A results file that grows while it is measured."""

import json
from pathlib import Path

from harness import contest as contests


class Session:
    """The results so far; `save` writes them whole, so that an interruption loses one solve."""

    def __init__(self, target: Path, facts: dict, append: bool) -> None:
        earlier: dict = {}
        if append and target.exists():
            earlier = json.loads(target.read_text())["results"]
        self.target = target
        self.facts = facts
        self.contests: list[dict] = []  # of this run; their runs may still grow
        self.parts = {name: part for name, part in earlier.items() if name != "contests"}
        self.errors: dict[str, str] = {}
        self._earlier = earlier.get("contests", [])

    def save(self) -> bool:
        """Whether there was anything to write."""
        held = [contest for contest in self.contests if contest["runs"]]
        merged = append_contests(self._earlier, held)
        results = {**({"contests": merged} if merged else {}), **self.parts}
        if not results:
            return False
        self.target.parent.mkdir(parents=True, exist_ok=True)
        unfinished = self.target.with_suffix(".part")
        unfinished.write_text(
            json.dumps({"machine": self.facts, "results": results}, indent=1) + "\n"
        )
        unfinished.replace(self.target)
        return True


def append_contests(old: list[dict], new: list[dict]) -> list[dict]:
    """The contests of a results file with later ones: rounds of the same problem are joined."""
    merged = {contest["problem"]: contest for contest in old}
    for contest in new:
        earlier = merged.get(contest["problem"])
        joined = contest if earlier is None else contests.merge(earlier, contest)
        merged[contest["problem"]] = contests.summarize(joined)
    return list(merged.values())


def fresh_target(folder: Path, day: str) -> Path:
    """`<day>.json`, or `<day>-2.json` and so on: a run never writes over an earlier one's file."""
    target = folder / f"{day}.json"
    number = 2
    while target.exists():
        target = folder / f"{day}-{number}.json"
        number += 1
    return target
