"""What is noise, what is left over, and how sure a verdict is."""

from __future__ import annotations

from evenspin.gap.threshold import ARITHMETIC, NOT_SET, SIMULATORS, Section

SECTION = Section("Evidence: noise, lines, intervals, confidence")

OUTLIER_SIGMAS = SECTION.add(
    "OUTLIER_SIGMAS",
    6.0,
    "sigmas",
    "residuals that count in full from outliers, which count with the logarithm (Cauchy)",
    set_on=NOT_SET,
    too_low="real transients of an effect count as outliers",
    too_high="a disturbance of the recording outweighs the effect",
)
SIMULATOR_SHARE = SECTION.add(
    "SIMULATOR_SHARE",
    0.003,
    "of the change between neighbouring bins",
    "a difference of models from what two correct simulators differ by in a steep transient",
    set_on=SIMULATORS,
    too_low="the steps of another simulator or drive look like an effect",
    too_high="small effects that only show in transients are lost",
)
SIMULATOR_RANGE_SHARE = SECTION.add(
    "SIMULATOR_RANGE_SHARE",
    0.05,
    "of the range within a group of bins",
    "the same where neighbouring bins are equal: this share of the range counts as change",
    set_on=NOT_SET,
    too_low="the flat end of a transient decides",
    too_high="the beginning of a transient decides nothing",
)
PERIODIC_STRETCHES = SECTION.add(
    "PERIODIC_STRETCHES",
    4.0,
    "steady stretches",
    "a foreign frequency or order, which is taken off the log before it is searched again, from lines by chance",
    set_on="two blind cases with a known effect beside a foreign line",
    too_low="what is taken off is part of an effect",
    too_high="a known effect beside a foreign line is not named where the line shows at few speeds",
)
PERIODIC_SHARE = SECTION.add(
    "PERIODIC_SHARE",
    0.8,
    "of the power around the line",
    "a tone, which one wave takes away, from a resonance that noise excites",
    set_on=NOT_SET,
    too_low="the resonance of a compliant shaft is taken for something foreign",
    too_high="a tone whose amplitude varies stays in the log",
)
PERIODIC_RATIO = SECTION.add(
    "PERIODIC_RATIO",
    2000.0,
    "power over the model's noise",
    "a foreign tone that hides all else, and is taken off before the search, from one that is tried afterwards",
    set_on=NOT_SET,
    too_low="the limit cycle of an effect of the table is taken for something foreign",
    too_high="no harm but time: a search that cannot succeed comes first",
)
ORDER_CYCLES = SECTION.add(
    "ORDER_CYCLES",
    0.8,
    "cycles within a stretch",
    "two angle orders, or an order and a trend, that a stretch can separate from those that it cannot",
    set_on=ARITHMETIC,
    too_low="features that are the same number twice",
    too_high="the slow stretches show no order",
)
COAST_ORDER_MAX = SECTION.add(
    "COAST_ORDER_MAX",
    2.0,
    "per turn",
    "orders that a decaying speed still shows from those that smear",
    set_on=NOT_SET,
    too_low="the second order of misalignment is not seen without current",
    too_high="smeared orders add noise",
)
SLOT_ORDER_MEAN_SQUARE = SECTION.add(
    "SLOT_ORDER_MEAN_SQUARE",
    10.0,
    "mean square in sigmas",
    "an order of the slots alone from noise",
    set_on=NOT_SET,
    too_low="cogging is searched at the order of a single unlike magnet by chance",
    too_high="a single unlike magnet becomes `unknown`",
)
SLOT_ORDER_RATIO = SECTION.add(
    "SLOT_ORDER_RATIO",
    3.0,
    "times the order of slots and poles",
    "one unlike magnet from ordinary cogging that leaks into the order of the slots",
    set_on=NOT_SET,
    too_low="ordinary cogging is searched at the wrong order",
    too_high="one unlike magnet beside ordinary cogging is not found",
)
SLOT_ORDER_CAP = SECTION.add(
    "SLOT_ORDER_CAP",
    30.0,
    "sigmas",
    "an order that shows in many stretches from one that a single stretch has",
    set_on=NOT_SET,
    too_low="strong cogging looks weak",
    too_high="one disturbed stretch chooses the order",
)
REPEAT_PEAK_SHARE = SECTION.add(
    "REPEAT_PEAK_SHARE",
    0.5,
    "of the largest power in any repeat",
    "a line that the model itself makes now and then from one that it never makes",
    set_on=NOT_SET,
    too_low="a limit cycle that only some repeats have is left over as a line",
    too_high="lines beside a noisy repeat are overlooked",
)
SPECTRUM_FLOOR_SHARE = SECTION.add(
    "SPECTRUM_FLOOR_SHARE",
    0.2,
    "of the median power over frequency",
    "a line from a bin in which the simulated noise happens to be almost zero",
    set_on=NOT_SET,
    too_low="chance lines at quiet bins",
    too_high="lines at quiet frequencies are overlooked",
)
NEIGHBOUR_SHARE = SECTION.add(
    "NEIGHBOUR_SHARE",
    0.5,
    "of the grid of starts",
    "how far beside the point that was found a nonlinear effect may be, so that a limit cycle there is the model's own",
    set_on=NOT_SET,
    too_low="a limit cycle of backlash that the point just misses makes the log `unknown`",
    too_high="an unknown line near one of backlash is overlooked",
)
PARAMETER_SHARE = SECTION.add(
    "PARAMETER_SHARE",
    0.02,
    "of a parameter (rad of a phase)",
    "an interval from what two correct simulators of an effect differ by",
    set_on=SIMULATORS,
    too_low="95 % intervals hold the truth less often than 95 times in 100",
    too_high="intervals of strong effects are wider than needed",
)
SATURATION_SHARE = SECTION.add(
    "SATURATION_SHARE",
    0.10,
    "of the saturation current",
    "an interval from what two honest laws of saturation differ by in the current at which the inductance has halved",
    set_on=SIMULATORS + "; 4.2, 1.4 and 8.2 % in a third one whose law no form of ours is",
    too_low="95 % intervals of the saturation current hold the truth less often than 95 times in 100",
    too_high="intervals of strong saturations are wider than needed",
)
DAMPING_SHARE = SECTION.add(
    "DAMPING_SHARE",
    0.15,
    "of a damping ratio",
    "the same for the damping of a shaft, to which friction on either side and every step of an integration add",
    set_on=SIMULATORS + "; 9 to 15 % in blind cases",
    too_low="95 % intervals of the damping hold the truth less often than 95 times in 100",
    too_high="intervals of the damping are wider than needed",
)
INFLATION_MIN = SECTION.add(
    "INFLATION_MIN",
    1.0,
    "times the standard deviation of the fit",
    "the least factor by which the scatter of healthy units may change an interval",
    set_on=ARITHMETIC,
    too_low="ten units that agree by chance make an interval too narrow",
    too_high="intervals are never as narrow as the fit",
)
PHASE_KNOWN_RAD = SECTION.add(
    "PHASE_KNOWN_RAD",
    1.0,
    "rad",
    "a phase that the log determines from one that it does not",
    set_on=NOT_SET,
    too_low="warnings about phases of weak effects that are right",
    too_high="phases that say nothing go without a warning",
)
CONFIDENCE_MAX = SECTION.add(
    "CONFIDENCE_MAX",
    0.98,
    "of 1",
    "the surest verdict there is: the share of clear verdicts on blind cases that are right",
    set_on="verdicts on blind cases: the share of clear ones that were right",
    too_low="clear verdicts seem doubtful",
    too_high="a confidence that blind cases do not bear out",
)
LEFTOVER_SHARE = SECTION.add(
    "LEFTOVER_SHARE",
    0.01,
    "of what all effects take away",
    "a small effect beside a large one from what the large one leaves where it is modelled a little differently",
    set_on=SIMULATORS,
    too_low="a second name is as sure as the first",
    too_high="true small effects seem doubtful",
)
UNKNOWN_DOUBT = SECTION.add(
    "UNKNOWN_DOUBT",
    0.5,
    "of CONFIDENCE_MAX",
    "how sure `unknown` is at its limit...",
    set_on=NOT_SET,
    too_low="`unknown` by a hair seems sure",
    too_high="clear cases of `unknown` near the limit seem doubtful",
)
UNKNOWN_RISE = SECTION.add(
    "UNKNOWN_RISE",
    2.0,
    "per limit of excess",
    "...and how fast it becomes surer beyond it",
    set_on=NOT_SET,
    too_low="unknown effects seem doubtful",
    too_high="`unknown` by a hair seems sure",
)
REST_DOUBT = SECTION.add(
    "REST_DOUBT",
    0.5,
    "of the confidence",
    "how much an excess at the limit of `unknown` takes from every name",
    set_on=NOT_SET,
    too_low="names beside a large residual seem sure",
    too_high="names that are right seem doubtful when the drive is modelled a little differently",
)
ALTERNATIVE_LEAST = SECTION.add(
    "ALTERNATIVE_LEAST",
    0.001,
    "weight",
    "alternatives that are listed from those that are not",
    set_on=NOT_SET,
    too_low="long lists that say nothing",
    too_high="a rival is missing from the list",
)
INSEPARABLE_WEIGHT = SECTION.add(
    "INSEPARABLE_WEIGHT",
    0.05,
    "weight",
    "an effect that a name may also be from one that it is not",
    set_on=NOT_SET,
    too_low="every name may be anything",
    too_high="a close rival is not mentioned",
)
OPEN_GAP = SECTION.add(
    "OPEN_GAP",
    1.05,
    "times the noise floor",
    "a gap of which a share can be closed from one that is noise",
    set_on=NOT_SET,
    too_low="shares of a gap that is noise, from minus to plus infinity",
    too_high="a gap that was closed is not mentioned",
)
