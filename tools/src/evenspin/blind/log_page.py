"""docs/blind-logs.md: the tables of a set of logs of other drives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from statistics import median

from evenspin.blind.bench_drives import BENCH
from evenspin.blind.log_score import SAYS, LogScore, goal_of, missed, shown, summary_of
from evenspin.blind.log_visible import SEEN
from evenspin.blind.score import percent

MADE = "<!-- Made by `make blind-logs`. Do not edit. -->\n\n# Verdicts on blind logs of other drives\n\n"
ABOUT = """The referee (sim_host/referee) is run under controllers that are not the log format's: current loops at 8, 16
and 20 kHz; speed from a PLL or from filtered differences; PI or IP; maximum torque per ampere on salient machines; with
and without feed-forward; an angle that comes late; encoders of 12 to 17 bits. A minute of speed steps, reversals and
slow turns, some with load. Files as other programs write them, without a map; the command is `evenspin gap FILE --model
M`. The unit differs from its model file by what benches differ by, drawn evenly:

"""
SHOWN = f"""
*Of the logs that show the effect*: the drive is simulated once more without it, and without noise; both go through the
equations of the machine with the recorded columns at their rate, whitened by what the noise of the log leaves there.
What a unit within the bounds above could do as well is taken off. The rest, in standard deviations (sigma), is what a
method could see at best that knew the delays and what is between the rows; a log shows an effect from {SEEN:.2g} sigma
on (a chi-square of 10), and a pair where it shows both. These rows have no goal of their own; the headline rows count
all logs.
"""
BINS = ((0.0, 0.5), (0.5, 0.8), (0.8, 0.9), (0.9, 0.95), (0.95, 1.01))


def page(scores: Sequence[LogScore], seeds: str) -> str:
    return MADE + ABOUT + _tolerances() + SHOWN + "\n" + tables(scores, seeds)


def _tolerances() -> str:
    return ", ".join(f"{key} {value:g}" for key, value in BENCH.items()) + ".\n"


def tables(scores: Sequence[LogScore], seeds: str) -> str:
    counts = Counter(s.truth.kind for s in scores)
    kinds = ", ".join(f"{counts[kind]} {kind}" for kind in ("single", "pair", "none", "outside"))
    with_v = sum(bool(s.truth.voltage) for s in scores)
    summary = summary_of(scores)
    late = missed(summary)
    lines = [f"{len(scores)} logs (seeds {seeds}): {kinds}; {with_v} with voltages.", ""]
    lines += ["| | found | goal | |", "|---|---|---|---|"]
    lines += [
        f"| {SAYS[name]} | {shown(name, value)} | {goal_of(name)} | {'missed' if name in late else ''} |"
        for name, value in summary.items()
    ]
    lines += ["", "By effect, one hidden:", "", "| hidden | logs | exactly right | said where it was not |"]
    lines += ["|---|---|---|---|"]
    for name in sorted({s.hidden[0] for s in scores if len(s.hidden) == 1}):
        own = [s for s in scores if s.hidden == (name,)]
        others: dict[str, list[LogScore]] = {}
        for score in own:
            if not score.exact:
                others.setdefault(_said(score), []).append(score)
        said = "; ".join(f"{what} ({_sizes(of)})" for what, of in others.items())
        lines.append(f"| {name} | {len(own)} | {sum(s.exact for s in own)} | {said} |")
    pairs = [s for s in scores if len(s.hidden) == 2]
    lines += _alike(scores)
    if pairs:
        lines += ["", "| hidden together | said |", "|---|---|"]
        lines += [
            f"| {' and '.join(s.hidden)} | {'right' if s.exact else f'{_said(s)} ({_sizes([s])})'} |" for s in pairs
        ]
    clean = Counter(_said(s) for s in scores if s.truth.kind == "none")
    lines += ["", "Nothing hidden, said: " + (", ".join(f"{what} ({n})" for what, n in clean.items()) or "-") + "."]
    lines += _shares("style of the file", scores, lambda s: s.truth.style)
    lines += _shares("rows per second", scores, lambda s: f"{s.truth.rate_hz:g}", key=lambda text: float(text))
    lines += _shares("voltages", scores, lambda s: s.truth.voltage or "none")
    lines += _shares("drive", scores, _drive_of)
    lines += _shares("size", [s for s in scores if s.truth.size], lambda s: s.truth.size)
    lines += _parameters(scores) + _calibration(scores)
    refused = Counter(s.run.message for s in scores if s.said is None and s.run is not None)
    if refused:
        lines += ["", "No verdict:", ""] + [f"* {n} x {_plain(message)}" for message, n in refused.most_common()]
    return "\n".join(lines) + "\n"


def _sizes(scores: Sequence[LogScore]) -> str:
    """How many logs, and by how many standard deviations each shows what is hidden."""
    known = [" and ".join(f"{size:.3g}" for size in s.truth.shown.values()) for s in scores if s.truth.shown]
    count = [f"{len(scores)} logs"] if len(scores) > 1 else []
    return ": ".join(count + ([f"{', '.join(known)} sigma"] if known else [])) or "1"


def _alike(scores: Sequence[LogScore]) -> list[str]:
    """Logs in which another effect of some size would leave what noise leaves."""
    lines = [
        f"| {s.truth.style}, {s.truth.rate_hz:g} rows per second, {s.truth.voltage or 'no'} voltages | {effect}, "
        f"{s.truth.shown[effect]:.3g} | {', '.join(f'{other} {size:.2g}' for other, size in others.items())} | "
        f"{_said(s)} |"
        for s in scores
        for effect, others in s.truth.alike.items()
        if others
    ]
    head = ["", "| alike | hidden, sigma | what leaves less than that of noise, sigma | said |", "|---|---|---|---|"]
    return head + lines if lines else []


def _said(score: LogScore) -> str:
    return "(no verdict)" if score.said is None else ", ".join(score.said) or "none"


def _plain(message: str) -> str:
    return message.replace("|", "/")[:240] or "(stopped without a message)"


def _drive_of(score: LogScore) -> str:
    drive = score.truth.controller
    if drive["other.angle_delay_s"] > 0.0:
        return "late angle"
    if drive["other.most_torque_per_ampere"]:
        return "salient, maximum torque per ampere"
    return "PLL" if not drive["other.speed_by_difference"] else "differences"


def _shares(
    title: str,
    scores: Sequence[LogScore],
    of: Callable[[LogScore], str],
    key: Callable[[str], float] | None = None,
) -> list[str]:
    lines = ["", f"| {title} | logs | read | exactly right | with a wrong name |", "|---|---|---|---|---|"]
    groups: dict[str, list[LogScore]] = {}
    for score in scores:
        groups.setdefault(of(score), []).append(score)
    for name in sorted(groups, key=key) if key else sorted(groups):
        own = groups[name]
        read, exact, wrong = (
            sum(s.said is not None for s in own),
            sum(s.exact for s in own),
            sum(bool(s.wrong) for s in own),
        )
        lines.append(f"| {name} | {len(own)} | {read} | {exact} | {wrong} |")
    return lines


def _parameters(scores: Sequence[LogScore]) -> list[str]:
    errors: dict[str, list[float]] = {}
    held: dict[str, list[bool]] = {}
    for score in scores:
        for key, error in score.errors.items():
            errors.setdefault(key, []).append(error)
        for key, miss in score.misses:
            held.setdefault(key, []).append(miss <= 1.0)
    lines = ["", "| parameter | logs | median error | largest | intervals that hold it |", "|---|---|---|---|---|"]
    for key in sorted(errors.keys() | held.keys()):
        own, inside = errors.get(key, []), held.get(key, [])
        sizes = f"{percent(median(own))} | {percent(max(own))}" if own else "- | -"
        lines.append(f"| {key} | {len(own)} | {sizes} | {f'{sum(inside)} of {len(inside)}' if inside else '-'} |")
    return lines


def _calibration(scores: Sequence[LogScore]) -> list[str]:
    lines = ["", "| confidence | names | said | right |", "|---|---|---|---|"]
    for low, high in BINS:
        own = [(said, right) for s in scores for said, right in s.sure if low <= said < high]
        if own:
            said, right = (sum(column) / len(own) for column in zip(*own, strict=True))
            lines.append(f"| {low:g} to {min(high, 1.0):g} | {len(own)} | {percent(said)} | {percent(right)} |")
    return lines
