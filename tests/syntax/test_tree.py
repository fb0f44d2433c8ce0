"""Text to tree: the numbers are exact and the spans are those of the text."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from fractions import Fraction

import pytest

from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.syntax import parse, tree
from tests.syntax.specs import EVERYTHING


def read(text: str) -> tree.Module:
    """The tree of a text without errors."""
    module, found = parse(Source("spec.fz", text))
    assert found == ()
    return module


def expression(text: str) -> tree.Expr:
    """The tree of one expression."""
    (system,) = read(f"module m\nsystem s {{ let x = {text} }}").items
    assert isinstance(system, tree.SystemDecl)
    (let,) = system.items
    assert isinstance(let, tree.Let)
    return let.value


def shown(node: tree.Expr) -> str:
    """An expression with all its parentheses."""
    match node:
        case tree.Number(value, unit, _):
            return f"{value}" + "".join(f" {s}^{e}" for s, e in (unit.factors if unit else ()))
        case tree.Ref(parts, _):
            return ".".join(p.text for p in parts)
        case tree.Unary(_, operand, _):
            return f"(-{shown(operand)})"
        case tree.Binary(op, left, right, _):
            return f"({shown(left)} {op} {shown(right)})"
        case tree.Compare(operands, ops, _):
            return (
                "<"
                + " ".join([shown(operands[0]), *(f"{o} {shown(x)}" for o, x in zip(ops, operands[1:], strict=True))])
                + ">"
            )
        case tree.InRange(value, lo, hi, unit, _):
            return f"<{shown(value)} in {shown(lo)}..{shown(hi)}{'' if unit is None else ' ' + unit.factors[0][0]}>"
        case tree.Logic(op, operands, _):
            return f"{op}({', '.join(map(shown, operands))})"
        case tree.Conditional(test, then, other, _):
            return f"[{shown(test)} ? {shown(then)} : {shown(other)}]"
        case tree.Otherwise(value, fallback, _):
            return f"[{shown(value)} or else {shown(fallback)}]"
        case tree.Call(callee, arguments, field, _):
            inner = ", ".join((f"{a.name.text}=" if a.name else "") + shown(a.value) for a in arguments)
            return f"{callee.text}({inner})" + (f".{field.text}" if field else "")
        case tree.Fold(kind, body, item, over, test, fallback, _):
            given = f"{test and shown(test)}, {fallback and shown(fallback)}"
            return f"{kind.text}({shown(body)} | {item.text} in {over.text}, {given})"


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("a - b - c", "((a - b) - c)"),
        ("a + b * -c / 2", "(a + ((b * (-c)) / 2))"),
        ("a / (b * T) otherwise 6", "[(a / (b * T)) or else 6]"),
        ("3 m/s / 2", "(3 m^1 s^-1 / 2)"),
        ("3 m / s", "(3 m^1 / s)"),
        ("9.81 m/s^2", "981/100 m^1 s^-2"),
        ("50 % * 2 N*m", "(1/2 %^1 * 2 N^1 m^1)".replace("1/2", "50")),
        ("2/3", "(2 / 3)"),
        ("0.1", "1/10"),
        ("a if b > 0 else c if d else e", "[<b > 0> ? a : [d ? c : e]]"),
        ("-30 deg <= x < 30 deg", "<(-30 deg^1) <= x < 30 deg^1>"),
        ("a or b and not c or d", "or(a, and(b, not(c)), d)"),
        ("x in [-90, -30] deg and y not in [0, 1]", "and(<x in (-90)..(-30) deg>, not(<y in 0..1>))"),
        ("danger(eta_t: o.gap, eta_d: 2).ddc", "danger(eta_t=o.gap, eta_d=2).ddc"),
        ("max(0 m, a, b)", "max(0 m^1, a, b)"),
        ("max(o.d for o in obs if o.b > 0, otherwise 0)", "max(o.d | o in obs, <o.b > 0>, 0)"),
        ("count(o for o in obs)", "count(o | o in obs, None, None)"),
        ("otherwise + full", "(otherwise + full)"),
    ],
)  # fmt: skip
def test_expressions_bind_as_written(text: str, meaning: str) -> None:
    """Operators bind by the usual precedence, a unit's slash before a spaced one."""
    assert shown(expression(text)) == meaning


def test_every_node_spans_its_text() -> None:
    """Each span lies within its parent's, names are spelt at theirs, and statements begin with their keyword."""
    source = Source("all.fz", EVERYTHING)
    module, _ = parse(source)

    def visit(node: object, around: Span) -> int:
        if isinstance(node, tuple):
            return sum(visit(part, around) for part in node)
        if not is_dataclass(node) or isinstance(node, Span):
            return 0
        span = getattr(node, "span", around)
        assert around.start <= span.start < span.end <= around.end
        if isinstance(node, tree.Name):
            assert EVERYTHING[span.start : span.end] == node.text
        if isinstance(node, tree.Let | tree.Rule | tree.Table | tree.ForEach):
            assert EVERYTHING[span.start :].startswith(("let ", "if ", "table ", "for each "))
        return 1 + sum(visit(getattr(node, f.name), span) for f in fields(node))

    assert visit(module, Span(0, len(EVERYTHING))) > 300


def test_all_constructs_arrive() -> None:
    """The tree of a spec with every construct holds each of them with its parts."""
    module = read(EVERYTHING)
    unit, param, fan, drive = module.items
    assert isinstance(unit, tree.UnitDecl) and isinstance(param, tree.Param)
    assert isinstance(fan, tree.ControllerDecl) and isinstance(drive, tree.SystemDecl)
    error, rate, shared, duty, gear, fine, infer, fires, budget, rules, go, single, many = fan.items

    assert isinstance(error, tree.VariableDecl) and error.raw is not None and error.raw.step is not None
    assert isinstance(rate, tree.VariableDecl) and rate.raw is not None and rate.raw.counts is not None
    assert [shown(c) for c in rate.raw.counts] == ["4095", "0"]
    assert isinstance(shared, tree.VariableDecl) and [n.text for n in shared.names] == ["left", "right"]
    (partition,) = shared.members
    assert isinstance(partition, tree.Partition) and not partition.full
    assert [t.name.text for t in partition.terms] == ["full", "hold", "in"]
    assert isinstance(duty, tree.VariableDecl)
    full, hold = duty.members[-2:]
    assert isinstance(full, tree.TermDecl) and [shown(a) for a in full.arguments] == ["60", "0", "90", "1", "100", "1"]
    assert isinstance(hold, tree.OtherwiseClause) and hold.hold
    assert isinstance(gear, tree.VariableDecl) and isinstance(gear.members[0], tree.Singletons)
    assert isinstance(fine, tree.VariableDecl)
    assert isinstance(fine.members[0], tree.Partition) and fine.members[0].full
    assert isinstance(infer, tree.InferBlock)
    assert [(s.name.text, s.value.text) for s in infer.settings][:2] == [("and", "min"), ("or", "max")]
    assert isinstance(fires, tree.FiresAt) and shown(fires.value) == "(1 / 64)"

    assert isinstance(budget, tree.BudgetBlock)
    assert [(x.quantity.text, x.op.text, x.target and x.target.text) for x in budget.limits] == [
        ("flash", "<=", None),
        ("cycles", "<=", "cortex-m0plus"),
        ("ram", "<=", "avr"),
    ]

    assert isinstance(rules, tree.RulesBlock)
    first, second = rules.rules
    assert first.weight is not None and first.weight == tree.Number(Fraction(4, 5), None, first.weight.span)
    assert isinstance(first.condition, tree.Antecedent) and first.condition.op == "or"
    assert isinstance(second.condition, tree.Antecedent)
    left, right = second.condition.operands
    assert isinstance(left, tree.Is) and [t.text for t in left.terms] == ["full", "hold"] and not left.negated
    assert isinstance(right, tree.Is) and right.negated
    assert [(c.output.text, c.term.text) for c in second.consequents] == [("duty", "off"), ("gear", "LOW")]
    assert isinstance(go, tree.BehaviorDecl) and len(go.rules) == 1

    assert isinstance(single, tree.Table) and single.columns == ()
    assert [(r.labels[0].text, r.entries[0][0].text) for r in single.rows][2] == ("PB", "HIGH")
    assert isinstance(many, tree.Table) and [c.text for c in many.columns] == ["full", "hold", "in"]
    assert [n.text for n in many.rows[1].labels] == ["Z", "full"]
    assert [n.text for n in many.rows[1].entries[2]] == ["full", "HIGH"]

    kinds = [type(item) for item in drive.items]
    assert kinds == [tree.Param, *[tree.SystemInput] * 3, tree.ListInput, tree.ForEach, tree.Let, tree.Let,
                     tree.SystemOutput, tree.SystemOutput, tree.BudgetBlock, tree.BudgetBlock]  # fmt: skip
