"""All that one run found: what the page and the plot are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from benchmarks.own import Effort, Entry
from benchmarks.peers.task import PeerEntry
from benchmarks.speed import Speed
from benchmarks.workloads import Error
from fuzzyspec.cost import Record


@dataclass(frozen=True, slots=True)
class Setting:
    """The conditions. ``compilers`` by target; ``missing`` says by target why there is none; ``versions`` by tool."""

    effort: Effort
    compilers: Mapping[str, str]
    missing: Mapping[str, str]
    versions: Mapping[str, str]
    host: str


@dataclass(frozen=True, slots=True)
class Results:
    """Entries in the order of the workloads; kinds and libraries in their own within one."""

    setting: Setting
    own: tuple[Entry, ...]
    peers: tuple[PeerEntry, ...]
    speeds: tuple[Speed, ...]

    def entry(self, workload: str, kind: str) -> Entry | None:
        """What was found of one kind of C on one workload."""
        return next((e for e in self.own if (e.workload, e.kind) == (workload, kind)), None)


def as_json(results: Results) -> dict[str, Any]:
    """Everything, as JSON holds it."""
    return asdict(results)


def from_json(data: dict[str, Any]) -> Results:
    """What ``as_json`` gave."""
    setting = data["setting"]
    effort = Effort(**{**setting["effort"], "targets": tuple(setting["effort"]["targets"])})
    return Results(
        Setting(**{**setting, "effort": effort}),
        tuple(
            Entry(**{**e, "records": tuple(Record(**r) for r in e["records"]), "error": _error(e)}) for e in data["own"]
        ),
        tuple(PeerEntry(**{**p, "error": _error(p)}) for p in data["peers"]),
        tuple(Speed(**s) for s in data["speeds"]),
    )


def _error(entry: dict[str, Any]) -> Error | None:
    return None if entry["error"] is None else Error(**entry["error"])
