"""One clipped set in integers: its area and moment polynomials, proved at every clip height."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Const,
    Define,
    Function,
    Local,
    Port,
    Program,
    ReadPort,
    SetOutput,
    Stmt,
)
from fuzzyspec.fixed.run import run
from fuzzyspec.lower.clipped import ClippedSet
from fuzzyspec.lower.horner import Horner, fit
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope

SUM_LIMIT = 2**24 - 2**9
"""Area sums times their weights stay below 2**24, so that two hardware divisions make a quotient."""
MAX_DENOMINATOR = 64
"""References with a common denominator up to this are exact integer weights."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Scale:
    """``area`` is integer units per unit of relative area; moments are counted in ``area * weight_denominator``.

    ``exact`` tells whether the references are integer weights; otherwise they are Q16 and multiplied high.
    """

    area: Fraction
    weight_denominator: int
    exact: bool

    @property
    def largest_area(self) -> int:
        """What the union's area, and each sign's sum, stays below."""
        return SUM_LIMIT // self.weight_denominator if self.exact else SUM_LIMIT


def scale_of(forms: tuple[ClippedSet, ...]) -> Scale:
    """The finest scale that keeps an output's sums in their limits."""
    denominator = math.lcm(*(f.reference.denominator for f in forms))
    exact = denominator <= MAX_DENOMINATOR
    weight = denominator if exact else 1
    # A scale in which the first width is a power of two makes even partitions exact.
    unit = forms[0].pieces[0].width[0]
    for f in forms:
        ratio = f.pieces[0].width[0] / unit
        if ratio.denominator != 1 or ratio.numerator & (ratio.numerator - 1):
            unit = min(unit, f.pieces[0].width[0])
    total = max(sum((f.full_area for f in forms if f.sign == sign), Fraction(0)) for sign in (1, -1))
    exponent = 31
    while total / unit * 2**exponent * weight >= SUM_LIMIT - 2**13:
        exponent -= 1
    return Scale(Fraction(2) ** exponent / unit, weight, exact)


@dataclass(frozen=True)
class Evaluated:
    """A set's statements and results. ``key`` is the same for sets whose integers are the same at every height.

    ``area_error[c]`` and ``moment_error[c]`` bound |integer - closed form| at clip height c / 2**15.
    """

    steps: list[Stmt]
    area: Local
    moment: Local | None
    area_error: Floats
    moment_error: Floats
    key: object


@dataclass(frozen=True)
class IntegerPiece:
    """From clip height ``start`` (Q15): ``area`` and ``moment`` polynomials of ``c - start``."""

    start: int
    area: Horner
    moment: Horner | None


def integer_pieces(form: ClippedSet, scale: Scale) -> list[IntegerPiece]:
    """The set's polynomials in integers, re-expanded about the first height of each piece."""
    pieces: list[IntegerPiece] = []
    moments = scale.area * (scale.weight_denominator if scale.exact else 1)
    for i, p in enumerate(form.pieces):
        start = math.ceil(p.start * DEGREE_ONE)
        last = i == len(form.pieces) - 1
        end = math.floor(p.end * DEGREE_ONE) if last else math.ceil(p.end * DEGREE_ONE) - 1
        if end < start:
            continue
        c = Fraction(start, DEGREE_ONE)
        w0, w1 = p.width
        area = p.area + w0 * (c - p.start) + w1 * (c * c - p.start * p.start) / 2
        area_poly = (w0 + w1 * c, w1 / 2, Fraction(0))
        moment: Horner | None = None
        if form.moment_sign:
            v0, v1, v2 = p.first
            base = p.moment + v0 * (c - p.start) + v1 * (c**2 - p.start**2) / 2 + v2 * (c**3 - p.start**3) / 3
            poly = (v0 + v1 * c + v2 * c * c, (v1 + 2 * v2 * c) / 2, v2 / 3)
            moment = fit(base, poly, end - start, moments)
        pieces.append(IntegerPiece(start, fit(area, area_poly, end - start, scale.area), moment))
    return pieces


def evaluate(form: ClippedSet, scale: Scale, height: Local, scope: Scope, name: str) -> Evaluated:
    """Statements that evaluate one set at ``height``; both results are proved by running every height."""
    proved = _proved(form, scale)
    steps, area, moment = _draft(list(proved.pieces), proved.top, height, scope, name, proved.hi)
    key = (proved.pieces, proved.top)
    return Evaluated(steps, area, moment, proved.area_error, proved.moment_error, key)


@dataclass(frozen=True)
class _Proved:
    """A set's polynomials, the largest values that they take and how far they are off, at every height."""

    pieces: tuple[IntegerPiece, ...]
    top: int
    hi: tuple[int, int]
    area_error: Floats
    moment_error: Floats


@lru_cache(maxsize=512)
def _proved(form: ClippedSet, scale: Scale) -> _Proved:
    pieces = integer_pieces(form, scale)
    top = math.floor(form.height * DEGREE_ONE)
    height = Local("h", "uint16", 0, DEGREE_ONE)
    draft, area, moment = _draft(pieces, top, height, Scope(), "set", None)
    areas, moments = all_heights(draft, area, moment, height)
    exact_area, exact_moment = closed_form(form)
    unit = float(scale.area)
    moment_unit = unit * (scale.weight_denominator if scale.exact else 1)
    slack = 2.0**-44  # float64 evaluation of the closed form: under 2**8 roundings of values below 1
    area_error = np.abs(areas / unit - exact_area) + slack
    moment_error = (
        np.abs(moments / moment_unit - exact_moment) + slack if moment is not None else np.zeros_like(exact_area)
    )
    return _Proved(tuple(pieces), top, (int(areas.max()), int(moments.max())), area_error, moment_error)


def _draft(
    pieces: list[IntegerPiece], top: int, height: Local, scope: Scope, name: str, hi: tuple[int, int] | None
) -> tuple[list[Stmt], Local, Local | None]:
    loose = (2**32 - 1, 2**32 - 1) if hi is None else hi
    area = Local(scope.name(f"{name}_part"), "uint32", 0, loose[0])
    moment = Local(scope.name(f"{name}_turn"), "uint32", 0, loose[1]) if pieces[0].moment is not None else None
    body: list[Stmt] = []
    clipped = height
    if top < DEGREE_ONE:
        clipped = Local(scope.name(f"{name}_c"), "uint16", 0, top)
        body.append(Define(clipped, build.least(height, Const(top)), True))
    single = len(pieces) == 1
    if not single:
        body.append(Define(area, Const(0), False))
        if moment is not None:
            body.append(Define(moment, Const(0), False))
    chain: tuple[Stmt, ...] = ()
    for i in range(len(pieces) - 1, -1, -1):
        p = pieces[i]
        steps: list[Stmt] = []
        d = clipped
        if p.start:
            d = Local(scope.name(f"{name}_d"), "uint16", 0, p.area.length)
            steps.append(Define(d, build.sub_guarded(clipped, Const(p.start), p.area.length), True))
        elif not single:
            d = replace(clipped, hi=p.area.length)
        for poly, into in ((p.area, area), (p.moment, moment)):
            if poly is None or into is None:
                continue
            more, value = poly.steps(d, name if into is area else f"{name}_moment", scope)
            steps += more
            value = replace(value, hi=min(value.hi, into.hi)) if not isinstance(value, Const) else value
            steps.append(Define(into, value, True) if single else Assign(into, value))
        if not chain:
            chain = tuple(steps)
        else:
            chain = (Branch(build.compare("<", clipped, Const(pieces[i + 1].start)), tuple(steps), chain),)
    return body + list(chain), area, moment


def all_heights(
    body: list[Stmt], area: Local, moment: Local | None, height: Local
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Area and moment that statements over ``height`` give at every clip height: (2**15 + 1,) each."""
    outputs = [Port("area", "uint32", 0, build.UINT32_MAX, None), Port("moment", "uint32", 0, build.UINT32_MAX, None)]
    steps: list[Stmt] = [Define(height, ReadPort("c", "uint16", 0, DEGREE_ONE), True), *body, SetOutput("area", area)]
    if moment is not None:
        steps.append(SetOutput("moment", moment))
    port = Port("c", "uint16", 0, DEGREE_ONE, None)
    function = Function("heights", "controller", (port,), tuple(outputs), (), (), (), (), (), tuple(steps))
    result = run(Program("lemma", (function,)), "heights", {"c": np.arange(DEGREE_ONE + 1)})
    return result.outputs["area"], result.outputs["moment"]


def closed_form(form: ClippedSet) -> tuple[Floats, Floats]:
    """F and H at every clip height, in float64."""
    c = np.minimum(np.arange(DEGREE_ONE + 1) / DEGREE_ONE, float(form.height))
    area, moment = np.zeros_like(c), np.zeros_like(c)
    for p in form.pieces:
        a = float(p.start)
        inside = c >= a
        d = c - a
        w0, w1 = float(p.width[0] + p.width[1] * p.start), float(p.width[1])
        v = p.first
        v0 = float(v[0] + v[1] * p.start + v[2] * p.start * p.start)
        v1, v2 = float(v[1] + 2 * v[2] * p.start), float(v[2])
        area = np.where(inside, float(p.area) + d * (w0 + d * w1 / 2), area)
        moment = np.where(inside, float(p.moment) + d * (v0 + d * (v1 / 2 + d * v2 / 3)), moment)
    return area, moment
