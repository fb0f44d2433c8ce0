# ruff: noqa: E501, RUF001  (long replacements; letters that look like ours)
"""Slips in sentence rules and behaviors."""

from __future__ import annotations

from tests.breaking.slip import Slip

RULES = """\
module fan
controller fan {
    input  error in [-10, 10] K { partition N Z P }
    input  rate  in [-2, 2] K/s { partition DOWN FLAT UP }
    output duty  in [0, 100] %  { partition OFF HALF ON otherwise 0 % }
    rules {
        if error is N then duty is OFF
        if error is Z and rate is not UP then duty is HALF with 0.8
        if error is P or rate is UP then duty is ON
    }
}
"""

BEH = """\
module bot
controller drive {
    input  left, front in [0, 1] { partition S M B }
    output v in [0, 1] m/s { partition Z VS F }
    output w in [-1, 1] rad/s { partition L C R }
    behavior AVOID priority 2 {
        if front is B then v is Z, w is R
        if front is M and left in {M, B} then v is VS, w is R
    }
    behavior GO priority 1 {
        if front in {S, M} then v is F, w is C
    }
}
"""

SLIPS_IN_RULES: tuple[Slip, ...] = (
    ("kw_rules", "FZ102 at 6:5", "rules", "rule"),
    ("kw_if", "FZ102 at 8:9", "if error is Z", "when error is Z"),
    ("kw_if2", "FZ102 at 8:9", "if error is Z", "fi error is Z"),
    ("kw_then", "FZ102 at 7:23", "then duty is OFF", "than duty is OFF"),
    ("kw_is", "FZ101 at 7:18", "is N", "= N"),
    ("kw_is_consequent", "FZ101 at 7:33", "is OFF", "= OFF"),
    ("kw_with", "FZ102 at 8:60", "with", "wiht"),
    ("kw_or", "FZ102 at 9:23", "or rate", "ro rate"),
    ("kw_and", "FZ102 at 8:23", "and", "adn"),
    ("kw_not", "FZ102 at 8:35", "not", "nto"),
    ("kw_otherwise", "FZ102 at 5:57", "otherwise", "otherwize"),
    ("no_then", "FZ103 at 7:23", "then duty is OFF", "duty is OFF"),
    ("name_term", "FZ313 at 8:21", "Z and", "ZZ and"),
    ("name_input", "FZ311 at 8:12", "error is Z", "eror is Z"),
    ("name_output", "FZ312 at 8:47", "duty is HALF", "duti is HALF"),
    ("name_term_out", "FZ313 at 8:55", "HALF with", "HALV with"),
    ("name_term_case", "FZ313 at 8:21", "Z and", "z and"),
    ("rule_weight_0", "FZ321 at 8:65", "0.8", "0"),
    ("rule_weight_12", "FZ321 at 8:65", "0.8", "1.2"),
    ("rule_weight_neg", "FZ321 at 8:65", "0.8", "-1"),
    ("rule_weight_unit", "FZ220 at 8:65", "0.8", "0.8 m"),
    ("rule_output_cond", "FZ311 at 7:12", "error is N", "duty is OFF"),
    ("rule_input_conseq", "FZ312 at 7:28", "duty is OFF", "rate is UP"),
    ("rule_else", "FZ101 at 7:40", "is OFF", "is OFF else duty is ON"),
    ("rule_compare", "FZ101 at 7:18", "is N", "> 3"),
    (
        "rules_empty",
        "FZ323 at 5:12",
        "    if error is N then duty is OFF\n        if error is Z and rate is not UP then duty is HALF with 0.8\n        if error is P or rate is UP then duty is ON\n    }",
        "}",
    ),
    ("fires_0", "FZ423 at 6:14", "rules", "fires at 0\n    rules"),
    ("fires_2", "FZ423 at 6:14", "rules", "fires at 2\n    rules"),
    ("fires_neg", "FZ423 at 6:14", "rules", "fires at -1/64\n    rules"),
    ("fires_nothing", "FZ103 at 6:11", "rules", "fires 1/64\n    rules"),
    ("fires_twice", "FZ210 at 7:5", "rules", "fires at 1/64\n    fires at 1/32\n    rules"),
    ("infer_unknown", "FZ207 at 6:13", "rules", "infer { nand = min }\n    rules"),
    ("infer_unknown_val", "FZ207 at 6:19", "rules", "infer { and = mean }\n    rules"),
    ("infer_twice", "FZ210 at 6:24", "rules", "infer { and = min, and = product }\n    rules"),
    ("infer_wavg_shapes", "FZ421 at 5:12", "rules", "infer { defuzzify = weighted_average }\n    rules"),
    (
        "term_outside",
        "FZ410 at 3:35",
        "partition N Z P",
        "term N = triangle(11, 12, 13) term Z = triangle(-10, 0, 10) term P = triangle(0, 10, 20)",
    ),
    (
        "term_tri_same",
        "FZ414 at 3:80",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = triangle(1, 1, 1) term P = ramp_up(0, 10)",
    ),
    (
        "term_tri_falls",
        "FZ414 at 3:80",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = triangle(5, 0, -5) term P = ramp_up(0, 10)",
    ),
    (
        "term_tri_two",
        "FZ217 at 3:62",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = triangle(0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_shape",
        "FZ206 at 3:71",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = gauss(0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_one",
        "FZ217 at 3:62",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points((0, 1)) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_high",
        "FZ415 at 3:90",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points((0, 0), (1, 1.5), (2, 0)) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_neg",
        "FZ415 at 3:90",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points((0, 0), (1, -1), (2, 0)) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_all0",
        "FZ410 at 3:62",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points((-3, 0), (2, 0)) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_flat",
        "FZ101 at 3:78",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points(0, 0, 1, 1) term P = ramp_up(0, 10)",
    ),
    (
        "term_points_unsorted",
        "FZ415 at 3:95",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = points((0, 0), (5, 1), (3, 0)) term P = ramp_up(0, 10)",
    ),
    ("term_singleton_input", "FZ416 at 3:35", "partition N", "singletons N"),
    ("term_mixed", "FZ416 at 5:62", "otherwise", "term MORE = singleton(3) otherwise"),
    ("part_one", "FZ417 at 3:35, FZ313 at 8:21, FZ313 at 9:21", "Z P }", "}"),
    ("part_commas", "FZ101 at 3:46", "N Z", "N, Z,"),
    ("part_half_placed", "FZ103 at 3:56", "Z P", "at -10, Z, P at 10"),
    ("part_reversed", "FZ412 at 3:63", "Z P", "at -10, Z at 5, P at 0"),
    ("part_equal", "FZ412 at 3:63", "Z P", "at -10, Z at 5, P at 5"),
    ("part_outside", "FZ411 at 3:68", "Z P", "at -10, Z at 5, P at 50"),
    ("part_full_input", "FZ413 at 3:35", "Z P }", "Z P full }"),
    ("part_full_inner", "FZ413 at 5:45", "HALF ON", "at 10, HALF at 50, ON at 100 full"),
    ("part_two", "FZ419 at 3:49", "Z P }", "Z partition P Q }"),
    ("otherwise_outside", "FZ422 at 5:67", "0 %", "200 %"),
    ("otherwise_unit", "FZ220 at 5:67", "0 %", "3 m"),
    ("otherwise_twice", "FZ210 at 5:71", "% }", "% otherwise 5 % }"),
    ("otherwise_input", "FZ424 at 3:51", "Z P }", "Z P otherwise 0 }"),
    ("no_terms", "FZ233 at 3:12", "partition N Z P }", "}"),
    ("no_terms_braces", "FZ101 at 3:32", "K { partition N Z P }", "K"),
    ("cyrillic_term", "FZ115 at 8:55", "HALF with", "НALF with"),
    ("rule_is_two", "FZ101 at 7:23", "then duty is OFF", "P then duty is OFF"),
    ("rule_is_or", "FZ103 at 7:28", "then duty is OFF", "or P then duty is OFF"),
    ("rule_term_number", "FZ101 at 7:21", "N then", "5 then"),
    ("rule_is_very", "FZ101 at 7:26", "N then", "very N then"),
    ("rule_parens", "FZ105 at 9:12", "error is P", "(error is P"),
    ("rule_parens2", "FZ106 at 9:36", "UP then duty is ON", "UP) then duty is ON"),
    ("rule_weight_brackets", "FZ101 at 8:60", "with 0.8", "[0.8]"),
    ("rule_numbered", "FZ101 at 7:9", "if error is N", "1: if error is N"),
    ("rule_named", "FZ101 at 7:9", "if error is N", "rule1: if error is N"),
    ("rule_colon", "FZ101 at 7:21", "N then", "N:"),
    (
        "term_eq_missing",
        "FZ103 at 3:42",
        "partition N Z P",
        "term N ramp_down(-10, 0) term Z = triangle(-5, 0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_brackets",
        "FZ101 at 3:53",
        "partition N Z P",
        "term N = ramp_down[-10, 0] term Z = triangle(-5, 0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_no_kw",
        "FZ103 at 3:35, FZ103 at 3:57, FZ103 at 3:80",
        "partition N Z P",
        "N = ramp_down(-10, 0) Z = triangle(-5, 0, 5) P = ramp_up(0, 10)",
    ),
    (
        "term_colon",
        "FZ101 at 3:41",
        "partition N Z P",
        "term N: ramp_down(-10, 0) term Z = triangle(-5, 0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_case",
        "FZ206 at 3:44",
        "partition N Z P",
        "term N = Ramp_Down(-10, 0) term Z = triangle(-5, 0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_ramp_rev",
        "FZ414 at 3:54",
        "partition N Z P",
        "term N = ramp_down(0, -10) term Z = triangle(-5, 0, 5) term P = ramp_up(0, 10)",
    ),
    (
        "term_trapezoid_fall",
        "FZ414 at 3:81",
        "partition N Z P",
        "term N = ramp_down(-10, 0) term Z = trapezoid(-5, 3, 0, 5) term P = ramp_up(0, 10)",
    ),
    ("singletons_twice", "FZ210 at 5:50, FZ313 at 8:55", "partition OFF HALF", "singletons OFF OFF"),
    ("singletons_one", "FZ417 at 5:35, FZ313 at 8:55, FZ313 at 9:50", "partition OFF HALF ON", "singletons OFF"),
    (
        "singletons_outside",
        "FZ411 at 5:53, FZ411 at 5:75",
        "partition OFF HALF ON",
        "singletons OFF at -5, HALF at 50, ON at 200",
    ),
    (
        "singletons_centroid",
        "FZ421 at 5:12",
        "partition OFF HALF ON otherwise 0 %",
        "singletons OFF HALF ON otherwise 0 % }\n    infer { defuzzify = centroid",
    ),
)

SLIPS_IN_BEH: tuple[Slip, ...] = (
    ("kw_behavior", "FZ102 at 6:5", "behavior AVOID", "behaviour AVOID"),
    ("kw_priority", "FZ102 at 6:20", "priority 2", "prio 2"),
    ("no_comma_inputs", "FZ103 at 3:17", "left,", "left"),
    ("no_comma_consequents", "FZ103 at 7:35", "Z,", "Z"),
    ("no_comma_set", "FZ103 at 8:38", "{M,", "{M"),
    ("trailing_comma_inputs", "FZ101 at 3:25", "front in [0,", "front, in [0,"),
    ("trailing_comma_set", "FZ101 at 8:41", "B}", "B,}"),
    ("unit_deg_rad", "FZ220 at 5:48", "C R", "at -1 deg, C at 0, R at 1"),
    ("beh_equal", "FZ304 at 10:14", "1 {", "2 {"),
    ("beh_or", "FZ308 at 8:12", "and", "or"),
    ("beh_not_group", "FZ308 at 8:12", "front is M and left in {M, B}", "not (front is M and left in {M, B})"),
    ("beh_weight", "FZ309 at 11:53", "is C", "is C with 0.5"),
    ("beh_priority_float", "FZ326 at 6:29", "2", "2.5"),
    ("beh_twice", "FZ327 at 10:14", "GO", "AVOID"),
    ("beh_empty", "FZ328 at 10:14", "    if front in {S, M} then v is F, w is C\n    }", "}"),
    ("beh_no_priority", "FZ103 at 6:20", "priority 2 {", "{"),
    ("beh_unknown_in_set", "FZ313 at 8:39", "B}", "X}"),
    ("beh_same_set", "FZ314 at 8:39", "B}", "M}"),
    ("beh_contradiction", "FZ315 at 8:27", "left in {M, B}", "front is B"),
    (
        "beh_and_rules",
        "FZ310 at 10:5",
        "behavior GO",
        "rules { if front is S then v is F, w is C }\n    behavior GO",
    ),
    ("priority_huge", "FZ443 at 6:29", "2", "99999999999999999999999999999999999999"),
    ("priority_div0", "FZ434 at 6:31", "2", "1/0"),
    ("rule_and_consequent", "FZ101 at 7:35", "Z,", "Z and"),
    ("rule_in_brackets", "FZ101 at 8:35", "{M, B}", "[M, B]"),
    ("rule_in_parens", "FZ101 at 8:35", "{M, B}", "(M, B)"),
    ("beh_priority_missing_num", "FZ101 at 6:29", "2 {", "{"),
    ("beh_priority_name", "FZ201 at 6:29", "2", "high"),
    ("beh_priority_first", "FZ101 at 6:14", "AVOID priority 2", "priority 2 AVOID"),
)
