"""What a record has to be before it is compared, and which parts of it are."""

from __future__ import annotations

from evenspin.gap.threshold import ARITHMETIC, NOT_SET, Section

SECTION = Section("Records: used, mended, left out, planned")

LEAST_ROWS = int(
    SECTION.add(
        "LEAST_ROWS",
        200,
        "rows",
        "a record that can be compared from a fragment",
        set_on=NOT_SET,
        too_low="a fragment of a record decides",
        too_high="short recordings are left out",
    )
)
PERIODS_SHARE = SECTION.add(
    "PERIODS_SHARE",
    0.02,
    "of the periods",
    "a sampling time that is a whole number of PWM periods from one that is not",
    set_on=NOT_SET,
    too_low="rounded numbers in meta.json are refused",
    too_high="a wrong sampling time is simulated",
)
DC_LINK_SHARE = SECTION.add(
    "DC_LINK_SHARE",
    0.05,
    "of dc_link_v",
    "a dc link that is another than in meta.json from its ripple",
    set_on=NOT_SET,
    too_low="warnings about every real supply",
    too_high="a wrong voltage limit goes without a warning",
)
REST_SHARE = SECTION.add(
    "REST_SHARE",
    0.05,
    "of the fastest speed",
    "a record that starts at rest from one that does not",
    set_on=NOT_SET,
    too_low="records are left out because of a noisy speed",
    too_high="the simulation starts with another speed than the log",
)
REST_RAD_S = SECTION.add(
    "REST_RAD_S",
    0.5,
    "rad/s",
    "the same where the fastest speed is low: noise of the speed at rest",
    set_on=NOT_SET,
    too_low="slow records are left out",
    too_high="slow records that do not start at rest are used",
)
STILL_COUNTS = SECTION.add(
    "STILL_COUNTS",
    8.0,
    "encoder counts",
    "a rotor that is held from one that turns",
    set_on=NOT_SET,
    too_low="warnings about an elastic clamp",
    too_high="a rotor that slips in its clamp goes without a warning",
)
FINE_RAD = SECTION.add(
    "FINE_RAD",
    2e-05,
    "rad",
    "counts that a CSV of six decimals shows from finer ones",
    set_on=ARITHMETIC,
    too_low="warnings about counts that the digits of the file have cut",
    too_high="a wrong count number of a fine encoder goes without a warning",
)
COUNTS_COHERENCE = SECTION.add(
    "COUNTS_COHERENCE",
    0.7,
    "of 1",
    "an angle that moves in the counts of meta.json from one that does not",
    set_on=NOT_SET,
    too_low="a wrong count number goes without a warning",
    too_high="warnings about encoders with uneven counts",
)
COARSE_COHERENCE = SECTION.add(
    "COARSE_COHERENCE",
    0.9,
    "of 1",
    "an angle that moves in several counts at a time from one that moves in each",
    set_on=NOT_SET,
    too_low="warnings about slow records that happen to show every other count",
    too_high="a wrong count number goes without a warning",
)
VOLTAGE_EXCESS = SECTION.add(
    "VOLTAGE_EXCESS",
    1.02,
    "times the limit",
    "a voltage limit that meta.json has wrong from rounding",
    set_on=NOT_SET,
    too_low="warnings about rounded numbers",
    too_high="a wrong limit goes without a warning",
)
CURRENT_EXCESS = SECTION.add(
    "CURRENT_EXCESS",
    1.01,
    "times the limit",
    "a current limit that meta.json has wrong from rounding",
    set_on=NOT_SET,
    too_low="warnings about rounded numbers",
    too_high="a wrong limit goes without a warning",
)
FILLED_SHARE = SECTION.add(
    "FILLED_SHARE",
    0.02,
    "of the values of a column",
    "a record that may be mended from one that is left out",
    set_on=NOT_SET,
    too_low="a log with a few lost samples is useless",
    too_high="straight lines are taken for measurements",
)
BACKWARDS_SHARE = SECTION.add(
    "BACKWARDS_SHARE",
    0.2,
    "of the rows",
    "a record whose time repeats now and then from one whose time is wrong",
    set_on=NOT_SET,
    too_low="a log with a stuttering clock is useless",
    too_high="two records written into one file are mixed",
)
BRIDGED_ROWS = int(
    SECTION.add(
        "BRIDGED_ROWS",
        5,
        "rows",
        "a gap that is bridged from one at which the record ends",
        set_on=NOT_SET,
        too_low="a single lost frame ends the record",
        too_high="straight lines replace a transient",
    )
)
SETTLE_S = SECTION.add(
    "SETTLE_S",
    0.3,
    "s",
    "a steady stretch from the end of a transient: a speed loop of some hertz has settled",
    set_on="the step response of a speed loop of some hertz",
    too_low="the end of a step looks like a trend",
    too_high="short levels have no steady part",
)
STEADY_MIN_S = SECTION.add(
    "STEADY_MIN_S",
    0.25,
    "s",
    "a stretch long enough for orders and a mean from one that is not",
    set_on=NOT_SET,
    too_low="means of a few rows, with a noise that their group does not have",
    too_high="levels of a short staircase are not used",
)
COAST_SHARE = SECTION.add(
    "COAST_SHARE",
    0.15,
    "of the speed at release",
    "a coasting rotor from one that rocks in whatever torque depends on the angle",
    set_on=NOT_SET,
    too_low="features that do not repeat",
    too_high="the slow end of the coast-down, where dry friction shows, is lost",
)
COAST_TURNS = SECTION.add(
    "COAST_TURNS",
    1.2,
    "turns within 0.4 s",
    "a coasting stretch that shows a first order from one that only shows a curve",
    set_on="the fit of a first order beside a curve",
    too_low="a curve looks like a first order",
    too_high="eccentricity is not seen without current",
)
MOVING_RAD_S = SECTION.add(
    "MOVING_RAD_S",
    0.02,
    "rad/s",
    "a record that begins in motion, whose first 0.1 s is not compared, from one at rest",
    set_on=NOT_SET,
    too_low="the first step of an ordinary record is not used",
    too_high="the simulation's own start looks like an effect",
)
TOP_VOLTAGE_SHARE = SECTION.add(
    "TOP_VOLTAGE_SHARE",
    0.6,
    "of the voltage that the dc link allows",
    "experiments of `gap plan` that stay below the voltage limit from those that reach it",
    set_on=NOT_SET,
    too_low="effects that grow with the speed show less",
    too_high="the voltage limit hides what is searched",
)
