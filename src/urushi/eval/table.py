"""The figures of an evaluation as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urushi.eval.groups import ROWS, Aim

if TYPE_CHECKING:
    from urushi.eval.report import Result

#: Columns of the errors. (The mean of P is left out: a few pairs in dark tails rule it.)
COLUMNS = [("E", "mean"), ("E", "median"), ("E", "p95"), ("E", "reference")]
COLUMNS += [("P", "median"), ("P", "p95"), ("P", "reference")]

#: A decoder of at most this many numbers is a `small` one, of which half as much is asked.
SMALL_DECODER = 2500


def text(result: Result) -> str:
    """The whole table: errors in percent, laws of physics, sizes and times."""
    slack = 2 if result.parameters.get("decoder", 0) <= SMALL_DECODER else 1
    aims = {row.name: row.aims for row in ROWS}
    width = max(map(len, [*result.rows, *(law.name for law in result.laws), *result.seconds]))
    heads = " ".join(f"{metric + ' ' + _SHORT.get(key, key):>8}" for metric, key in COLUMNS)
    title = f"networks {result.fingerprint}, reference: {result.reference}"
    lines = [title, "", f"{'errors [%]':<{width}} {'stacks':>6} {heads}  aims"]
    for name, row in result.rows.items():
        numbers = " ".join(f"{100 * row[metric][key]:8.2f}" for metric, key in COLUMNS)
        verdict = "; ".join(_aim(aim, row, slack) for aim in aims.get(name, ()))
        lines.append(f"{name:<{width}} {row['stacks']:>6} {numbers}  {verdict}".rstrip())
    lines += ["", "laws of physics"]
    for law in result.laws:
        lines.append(f"{law.name:<{width}} {law.value:>10.4g} {law.unit:<4} {_limit(law)}".rstrip())
    lines += ["", "parameters"]
    lines += [f"{name:<{width}} {count:>10,}" for name, count in result.parameters.items()]
    lines += ["", "times, on this machine now"]
    lines += [f"{name:<{width}} {_duration(value)}" for name, value in result.seconds.items()]
    return "\n".join(lines)


_SHORT = {"reference": "ref"}


def _aim(aim: Aim, row: dict[str, Any], slack: int) -> str:
    limit = slack * aim.limit
    verdict = "ok" if row[aim.metric][aim.statistic] <= limit else "MISSED"
    return f"{aim.metric} {aim.statistic} <= {100 * limit:g} {verdict}"


def _limit(law: Any) -> str:
    if law.limit is None:
        return ""
    return f"{'>' if law.lower else '<='} {law.limit:g} {'ok' if law.kept else 'BROKEN'}"


def _duration(seconds: float) -> str:
    return f"{seconds:>10.3g} s" if seconds >= 1 else f"{1000 * seconds:>10.3g} ms"
