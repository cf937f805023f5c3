"""The pictures of a case: where the gap is, what was tried, how far it closed, what is left. Each with its numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.features import SIGNALS
from evenspin.gap.outcome import Trace
from evenspin.gap.result import CaseResult
from evenspin.gap.where import heat_map
from evenspin.log.gap import GAP_SIGNALS, GAP_UNITS
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg

Array = NDArray[np.float64]
BEFORE, AFTER, FLOOR = OTHER_COLOURS[1], OTHER_COLOURS[0], "#8c8c8c"
UNITS = dict(zip(GAP_SIGNALS, GAP_UNITS, strict=True))
SHORT = {"speed_rad_s": "speed", "id_a": "id", "iq_a": "iq", "vd_v": "vd", "vq_v": "vq"}
SIGMA_RANGE = (0.5, 100.0)
ZOOM_ROWS = 400
SHOWN_SIGNALS = 3
SHOWN_MODELS = 12


def gap_pictures(result: CaseResult) -> list[Picture]:
    """The gap as it was and as it is."""
    if not result.before.traces:
        return []
    with drawing():
        return [_bars(result)]


def where_pictures(result: CaseResult) -> list[Picture]:
    with drawing():
        return [_heat(result)]


def what_pictures(result: CaseResult) -> list[Picture]:
    with drawing():
        return [_explanations(result)]


def much_pictures(result: CaseResult) -> list[Picture]:
    if not result.before.traces:
        return []
    with drawing():
        pairs = zip(result.before.traces, result.after.traces, strict=True)
        return [_traces(before, after) for before, after in pairs]


def left_pictures(result: CaseResult) -> list[Picture]:
    with drawing():
        return [_left(result)]


def _heat(result: CaseResult) -> Picture:
    from matplotlib.colors import LogNorm

    heat = heat_map(result.subjects, result.residual_before, result.residual_after)
    names = [name for _, block in heat.blocks for name in block]
    figure, axes = subplots(2, 1, height=5.4, sharex=True)
    norm = LogNorm(*SIGMA_RANGE, clip=True)
    image: Any = None
    for panel, values, title in ((axes[0, 0], heat.before, "nominal machine"), (axes[1, 0], heat.after, "after")):
        image = panel.imshow(np.where(values > 0, values, np.nan), aspect="auto", norm=norm, cmap="YlOrRd")
        panel.set(title=title, yticks=range(len(SIGNALS)), yticklabels=[SHORT[s] for s in SIGNALS])
        panel.grid(False)
        edge = -0.5
        for block, columns in heat.blocks:
            if panel is axes[0, 0]:
                panel.text(edge + 0.5 * len(columns), -0.62, block, ha="center", va="bottom", fontsize=8)
            edge += len(columns)
            panel.axvline(edge, color="white", linewidth=3.0)
    axes[0, 0].set_title("nominal machine", pad=16)
    axes[1, 0].set_xticks(range(len(names)), names, rotation=55, ha="right", fontsize=7)
    bar = figure.colorbar(image, ax=list(axes[:, 0]), shrink=0.8, pad=0.01)
    bar.set_label("rms residual [sigma of healthy units]")
    data = {"column": np.arange(len(names), dtype=float)}
    for row, signal in enumerate(SIGNALS):
        data |= {f"{signal}_before_sigma": heat.before[row], f"{signal}_after_sigma": heat.after[row]}
    text = (
        "How far the log is from the model, per signal, in standard deviations of what healthy units scatter: one is "
        "noise. Blank: there is no feature. Fit records only. Columns in the file in this order: " + ", ".join(names)
    )
    return Picture("heat", "Where the gap is", text, to_svg(figure), data)


def _explanations(result: CaseResult) -> Picture:
    finding = result.finding
    sets, costs = zip(*tried_costs(result), strict=True)
    names = [words_of(each) for each in sets]
    figure, axes = subplots(height=max(1.9, 0.9 + 0.27 * len(names)))
    panel = axes[0, 0]
    chosen = frozenset(finding.model.names)
    colours = [AFTER if frozenset(each) == chosen else FLOOR for each in sets]
    panel.barh(range(len(names)), costs, color=colours, height=0.7)
    expected = finding.expected_cost
    low, high = expected.mean - 3.0 * expected.sigma, expected.mean + 3.0 * expected.sigma
    panel.axvspan(max(low, 1.0), high, color=OTHER_COLOURS[2], alpha=0.3, label="healthy units (3 sigma)")
    panel.set(xscale="log", yticks=range(len(names)), yticklabels=names, xlabel="cost of the residual (chi square)")
    panel.set_xlim(0.5 * min(*costs, expected.mean), None)
    panel.invert_yaxis()
    panel.grid(False, axis="y")
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper right")
    text = (
        "Every explanation that was refined with the simulation in the loop; the band is where a right model ends up."
    )
    return Picture("explanations", "What was tried", text, to_svg(figure), {"cost": np.array(costs)})


def tried_costs(result: CaseResult) -> list[tuple[tuple[str, ...], float]]:
    """Names and best cost of each set of effects, best first; the chosen one and nothing are always among them."""
    finding = result.finding
    nothing: frozenset[str] = frozenset()
    best: dict[frozenset[str], float] = {nothing: finding.before}
    names: dict[frozenset[str], tuple[str, ...]] = {nothing: ()}
    for model in (*finding.tried, finding.model):
        key = frozenset(model.names)
        names[key] = model.names
        best[key] = min(model.cost, best.get(key, math.inf)) if key else best[key]
    shown = sorted(best, key=lambda key: best[key])[:SHOWN_MODELS]
    shown += [key for key in (frozenset(finding.model.names), nothing) if key not in shown]
    return [(names[key], best[key]) for key in shown]


def words_of(names: tuple[str, ...]) -> str:
    """A set of effects as the report prints it."""
    return " + ".join(names) or "nothing"


def _bars(result: CaseResult) -> Picture:
    records = result.before.records
    figure, axes = subplots(1, len(records), height=3.2, sharey=False)
    data: dict[str, Any] = {}
    x = np.arange(len(GAP_SIGNALS) + 1)
    labels = [f"{SHORT[s]}\n[{unit:g} {UNITS[s]}]" for s, unit in GAP_SIGNALS.items()] + ["all"]
    sets = (("before", BEFORE, result.before.records), ("after", AFTER, result.after.records))
    for column, record in enumerate(records):
        panel = axes[0, column]
        for i, (name, colour, gaps) in enumerate((*sets, ("noise floor", FLOOR, result.noise_floor))):
            gap = gaps[column]
            values = np.array([gap.rms[s] / unit for s, unit in GAP_SIGNALS.items()] + [gap.gap])
            panel.bar(x + 0.27 * (i - 1), values, 0.25, color=colour, label=name)
            data[f"{record.record}_{name.replace(' ', '_')}"] = values
        panel.set(title=record.record, xticks=x, xticklabels=labels)
        panel.grid(False, axis="x")
    axes[0, 0].set_ylabel("rms difference [in the unit below]")
    axes[0, -1].legend()
    text = (
        "rms difference of simulation and log on records that nothing was fitted to; the noise floor cannot be closed."
    )
    return Picture("gap", "The gap on validation records", text, to_svg(figure), data)


def _traces(before: Trace, after: Trace) -> Picture:
    names = list(GAP_SIGNALS)
    rms = before.gap.rms
    order = sorted(range(len(names)), key=lambda i: -rms[names[i]] / GAP_SIGNALS[names[i]])[:SHOWN_SIGNALS]
    figure, axes = subplots(len(order), 2, height=1.7 * len(order) + 0.6, gridspec_kw={"width_ratios": (1.5, 1.0)})
    t_s = before.t_s
    start = _worst(before, order)
    zoom = slice(start, min(start + ZOOM_ROWS, len(t_s)))
    data: dict[str, Any] = {"t_s": t_s[zoom]}
    for row, i in enumerate(order):
        whole, near = axes[row, 0], axes[row, 1]
        for name, trace, colour in (("before", before, BEFORE), ("after", after, AFTER)):
            x, y = envelope(t_s, trace.simulated[:, i] - trace.measured[:, i])
            whole.plot(x, y, color=colour, linewidth=0.8, label=name)
        for name, values, style in (
            ("log", before.measured, {"color": REFERENCE_COLOUR, "linewidth": 1.4, "alpha": 0.6}),
            ("before", before.simulated, {"color": BEFORE}),
            ("after", after.simulated, {"color": AFTER}),
        ):
            near.plot(t_s[zoom], values[zoom, i], label=name, **style)
            data[f"{names[i]}_{name}"] = values[zoom, i]
        whole.set_ylabel(f"{SHORT[names[i]]} [{UNITS[names[i]]}]")
        whole.set_xlim(t_s[0], t_s[-1])
        near.set_xlim(t_s[zoom][0], t_s[zoom][-1])
    axes[0, 0].set_title("simulation less log")
    axes[0, 1].set_title("where it is largest before")
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside upper right", ncols=3)
    text = "The signals with the largest gap: the difference over the whole record, and a stretch of it with the log."
    return Picture(f"traces_{before.record}", f"Traces: {before.record}", text, to_svg(figure), data)


def _worst(trace: Trace, order: list[int]) -> int:
    """Row at which a stretch with the largest difference starts."""
    names = list(GAP_SIGNALS)
    wrong = sum(((trace.simulated - trace.measured)[:, i] / GAP_SIGNALS[names[i]]) ** 2 for i in order)
    sums = np.concatenate(([0.0], np.cumsum(wrong)))
    width = min(ZOOM_ROWS, len(trace.t_s))
    return int(np.argmax(sums[width:] - sums[:-width]))


def _left(result: CaseResult) -> Picture:
    figure, axes = subplots(1, 2, height=2.9)
    edges = np.linspace(-6.0, 6.0, 49)
    centres = 0.5 * (edges[1:] + edges[:-1])
    data: dict[str, Any] = {"sigma": centres}
    for name, residual, colour in (
        ("before", result.residual_before, BEFORE),
        ("after", result.residual_after, AFTER),
    ):
        density = np.histogram(residual.clip(-6.0, 6.0), edges)[0] / len(residual) / (edges[1] - edges[0])
        axes[0, 0].step(centres, density, where="mid", color=colour, label=name)
        data[name] = density
    normal = np.exp(-0.5 * centres**2) / np.sqrt(2.0 * np.pi)
    axes[0, 0].plot(centres, normal, color=REFERENCE_COLOUR, linestyle="--", linewidth=0.9, label="pure noise")
    axes[0, 0].set(xlabel="residual [sigma]; the ends hold all beyond", ylabel="density [1/sigma]")
    axes[0, 0].legend()
    names = ["nothing", *(f"+ {new_effect(result, i)}" for i in range(1, len(result.steps)))]
    costs = [step.cost for step in result.steps]
    axes[0, 1].bar(range(len(costs)), costs, 0.6, color=AFTER)
    expected = result.finding.expected_cost
    axes[0, 1].axhspan(
        expected.mean - 3.0 * expected.sigma, expected.mean + 3.0 * expected.sigma, color=OTHER_COLOURS[2], alpha=0.3
    )
    axes[0, 1].axhline(expected.mean, color=OTHER_COLOURS[2], label="healthy units")
    axes[0, 1].set(xticks=range(len(costs)), xticklabels=names, yscale="log", ylabel="cost of the residual")
    axes[0, 1].set_ylim(0.5 * min(*costs, expected.mean), None)
    axes[0, 1].grid(False, axis="x")
    axes[0, 1].legend()
    data["cost_of_steps"] = np.array(costs)
    text = "Left: residuals of all features. Right: their cost after each effect; in the band a right model ends up."
    return Picture("left", "What is left", text, to_svg(figure), data)


def new_effect(result: CaseResult, i: int) -> str:
    """What the i-th step has that the step before has not (a step may also replace)."""
    names, old = result.steps[i].names, result.steps[i - 1].names
    return " + ".join(name for name in names if name not in old) or " + ".join(names)
