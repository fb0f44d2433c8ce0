"""Other people's libraries on the host: fuzzylite (C++), pyfuzzylite, scikit-fuzzy and simpful (Python).

Each module has ``measure(task)``, which raises ``Skipped`` where the library is not installed or has no way to say the
workload.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

from benchmarks.peers import fuzzylite, pyfuzzylite, simpful, skfuzzy
from benchmarks.peers.generated import measure_generated
from benchmarks.peers.task import PeerEntry, Skipped, Task, task_of

__all__ = ["PEERS", "PeerEntry", "Task", "measure_generated", "measure_peer", "task_of"]

PEERS = MappingProxyType(
    {
        "fuzzylite": fuzzylite.measure,
        "pyfuzzylite": pyfuzzylite.measure,
        "scikit-fuzzy, functions": skfuzzy.measure_functions,
        "scikit-fuzzy, control": skfuzzy.measure_control,
        "simpful": simpful.measure,
    }
)


def measure_peer(name: str, task: Task) -> PeerEntry:
    """One library on one workload; an entry that says why there is nothing where it cannot be."""
    measure: Callable[[Task], PeerEntry] = PEERS[name]
    try:
        return measure(task)
    except Skipped as reason:
        return PeerEntry(task.workload, name, left_out=str(reason))
