"""Which outcomes of the generated C's conditions Frama-C's EVA shows that no input, count or state brings up.

Every condition goes through a function of its own, which checks the other outcome. The analyser hands it all values
that the condition takes; a check that it finds to hold, or never comes to, is of an outcome that is not there.
That nothing wraps around or goes out of bounds before is proved elsewhere (``tests/prove``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.prove import eva
from fuzzyspec.prove.driver import print_driver
from tests.coverage.measured import Condition, Outcome

LABEL = "unreached_"


def impossible(
    program: Program,
    files: Mapping[str, bytes],
    outcomes: Sequence[Outcome],
    marked: Callable[[str, Sequence[Condition]], str],
    watch: str,
) -> list[Outcome]:
    """The outcomes that no input has. ``marked`` hands each condition to ``watch`` and its number."""
    names = name_module(program)
    source = marked(files[names.source].decode(), [o.condition for o in outcomes])
    watches = [
        f"static int {watch}{i}(int c) {{ /*@ check {LABEL}{i}: c {'==' if o.holds else '!='} 0; */ return c; }}"
        for i, o in enumerate(outcomes)
    ]
    with TemporaryDirectory(prefix="fuzzyc-") as created:
        folder = Path(created).resolve()
        for name, content in files.items():
            (folder / name).write_bytes(content)
        (folder / names.source).write_text("\n".join([*watches, source]), encoding="utf-8")
        (folder / "fuzzyc_driver.c").write_text(print_driver(program), encoding="utf-8")
        said = eva.reported(folder, [names.source, "fuzzyc_driver.c"], 32)
    left = {int(n) for n in re.findall(rf"'?{LABEL}(\d+)'? got (?:final )?status (?:unknown|invalid)", said)}
    return [o for i, o in enumerate(outcomes) if i not in left]
