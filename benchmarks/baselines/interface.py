"""What the baselines share: the interface of the generated header, and which controllers they can stand in for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyspec.emit.ctypes import signed
from fuzzyspec.emit.names import FunctionNames, Names, name_module
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import Port, Program
from fuzzyspec.model.controller import Controller

if TYPE_CHECKING:
    from jinja2 import Template

Files = Mapping[str, bytes]


class DoesNotFit(Exception):
    """A baseline that cannot stand in for a controller; the text says why."""


@dataclass(frozen=True, slots=True)
class InputC:
    """One input in C: its member, its type, and its legal raws as literals. ``saturated`` is its status bit's macro.

    ``below`` and ``above``: whether the type holds anything beyond the legal raws.
    """

    member: str
    name: str
    ctype: str
    lo: str
    hi: str
    saturated: str
    below: bool
    above: bool


@dataclass(frozen=True, slots=True)
class Interface:
    """The C names of one controller's function."""

    names: Names
    c: FunctionNames
    inputs: tuple[InputC, ...]


def interface_of(program: Program, controller: Controller) -> Interface:
    """How the generated C of a controller is called. DoesNotFit where it keeps a state."""
    function = program.function(controller.name)
    if function.state or function.nested:
        raise DoesNotFit("it keeps a state")
    names = name_module(program)
    c = names.functions[function.name]
    inputs = []
    for port in function.inputs:
        assert isinstance(port, Port), "a controller takes no lists"
        low, high = LIMITS[port.ctype]
        bit = c.bits.get(f"SATURATED_{port.name.upper()}", "")
        member = c.inputs[port.name]
        u = "" if signed(port.ctype) else "U"
        lo, hi = f"{port.lo}{u}", f"{port.hi}{u}"
        inputs.append(InputC(member, f"{member}_raw", f"{port.ctype}_t", lo, hi, bit, low < port.lo, high > port.hi))
    return Interface(names, c, tuple(inputs))


def require_cells(controller: Controller) -> tuple[tuple[int, ...], ...]:
    """The consequents by output and cell of a full table over partitions, where something always fires."""
    if controller.cells is None:
        raise DoesNotFit("its rules are sentences, not a table")
    if any(i.peaks is None for i in controller.inputs):
        raise DoesNotFit("an input is no partition")
    if not all(controller.always_fires):
        raise DoesNotFit("there are inputs at which nothing fires")
    if any(term < 0 for output in controller.cells.consequents for term in output):
        raise DoesNotFit("a cell leaves an output unset")
    return controller.cells.consequents


def alone(program: Program, controller: Controller) -> Program:
    """The program of this one function."""
    return replace(program, functions=(program.function(controller.name),))


def product_files(program: Program, generated: Files, source: str) -> dict[str, bytes]:
    """Another source under the generated header. There are no golden vectors: these are fuzzyc's."""
    names = name_module(program)
    vectors = f'#include "{names.header}"\n\nuint16_t {names.selftest}(void)\n{{\n    return 0U;\n}}\n'
    header = generated[names.header]
    return {names.header: header, names.source: source.encode(), names.selftest_source: vectors.encode()}


def template(name: str) -> Template:
    """A template of this folder."""
    return template_in(Path(__file__).parent, name)


@cache
def template_in(folder: Path, name: str) -> Template:
    """A template; what it does not find in its context is an error."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(folder),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(name)
