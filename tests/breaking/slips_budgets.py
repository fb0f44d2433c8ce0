"""Slips in what a call may cost."""

from __future__ import annotations

from tests.breaking.slip import Slip

BUDGET = """\
module pump
controller drive {
    input  level in [0, 1] { partition LOW HIGH }
    output flow  in [0, 1] { partition OFF ON full }
    table flow by level { LOW: ON  HIGH: OFF }
    budget { flash <= 64 KiB, cycles <= 90000 on cortex-m0plus }
}
system pump {
    input level in [0, 1]
    output flow = drive(level: level).flow
    budget { stack <= 900 B, instructions <= 90000 on rv32imc }
}
"""

SLIPS_IN_BUDGET: tuple[Slip, ...] = (
    ("kw_budget", "FZ102 at 6:5", "budget", "bugdet"),
    ("kw_budgets", "FZ102 at 6:5", "budget", "budgets"),
    ("kw_capitals", "FZ102 at 6:5", "budget", "Budget"),
    ("kw_on", "FZ102 at 6:47", "on cortex", "no cortex"),
    ("equals", "FZ101 at 6:20", "flash <=", "flash ="),
    ("colon", "FZ101 at 6:19", "flash <=", "flash:"),
    ("nothing", "FZ103 at 6:20", "flash <=", "flash"),
    ("less", "FZ265 at 6:20", "flash <=", "flash <"),
    ("at_least", "FZ265 at 6:20", "flash <=", "flash >="),
    ("two_commas", "FZ101 at 6:30", "KiB,", "KiB,,"),
    ("no_comma", "FZ103 at 6:30", "KiB,", "KiB"),
    ("no_on", "FZ103 at 6:30", "KiB,", "KiB avr,"),
    ("no_target", "FZ101 at 6:32", "KiB,", "KiB on,"),
    ("no_hyphen", "FZ103 at 6:57", "cortex-m0plus", "cortex m0plus"),
    ("no_brace", "FZ103 at 6:12", "budget {", "budget"),
    ("brackets", "FZ101 at 6:12", "budget {", "budget ("),
    ("empty", "FZ101 at 6:15", "flash <= 64 KiB, cycles <= 90000 on cortex-m0plus", ""),
    ("quantity", "FZ260 at 6:14", "flash", "rom"),
    ("speed", "FZ260 at 6:31", "cycles", "time"),
    ("target_cut", "FZ261 at 6:50", "m0plus", "m0"),
    ("target_printed", "FZ261 at 6:50", "m0plus", "m0+"),
    ("target_vendor", "FZ261 at 6:50", "cortex-m0plus", "atmega328p"),
    ("target_unknown", "FZ261 at 6:50", "cortex-m0plus", "xtensa"),
    ("kb", "FZ262 at 6:26", "KiB", "kb"),
    ("kelvin", "FZ262 at 6:26", "KiB", "K"),
    ("no_unit", "FZ262 at 6:23", "64 KiB", "65536"),
    ("count_with_unit", "FZ262 at 6:47", "90000 on", "90000 cycles on"),
    ("bytes_of_cycles", "FZ262 at 6:41", "90000 on", "2 * 8 B on"),
    ("twice", "FZ263 at 6:31", "cycles <= 90000 on cortex-m0plus", "flash <= 32 KiB"),
    ("no_model", "FZ264 at 6:50", "cortex-m0plus", "cortex-m4"),
    ("avr_instructions", "FZ264 at 11:55", "rv32imc", "avr"),
    ("zero", "FZ444 at 6:41", "90000", "0"),
    ("negative", "FZ444 at 11:23", "900 B", "-1 B"),
    ("not_constant", "FZ201 at 11:23", "900 B", "level * 1 B"),
    ("outside", "FZ116 at 8:1", "system pump", "budget { ram <= 0 B }\nsystem pump"),
)
