"""Slips in a system with a list."""

from __future__ import annotations

from tests.breaking.slip import Slip

SYS = """\
module nav
controller danger {
    input  gap in [0, 4] m { partition NEAR FAR }
    output ddc in [0, 1]   { partition LOW HIGH }
    table ddc by gap { NEAR: HIGH  FAR: LOW }
}
system nav {
    param margin = 0.2 m
    input x in [0, 8] m
    input obstacles[16] {
        distance in [0, 8] m,
        speed    in [0, 2] m/s
    }
    for each o in obstacles {
        let o.gap = max(0 m, o.distance - margin)
        let o.ddc = danger(gap: o.gap).ddc
    }
    let worst = max(o.ddc for o in obstacles if o.distance < 3 m, otherwise 0)
    output y = worst
    output d = danger(gap: x).ddc
}
"""

SLIPS_IN_SYS: tuple[Slip, ...] = (
    ("kw_system", "FZ102 at 7:1", "system", "sytem"),
    ("kw_param", "FZ102 at 8:5", "param", "parm"),
    ("kw_let", "FZ102 at 18:5", "let worst", "lte worst"),
    ("kw_for", "FZ102 at 14:5", "for each", "foreach"),
    ("kw_for2", "FZ102 at 14:5", "for each", "fro each"),
    ("kw_each", "FZ102 at 14:9", "each", "eahc"),
    ("kw_for_fold", "FZ102 at 18:27", "for o", "fro o"),
    ("kw_if_fold", "FZ102 at 18:46", "if", "fi"),
    ("no_comma_fields", "FZ103 at 11:29", "8] m,", "8] m"),
    ("no_comma_otherwise", "FZ103 at 18:66", "m, otherwise", "m otherwise"),
    ("no_close_paren", "FZ105 at 15:24", "margin)", "margin"),
    ("no_close_bracket_list", "FZ105 at 10:20", "obstacles[16]", "obstacles[16"),
    ("no_equal_let", "FZ103 at 18:15", "= max(o.ddc", "max(o.ddc"),
    ("colon_for_equal", "FZ101 at 19:13", "y =", "y:"),
    ("arg_equal", "FZ103 at 20:27", "danger(gap: x).ddc", "danger(gap = x).ddc"),
    ("unit_mismatch_cmp", "FZ220 at 18:62", "3 m,", "3,"),
    ("unit_mismatch_cmp2", "FZ220 at 18:62", "m, otherwise", "s, otherwise"),
    ("name_in_system", "FZ201 at 15:43", "margin)", "marign)"),
    ("name_field", "FZ203 at 15:32", "o.distance -", "o.distanc -"),
    ("name_call", "FZ202 at 20:16", "danger(gap: x).ddc", "dangr(gap: x).ddc"),
    ("name_result", "FZ203 at 20:31", "x).ddc", "x).dcc"),
    ("name_arg", "FZ209 at 20:23", "danger(gap: x).ddc", "danger(gp: x).ddc"),
    ("name_list", "FZ201 at 18:36", "obstacles if", "obstacle if"),
    ("name_list_loop", "FZ201 at 14:19, FZ203 at 18:23", "obstacles {", "obstacle {"),
    ("name_input_c", "FZ211 at 9:11, FZ201 at 20:28", "x in", "switch in"),
    ("name_output_c", "FZ211 at 19:12", "y =", "long ="),
    ("name_twice_let", "FZ210 at 19:9", "worst =", "q = x\n    let q = x + q\n    output q2 = q\n    let worst ="),
    ("name_system_as_controller", "FZ202 at 20:16", "danger(gap: x).ddc", "nav(gap: x).ddc"),
    ("name_controller_as_value", "FZ201 at 19:16", "= worst", "= danger"),
    ("call_no_name", "FZ216 at 20:23", "danger(gap: x).ddc", "danger(x).ddc"),
    ("call_missing", "FZ214 at 20:16", "danger(gap: x).ddc", "danger().ddc"),
    ("call_twice", "FZ215 at 20:31", "x).ddc", "x, gap: x).ddc"),
    ("call_too_many", "FZ209 at 20:31", "x).ddc", "x, gop: x).ddc"),
    ("call_no_field", "FZ246 at 20:16", "x).ddc", "x)"),
    ("acting_without", "FZ245 at 20:36", "d =", "acting = danger(gap: x).acting\n    output d ="),
    ("list_0", "FZ406 at 10:21", "obstacles[16]", "obstacles[0]"),
    ("list_256", "FZ406 at 10:21", "obstacles[16]", "obstacles[256]"),
    ("list_15", "FZ406 at 10:21", "obstacles[16]", "obstacles[1.5]"),
    ("list_neg", "FZ406 at 10:21", "obstacles[16]", "obstacles[-1]"),
    ("list_empty", "FZ101 at 10:21", "obstacles[16]", "obstacles[]"),
    ("list_unit", "FZ220 at 10:21", "obstacles[16]", "obstacles[16 m]"),
    ("list_no_fields", "FZ101 at 10:26", "    distance in [0, 8] m,\n        speed    in [0, 2] m/s\n    }", "}"),
    ("list_input_kw", "FZ101 at 11:9", "distance in", "input distance in"),
    ("list_field_twice", "FZ210 at 12:9", "speed", "distance"),
    ("list_as_number", "FZ243 at 19:16", "= worst", "= obstacles.distance"),
    ("list_itself", "FZ243 at 19:16", "= worst", "= obstacles"),
    ("fold_no_otherwise", "FZ251 at 18:17", "m, otherwise 0)", "m)"),
    ("fold_mean", "FZ252 at 18:17", "max(o.ddc", "mean(o.ddc"),
    ("fold_where", "FZ101 at 18:46", "if", "where"),
    ("fold_number_cond", "FZ247 at 18:49", "o.distance < 3 m,", "o.distance,"),
    ("let_self", "FZ240 at 19:9", "output y", "let a = a + 1\n    output aa = a\n    output y"),
    (
        "let_later",
        "FZ241 at 18:13",
        "worst =",
        "a = b + 1\n    let b = x / 2 m\n    output aa = a\n    let worst =",
    ),
    ("param_input", "FZ248 at 19:15", "output y", "param q = x * 2\n    output qq = q\n    output y"),
    ("param_call", "FZ248 at 8:20", "0.2 m", "danger(gap: 3 m).ddc"),
    ("let_no_element", "FZ244 at 15:13, FZ203 at 16:35", "o.gap =", "gap ="),
    ("assign_no_let", "FZ103 at 18:5", "let worst", "worst"),
    ("div_signs", "FZ430 at 21:20", "output d =", "input z in [-1, 1]\n    output q = x / z\n    output d ="),
    ("div_zero_free", "FZ431 at 20:22", "d =", "q = 3 m / x\n    output d ="),
    ("div_zero_zero", "FZ432 at 20:28", "x).ddc", "x * 1 m / x).ddc"),
    ("div_literal", "FZ434 at 20:20", "d =", "q = x / 0\n    output d ="),
    ("div_const", "FZ434 at 8:29", "0.2 m", "0.2 m / (3 - 3)"),
    ("output_const", "FZ435 at 20:16", "d =", "q = 3 m\n    output d ="),
    ("cond_as_output", "FZ247 at 20:16", "d =", "q = x > 3 m\n    output d ="),
    ("cond_else_missing", "FZ103 at 20:28", "d =", "q = 1 if x > 3 m\n    output d ="),
    ("cond_cstyle", "FZ107 at 20:24", "d =", "q = x > 3 m ? 1 : 0\n    output d ="),
    ("assign_in_cond", "FZ101 at 20:23", "d =", "q = 1 if x = 3 m else 0\n    output d ="),
    ("clamp_two", "FZ217 at 20:16", "d =", "q = clamp(x, 3 m)\n    output d ="),
    ("system_in_controller_call_twice_dot", "FZ101 at 20:34", "x).ddc", "x).ddc.x"),
    ("controller_in_system", "FZ116 at 8:5", "param", "controller c { }\n    param"),
    ("input_with_terms_in_system", "FZ101 at 9:25", "x in [0, 8] m", "x in [0, 8] m { partition A B }"),
    ("output_no_value", "FZ101 at 19:13", "y = worst", "y"),
    ("system_no_output", "FZ232 at 7:8", "    output y = worst\n    output d = danger(gap: x).ddc\n}", "}"),
    ("power", "FZ107 at 19:21", "= worst", "= worst^2"),
    ("plus_sign", "FZ101 at 8:20", "0.2", "+0.2"),
    ("exponent", "FZ108 at 8:20", "0.2", "2e-1"),
    ("dot_number", "FZ108 at 8:20", "0.2", ".2"),
    ("hex", "FZ108 at 8:20", "0.2", "0x20"),
    ("huge_param", "FZ443 at 8:20", "0.2", "9999999999999999999999"),
    ("to_rad_of_m", "FZ223 at 20:23", "d =", "q = to_rad(x)\n    output d ="),
    ("unicode_name", "FZ115 at 9:11, FZ201 at 20:28", "x in", "größe in"),
    ("unicode_leq", "FZ107 at 18:60", "<", "≤"),
    ("fraction_char", "FZ107 at 8:20", "0.2", "½"),
    ("range_input_ref", "FZ201 at 10:17", "x in [0, 8]", "z in [0, 1] m\n input x in [0, z]"),
    ("otherwise_cond", "FZ247 at 18:77", "0)", "x > 3 m)"),
    ("cond_in_range", "FZ101 at 9:22", "x in [0, 8] m", "x in [0, 8 if 1 > 2 else 3] m"),
    ("nested_group", "FZ105 at 19:16", "= worst", "= (worst"),
    ("let_keyword_name", "FZ201 at 19:16", "worst =", "for ="),
    ("beh_in_system", "FZ116 at 8:5", "param", "behavior X priority 1 { }\n    param"),
    ("table_in_system", "FZ116 at 8:5", "param", "table a by b { }\n    param"),
    ("let_top", "FZ116 at 7:1", "system", "let x = 3\nsystem"),
    ("fold_no_for", "FZ101 at 18:30", "for o in", "in"),
    (
        "fold_bracket",
        "FZ101 at 18:20",
        "max(o.ddc for o in obstacles if o.distance < 3 m, otherwise 0)",
        "max[o.ddc for o in obstacles]",
    ),
    ("fold_otherwise_nocomma_val", "FZ103 at 18:67", "otherwise 0)", "0)"),
    ("fold_var_mismatch", "FZ201 at 18:21", "o in obstacles if o.distance", "p in obstacles if p.distance"),
    ("loop_var_list", "FZ201 at 14:27, FZ203 at 18:23", "o in obstacles {", "obstacles in o {"),
    ("loop_missing_in", "FZ103 at 14:16", "in obstacles {", "obstacles {"),
    ("loop_missing_each", "FZ103 at 14:9", "each o", "o"),
    ("loop_output", "FZ116 at 16:9", "let o.ddc", "output q = o.gap\n        let o.ddc"),
    ("loop_nested", "FZ116 at 16:9", "let o.ddc", "for each p in obstacles { let p.z = 3 }\n        let o.ddc"),
    ("call_unclosed", "FZ105 at 20:22", "x).ddc", "x.ddc"),
    ("call_result_missing", "FZ101 at 20:31", "x).ddc", "x)."),
    ("output_dot", "FZ101 at 19:18", "y =", "danger.y ="),
    ("system_calls_self", "FZ202 at 19:16", "= worst", "= nav(x: x).y"),
    ("input_number_name", "FZ101 at 9:11, FZ201 at 20:28", "x in", "2x in"),
    ("input_dash_name", "FZ101 at 9:16, FZ201 at 20:28", "x in", "front-left in"),
    ("input_dot_name", "FZ101 at 9:16, FZ201 at 20:28", "x in", "front.left in"),
    ("input_equals", "FZ101 at 9:13", "x in [0, 8] m", "x = [0, 8] m"),
    ("input_colon", "FZ101 at 9:12", "x in", "x:"),
    ("range_from_to", "FZ101 at 9:13", "x in [0, 8] m", "x from 0 to 8 m"),
    ("range_inf", "FZ201 at 9:20", "x in [0, 8] m", "x in [0, inf] m"),
    ("range_dotdot", "FZ101 at 9:16", "x in [0, 8] m", "x in 0..8 m"),
    ("unit_parens", "FZ101 at 9:23", "x in [0, 8] m", "x in [0, 8] (m)"),
    ("unit_quotes", "FZ107 at 9:23", "x in [0, 8] m", 'x in [0, 8] "m"'),
)
