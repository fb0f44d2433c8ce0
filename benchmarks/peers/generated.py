"""fuzzyc's own C on the host, measured as fuzzylite is: what a library is to be compared with there."""

from __future__ import annotations

import tempfile
from pathlib import Path

from benchmarks.baselines.interface import template_in
from benchmarks.peers.counted import instructions
from benchmarks.peers.task import PeerEntry
from benchmarks.speed import HOST, measure_native
from benchmarks.workloads import Workload, error_of, ranges_of
from fuzzyspec.emit.names import Names, name_module
from fuzzyspec.native import find_toolchain
from fuzzyspec.version import __version__

_COUNTED = 100


def measure_generated(workload: Workload, inputs: int) -> PeerEntry:
    """The C for the host: its error, time and instructions."""
    spec, name = workload.spec, workload.function
    raws = workload.cases(inputs)
    found, exact = spec.fixed(name, raws, raw=True), spec.exact(name, spec.dequantise(name, raws))
    return PeerEntry(
        workload.name,
        "fuzzyc",
        __version__,
        error_of(found.outputs, exact.outputs, ranges_of(workload)),
        inputs,
        1e9 / measure_native(workload, 10 * inputs),
        _counted(workload),
    )


def _counted(workload: Workload) -> float | None:
    """A program of its own, so that callgrind sees nothing of Python."""
    spec = workload.spec
    names = name_module(spec.lowered.program)
    files = spec.compile(HOST).files
    with tempfile.TemporaryDirectory(prefix="fuzzyc-") as folder:
        path = Path(folder).resolve()
        for file in (names.header, names.source):
            (path / file).write_bytes(files[file])
        (path / "host.c").write_text(_main(workload, names), encoding="utf-8", newline="\n")
        find_toolchain().build([path / "host.c", path / names.source], path / "host", ("-std=c99", "-O2"))
        total = instructions(["./host"], names.functions[workload.function].function, path)
    return None if total is None else total / _COUNTED


def _main(workload: Workload, names: Names) -> str:
    c = names.functions[workload.function]
    cases = workload.cases(_COUNTED)
    members = [f".{c.inputs[k]} = " for k in cases]
    rows = zip(*(v.tolist() for v in cases.values()), strict=True)
    return template_in(Path(__file__).parent, "host.c.j2").render(
        header=names.header,
        input_t=c.input_t,
        output_t=c.output_t,
        function=c.function,
        cases=[[f"{m}{v}" for m, v in zip(members, row, strict=True)] for row in rows],
    )
