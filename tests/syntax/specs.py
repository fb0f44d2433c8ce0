"""Specs that the syntax tests read."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "tests" / "fixtures"

SOUND = sorted([*FIXTURES.glob("ok_*.fz"), *(ROOT / "examples").glob("*.fz"), *(ROOT / "benchmarks").glob("*.fz")])
"""Files that hold no syntax error."""

EVERYTHING = """\
module all_forms                       # every construct of the language, once

unit tick = 0.012 rad
param top = 7 + 2/3

controller fan {
    input  error in [-10, 10] K raw int16 step 0.01 { partition NB at -10 K, Z at 0 K, PB at 10 K }
    input  rate  in [-2, 2] K/s raw uint16 4095..0 {
        term falling = ramp_down(-1, 0)  term steady = triangle(-1, 0, 1)  term rising = ramp_up(0, 1)
    }
    input  left, right in [0, 1] { partition full hold in }
    output duty  in [0, 100] % {
        term off = singleton(0)  term half = trapezoid(20, 40, 60, 80)
        term full = points((60, 0), (90, 1), (100, 1))  otherwise hold initial 0 %
    }
    output gear in [1, 5] { singletons LOW HIGH  otherwise 1 }
    output fine in [1, 5] raw int8 { partition A B full }
    infer { and = min, or = max, defuzzify = centroid, }
    fires at 1/64
    budget { flash <= 1 KiB, cycles <= 900 on cortex-m0plus, ram <= 0 B on avr, }
    rules {
        if error is PB or (rate is rising and not error is not NB) then duty is full with 0.8
        if left in {full, hold} and right not in {in} then duty is off, gear is LOW
    }
    behavior GO priority 2 { if error is Z then duty is half }
    table gear by error { NB: LOW  Z: HIGH  PB: HIGH }
    table duty, gear by error, left, right {
                     full     hold     in
        (NB, full):  off/LOW  off/LOW  half/HIGH
        (Z, full):   off/LOW  off/LOW  full/HIGH
    }
}

system drive {
    param T = 2 s
    input heading, course in [-180, 180] deg
    input speed in [0, 2] m/s^2 raw uint16
    input obstacles[16] {
        distance in [0, 8] m raw uint16 step 0.001,
        bearing  in [-180, 180] deg,
    }
    for each o in obstacles {
        let o.gap = max(0 m, o.distance - 0.2 m)
        let o.ddc = fan(error: o.gap / (speed * T) otherwise 6, rate: -o.gap).duty
    }
    let near = max(o.ddc for o in obstacles if o.bearing in [-90, -30] deg, otherwise 0)
    let many = count(o for o in obstacles if -30 deg <= o.bearing < 30 deg and not o.gap > 3 m or o.ddc not in [0, 1])
    output v in [0, 1] m/s raw int8 = near if many > 2 else clamp(abs(near), 0, 1) * 3 m/s - 2 m / 1 s
    output acting = near
    budget { stack <= 2 * 64 B }
    budget { instructions <= 9000 on rv32imc }
}
"""
