"""Random and aimed raws for the signals of one function."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.program import ListPort, Port
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.variable import RAW_LIMITS
from fuzzyspec.verify.points import Raws, Special, nearest_legal, special_raws
from fuzzyspec.verify.subject import Subject

LONGEST_COUNT = 255


@dataclass
class Draw:
    """Draws raws of any shape. The same seed and subject give the same raws on every machine."""

    subject: Subject
    seed: int
    random: np.random.Generator = field(init=False)
    specials: dict[str, Special] = field(init=False)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng([self.seed, zlib.crc32(self.subject.name.encode())])
        self.specials = special_raws(self.subject)

    # --- one signal ---------------------------------------------------------------------------

    def legal(self, key: str, shape: tuple[int, ...]) -> Raws:
        """Uniform over the legal raws."""
        port = self.subject.ports[key]
        return self.random.integers(port.lo, port.hi, shape, dtype=np.int64, endpoint=True)

    def anything(self, key: str, shape: tuple[int, ...]) -> Raws:
        """Uniform over the C type."""
        low, high = c_limits(self.subject.ports[key])
        return self.random.integers(low, high, shape, dtype=np.int64, endpoint=True)

    def main(self, key: str, shape: tuple[int, ...]) -> Raws:
        """Peaks, ends and half-ways."""
        return self.random.choice(self.specials[key].main, shape)

    def special(self, key: str, shape: tuple[int, ...]) -> Raws:
        """Around everything special."""
        return self.random.choice(self.specials[key].all, shape)

    def mixed(self, key: str, shape: tuple[int, ...]) -> Raws:
        """Half legal, a tenth anything, the rest special."""
        which = self.random.random(shape)
        chosen = np.where(which < 0.5, self.legal(key, shape), self.special(key, shape))
        chosen = np.where((which >= 0.5) & (which < 0.6), self.anything(key, shape), chosen)
        return np.asarray(np.where(which >= 0.85, self.main(key, shape), chosen), dtype=np.int64)

    def with_degree(self, key: str, degrees: npt.NDArray[np.float64]) -> Raws:
        """Raws at which some term has about the given degree, a raw off at random; mixed where no term slopes."""
        pieces = self.specials[key].inverse
        shape = degrees.shape
        if not pieces:
            return self.mixed(key, shape)
        x0, y0, x1, y1 = np.array(pieces).T[:, self.random.integers(0, len(pieces), shape)]
        position = x0 + (x1 - x0) * (degrees - y0) / (y1 - y0)
        port = self.subject.ports[key]
        assert port.variable is not None
        return nearest_legal(port.variable.raw, position + self.random.integers(-1, 2, shape))

    # --- whole cases --------------------------------------------------------------------------

    def case_of(self, n: int, width: int, how: str) -> dict[str, Raws]:
        """All signals but the counts, each drawn by the method named ``how``; lists with ``width`` elements."""
        found: dict[str, Raws] = {}
        for key in self.subject.ports:
            shape = (n, width) if "." in key else (n,)
            found[key] = getattr(self, how)(key, shape)
        return found

    def tied(self, n: int, width: int) -> dict[str, Raws]:
        """Cases whose inputs share a degree (or its complement): ties between rules."""
        fires = self.subject.model.fires_at if isinstance(self.subject.model, Controller) else 0
        shared = self.random.random(n)
        shared[: n // 2] = self.random.choice([0.0, 0.25, 0.5, 0.75, 1.0, float(fires)], n // 2)
        found: dict[str, Raws] = {}
        for key in self.subject.ports:
            degrees = shared if "." not in key else np.repeat(shared[:, None], width, axis=1)
            flipped = np.where(self.random.random(degrees.shape) < 0.5, degrees, 1.0 - degrees)
            found[key] = self.with_degree(key, flipped)
        return found

    def counts(self, n: int, listed: ListPort, most: int) -> Raws:
        """Counts up to ``most`` that the width can serve."""
        return self.random.integers(0, min(most, LONGEST_COUNT), n, dtype=np.int64, endpoint=True)

    def states(self, n: int) -> dict[str, Raws]:
        """Random legal states, a tenth of them at the ends."""
        found: dict[str, Raws] = {}
        for key, port in self.subject.state.items():
            values = self.random.integers(port.lo, port.hi, n, dtype=np.int64, endpoint=True)
            values[: n // 10] = self.random.choice([port.lo, port.hi, port.initial], n // 10)
            found[key] = values
        return found


def c_limits(port: Port) -> tuple[int, int]:
    """Smallest and largest value of the port's C type."""
    assert port.variable is not None
    return RAW_LIMITS[port.variable.raw.ctype]
