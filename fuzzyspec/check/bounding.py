"""A floor of the strongest strength by branch and bound, for any norms: proved from below, seen from above.

Boxes of the input space are bounded with interval arithmetic over the degrees, in float64 with every rounding charged
to the lower bound, and split until the bound is near what was seen at their middles.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from fuzzyspec.check.degrees import points
from fuzzyspec.check.strength import Setters, Spot, strongest
from fuzzyspec.model.controller import And, Antecedent, Inference, Input, Is, Not, Or
from fuzzyspec.model.term import Shape

Floats = NDArray[np.float64]
Interval = tuple[Floats, Floats]

MOST_BOXES = 20_000
NEAR = 2.0**-12
"""A box whose bound comes this near to a strength that was seen is not split further."""

ROUNDING = 2.0**-44
"""More than the roundings of any one strength add up to: some hundred operations on values in [0, 1]."""


@dataclass(frozen=True)
class Bounded:
    """No strength lies below ``proved``; ``seen`` is the strength at ``spot``, exactly."""

    proved: Fraction
    seen: Fraction
    spot: Spot


def bounded_floor(setters: Setters, enough: Fraction, starts: tuple[Spot, ...]) -> Bounded:
    """Bound the strongest strength from below over the whole input range.

    Stops when the bound is tight, when the boxes are used up, or when a spot below ``enough`` was found. ``starts`` are
    spots worth looking at first.
    """
    lo = np.array([float(v.variable.lo) for v in setters.inputs])
    hi = np.array([float(v.variable.hi) for v in setters.inputs])
    used = np.array(setters.used)
    seen, spot = min(((strongest(setters, s), s) for s in starts), key=lambda pair: pair[0])
    cells = 1 if setters.cells is None else setters.cells.size
    batch = max(8, min(1024, 2_000_000 // (cells + 8 * len(setters.sentences))))

    boxes = np.stack([lo, hi])[None, :, :]
    bounds = _lower(setters, boxes)
    closed = 1.0
    spent = 0
    while len(boxes) and spent < MOST_BOXES and seen >= enough:
        open_ = bounds < float(seen) - NEAR
        if (~open_).any():
            closed = min(closed, float(bounds[~open_].min()))
        boxes, bounds = boxes[open_], bounds[open_]
        if not len(boxes):
            break
        order = np.argsort(bounds, kind="stable")
        now, later = order[:batch], order[batch:]
        halves = _split(setters, boxes[now], used)
        middles = halves.mean(axis=1)
        lowest = int(np.argmin(_values(setters, middles)))
        at = tuple(_inside(x, v) for x, v in zip(middles[lowest], setters.inputs, strict=True))
        place = Spot(at, (0,) * len(at))
        there = strongest(setters, place)
        if there < seen:
            seen, spot = there, place
        boxes = np.concatenate([boxes[later], halves])
        bounds = np.concatenate([bounds[later], _lower(setters, halves)])
        spent += len(halves)
    proved = min([closed, *bounds.tolist()])
    return Bounded(max(Fraction(0), min(Fraction(proved), seen)), seen, spot)


def _inside(x: float, variable: Input) -> Fraction:
    return min(max(Fraction(float(x)), variable.variable.lo), variable.variable.hi)


def _split(setters: Setters, boxes: Floats, used: NDArray[np.bool_]) -> Floats:
    """Each box in two, across the input whose degrees vary most in it."""
    variation = np.zeros((len(boxes), len(setters.inputs)))
    for i, variable in enumerate(setters.inputs):
        if used[i]:
            for term in variable.terms:
                low, high = _range(term.shape, boxes[:, 0, i], boxes[:, 1, i])
                variation[:, i] = np.maximum(variation[:, i], high - low)
    width = boxes[:, 1] - boxes[:, 0]
    # Among inputs that vary alike (every degree from 0 to 1, at first) the relatively wider one is split.
    score = np.where(used, variation + 1e-3 * width / (np.max(width, axis=0) + 1e-300), -1.0)
    axis = np.argmax(score, axis=1)
    rows = np.arange(len(boxes))
    middle = (boxes[rows, 0, axis] + boxes[rows, 1, axis]) / 2
    left, right = boxes.copy(), boxes.copy()
    left[rows, 1, axis] = middle
    right[rows, 0, axis] = middle
    return np.concatenate([left, right])


def _range(shape: Shape, lo: Floats, hi: Floats) -> Interval:
    """An enclosure of a term's degrees, limits at jumps included, over each of many intervals."""
    corners = points(shape)
    x = np.array([float(a) for a, _ in corners])
    y = np.array([float(b) for _, b in corners])
    # A corner's float is off by less than this, so it counts as inside an interval that it nearly touches; and a
    # degree between corners is off by that times the slope.
    slack = 2.0**-48 * max(1e-300, float(np.max(np.abs(np.concatenate([x, lo, hi])))))
    rises = np.diff(x) > 0
    slope = float(np.max(np.abs(np.diff(y)[rises] / np.diff(x)[rises]), initial=0.0))
    blur = min(1.0, slope * slack)
    ends = np.stack([_between(x, y, lo), _between(x, y, hi)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    for a, b in zip(x, y, strict=True):
        near = (lo - slack <= a) & (a <= hi + slack)
        low = np.where(near, np.minimum(low, b), low)
        high = np.where(near, np.maximum(high, b), high)
    return np.maximum(low - blur, 0.0), np.minimum(high + blur, 1.0)


def _between(x: Floats, y: Floats, at: Floats) -> Floats:
    """Linear interpolation; at a jump any of its values (its corners are looked at besides)."""
    return np.interp(at, x, y)


def _lower(setters: Setters, boxes: Floats) -> Floats:
    degrees = [
        [_range(term.shape, boxes[:, 0, i], boxes[:, 1, i]) for term in v.terms] for i, v in enumerate(setters.inputs)
    ]
    return _strongest(setters, degrees)[0] - ROUNDING


def _values(setters: Setters, at: Floats) -> Floats:
    degrees = []
    for i, v in enumerate(setters.inputs):
        ranges = [_range(term.shape, at[:, i], at[:, i]) for term in v.terms]
        degrees.append([((low + high) / 2, (low + high) / 2) for low, high in ranges])
    return _strongest(setters, degrees)[0]


def _strongest(setters: Setters, degrees: list[list[Interval]]) -> Interval:
    count = len(degrees[0][0][0])
    low, high = np.zeros(count), np.zeros(count)
    for rule in setters.sentences:
        a, b = _truth(rule.antecedent, degrees, setters.infer)
        low, high = np.maximum(low, float(rule.weight) * a), np.maximum(high, float(rule.weight) * b)
    if setters.cells is not None and setters.cells.any():
        # Cells only grow with the degrees, so the lower degrees bound them from below.
        found = np.broadcast_to(setters.cells.astype(np.float64), (count, *setters.cells.shape))
        for ds in reversed(degrees):
            lows = np.stack([d[0] for d in ds], axis=1)
            lows = lows.reshape(count, *(1,) * (found.ndim - 2), len(ds))
            found = (np.minimum(found, lows) if setters.infer.and_ == "min" else found * lows).max(axis=-1)
        low = np.maximum(low, found)
    return low, high


def _truth(antecedent: Antecedent, degrees: list[list[Interval]], infer: Inference) -> Interval:
    match antecedent:
        case Is(index, terms):
            return _join([degrees[index][t] for t in terms], infer)
        case Not(operand):
            low, high = _truth(operand, degrees, infer)
            return 1.0 - high, 1.0 - low
        case And(operands):
            return _meet([_truth(o, degrees, infer) for o in operands], infer)
        case Or(operands):
            return _join([_truth(o, degrees, infer) for o in operands], infer)
        case _:
            assert_never(antecedent)


def _meet(values: list[Interval], infer: Inference) -> Interval:
    low, high = values[0]
    for a, b in values[1:]:
        low, high = (np.minimum(low, a), np.minimum(high, b)) if infer.and_ == "min" else (low * a, high * b)
    return low, high


def _join(values: list[Interval], infer: Inference) -> Interval:
    low, high = values[0]
    for a, b in values[1:]:
        if infer.or_ == "max":
            low, high = np.maximum(low, a), np.maximum(high, b)
        else:
            low, high = low + a - low * a, high + b - high * b
    return low, high
