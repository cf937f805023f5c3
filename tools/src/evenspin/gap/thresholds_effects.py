"""What an effect has to show before it is tried, kept and named."""

from __future__ import annotations

from evenspin.gap.threshold import EXAMPLES, FIRST_SET, NOT_SET, SECOND_SET, Section

SECTION = Section("Effects: tried, kept, named")

GAIN_MIN = SECTION.add(
    "GAIN_MIN",
    40.0,
    "cost",
    "the gain of a real effect from that of a chance fit",
    set_on=EXAMPLES,
    too_low="effects are named on healthy units: features are correlated, so that chance gains exceed a chi-square's",
    too_high="small friction and small cogging stay without a name",
)
SURE_GAIN = SECTION.add(
    "SURE_GAIN",
    400.0,
    "cost",
    "an effect whose worth a local fit shows from one that the wide search has to confirm",
    set_on=SECOND_SET,
    too_low="an effect stays named although the other effects explain the log from another minimum",
    too_high="some 200 simulations more for every partner of a nonlinear effect",
)
GAIN_BEYOND_TOLERANCE = SECTION.add(
    "GAIN_BEYOND_TOLERANCE",
    8.0,
    "cost",
    "a parameter outside of its tolerance from one at its edge (three sigmas cost 9)",
    set_on=FIRST_SET,
    too_low="ordinary scatter of resistance or inertia is named",
    too_high="an inertia 5 % off stays hidden in the tolerance",
)
SHARE_MIN = SECTION.add(
    "SHARE_MIN",
    0.10,
    "of the excess",
    "an effect that explains the log from one that picks up the residual of another",
    set_on=EXAMPLES,
    too_low="a wrong effect with a similar signature is carried on beside the right one",
    too_high="the smaller effect of a pair is not taken",
)
IMPERFECT_SHARE = SECTION.add(
    "IMPERFECT_SHARE",
    0.005,
    "of the first effect's gain",
    "a second effect from what an imperfect model of the first one leaves",
    set_on=FIRST_SET + "; 0.015 before, which hid small second effects",
    too_low="a large dead time or saturation drags a second name along",
    too_high="small second effects beside a large one are not named",
)
WEAK_GAIN = SECTION.add(
    "WEAK_GAIN",
    500.0,
    "cost",
    "gains that stand by themselves from those that must hold in simulations no fit has seen",
    set_on=SECOND_SET + "; chance gains on healthy units reached 100",
    too_low="saturation is named on healthy units (2 of 25)",
    too_high="8 simulations more for clear cases",
)
SECOND_SHARE = SECTION.add(
    "SECOND_SHARE",
    0.5,
    "of the least gain",
    "a gain that holds in simulations that no fit has seen from one that was picked by the search",
    set_on=SECOND_SET + "; chance gains became losses of 5 to 110, true ones of 220 to 300 stayed",
    too_low="chance gains pass",
    too_high="true gains near GAIN_MIN fail by the noise of 8 simulations",
)
FAR_OFF = SECTION.add(
    "FAR_OFF",
    1.5,
    "times the edge of a tolerance",
    "a parameter that no healthy unit has from one at the edge of its tolerance",
    set_on=SECOND_SET + "; a friction factor 4.5 sigmas off",
    too_low="the edge of a tolerance is named beside a large effect",
    too_high="a clear deviation stays unnamed because its share of the cost is small",
)
TOLERATED = SECTION.add(
    "TOLERATED",
    3.0,
    "standard deviations",
    "a unit within its data sheet from one beyond",
    set_on=NOT_SET,
    too_low="warnings about ordinary units",
    too_high="a wrong data sheet is taken up silently",
)
DECISIVE_SHARE = SECTION.add(
    "DECISIVE_SHARE",
    0.5,
    "of the excess",
    "an effect that needs no validation record from one that has to prove itself there",
    set_on=SECOND_SET + "; a ringing loop follows no simulation to the sample",
    too_low="fitted noise is named",
    too_high="effects that make a loop ring are thrown away",
)
WORSE_SHARE = SECTION.add(
    "WORSE_SHARE",
    0.002,
    "of the validation gap",
    "not worse on the validation records from worse",
    set_on=FIRST_SET,
    too_low="the noise of the validation gap rejects true second effects",
    too_high="an effect that harms the validation is kept",
)
EXCESS_SIGMAS = SECTION.add(
    "EXCESS_SIGMAS",
    6.0,
    "standard deviations of the cost of healthy units",
    "something is left from nothing is left",
    set_on=EXAMPLES,
    too_low="searches and warnings on healthy units",
    too_high="the search stops early",
)
EXCESS_SHARE = SECTION.add(
    "EXCESS_SHARE",
    0.12,
    "of the expected cost",
    "something is left from what two simulators of the same machine differ by",
    set_on=EXAMPLES + "; cost of the right model there: within 5 % of that of healthy units",
    too_low="warnings on every log of another simulator or drive",
    too_high="a small further effect goes without a warning",
)
UNKNOWN_SHARE = SECTION.add(
    "UNKNOWN_SHARE",
    0.4,
    "of the expected cost",
    "`unknown` from a name with a warning",
    set_on=SECOND_SET + "; known effects left 37 % at most, unknown ones 117 % and more, one unknown effect 27 %",
    too_low="known effects that are modelled a little differently become `unknown`",
    too_high="unknown effects get the name of a similar known one",
)
INSTEAD_SPREAD = SECTION.add(
    "INSTEAD_SPREAD",
    0.4,
    "of the size",
    "an effect that stands in for others, which are then tried in its place, from one that only differs over the log",
    set_on="one blind case with three effects hidden",
    too_low="time: a second search wherever something foreign is left",
    too_high="three effects of which two resemble a fourth are `unknown`",
)
LINE_RATIO = SECTION.add(
    "LINE_RATIO",
    40.0,
    "power over the model's noise",
    "a spectral line that is left over from noise",
    set_on=EXAMPLES,
    too_low="`unknown` by the chance peaks of some hundred spectra",
    too_high="an unknown periodic effect is overlooked",
)
LINES_MIN = SECTION.add(
    "LINES_MIN",
    3.0,
    "lines",
    "a periodic effect, which shows in several stretches, from a single chance line",
    set_on=EXAMPLES,
    too_low="`unknown` by a single disturbance of the recording",
    too_high="an unknown effect that shows at few speeds is overlooked",
)
NONLINEAR_GAIN = SECTION.add(
    "NONLINEAR_GAIN",
    0.1,
    "of the best explanation's gain",
    "a nonlinear effect worth a wide search from one that is not",
    set_on=FIRST_SET,
    too_low="every case takes the time of backlash",
    too_high="backlash and resonance are not tried beside a similar effect",
)
NEAR_GAIN = SECTION.add(
    "NEAR_GAIN",
    0.3,
    "of the best candidate's gain",
    "rivals of an explanation that are still refined from those that are not",
    set_on=EXAMPLES,
    too_low="more simulations",
    too_high="alternatives and confidence miss a close rival",
)
ALTERNATIVE_COST = SECTION.add(
    "ALTERNATIVE_COST",
    20.0,
    "cost",
    "how fast alternatives lose weight: by e for this much more cost",
    set_on=EXAMPLES,
    too_low="close rivals seem impossible",
    too_high="clear verdicts seem doubtful",
)
PROMISE_UNEXPLAINED = SECTION.add(
    "PROMISE_UNEXPLAINED",
    0.5,
    "of GAIN_MIN",
    "candidates worth a refinement while nothing explains the log",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="an effect whose linear signature is poor is never tried",
)
PROMISE_EXPLAINED = SECTION.add(
    "PROMISE_EXPLAINED",
    0.7,
    "of the least gain",
    "candidates worth a refinement once an explanation stands",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="a small second effect is never tried",
)
BORROWED_SHARE = SECTION.add(
    "BORROWED_SHARE",
    0.02,
    "of the best gain",
    "the same while much is left: effects that promise a fair part of the best from those that promise next to nothing",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="an effect whose signature changes beside another one is never tried",
)
PROMISE_BORROWED = SECTION.add(
    "PROMISE_BORROWED",
    0.3,
    "of the promised gain",
    "effects that are simulated beside an explanation from those that their signature on the bare machine rules out",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="a small second effect that shows otherwise beside the first is never tried",
)
PROMISE_SIZE = SECTION.add(
    "PROMISE_SIZE",
    0.6,
    "of the size that counts",
    "candidates that may grow large enough to be named from those too small",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="an effect that a linear fit underestimates is never tried",
)
PROMISE_SIZE_TOLERANCE = SECTION.add(
    "PROMISE_SIZE_TOLERANCE",
    0.1,
    "of the size that counts",
    "the same for parameters with a tolerance, which takes its share first",
    set_on=NOT_SET,
    too_low="more simulations",
    too_high="a deviation that the tolerance has mostly taken up is never tried",
)
SETTLED_SHARE = SECTION.add(
    "SETTLED_SHARE",
    0.97,
    "of the cost",
    "rounds of noise level and refinement that still help from those that do not",
    set_on=NOT_SET,
    too_low="rounds end while the noise level is still that of another machine",
    too_high="more simulations",
)
PAIR_GAIN = SECTION.add(
    "PAIR_GAIN",
    2.0,
    "of GAIN_MIN",
    "pairs of effects worth a refinement, and worth a place where no single effect has one",
    set_on=NOT_SET,
    too_low="more simulations; two chance gains pass as a pair",
    too_high="effects that only show together are never tried",
)
EFFECTS_MAX = int(
    SECTION.add(
        "EFFECTS_MAX",
        3,
        "effects",
        "an explanation from a collection of effects that fits anything",
        set_on=NOT_SET,
        too_low="a third hidden effect is not named",
        too_high="more simulations, and unknown effects are composed of known ones",
    )
)
CANDIDATES = int(
    SECTION.add(
        "CANDIDATES",
        6,
        "single effects a stage",
        "effects that are refined from those that a linear fit ranks too low",
        set_on=NOT_SET,
        too_low="an effect whose linear signature is poor is never tried",
        too_high="more simulations",
    )
)
CANDIDATES_BESIDE = int(
    SECTION.add(
        "CANDIDATES_BESIDE",
        3,
        "sets a stage",
        "the same for pairs, and for one more effect beside the runner-up",
        set_on=NOT_SET,
        too_low="a pair that hides behind a wrong first effect is never tried",
        too_high="more simulations",
    )
)
FIRST_KEPT = int(
    SECTION.add(
        "FIRST_KEPT",
        2,
        "first explanations",
        "explanations that are carried on from those that are given up",
        set_on=NOT_SET,
        too_low="a pair whose smaller effect ranks first is not found",
        too_high="more simulations",
    )
)
PARTIAL_SPREAD = SECTION.add(
    "PARTIAL_SPREAD",
    0.12,
    "of the size of an effect, which two thirds of the log are within",
    "an effect beside something unknown from one that only resembles it, whose size differs more over the log",
    set_on="14 effects beside or in place of something foreign (seed 90210): right ones to 0.06, wrong ones from 0.24",
    too_low="a right effect beside something foreign is thrown away",
    too_high="a fan is named viscous friction",
)
VARIES_SPREAD = SECTION.add(
    "VARIES_SPREAD",
    0.18,
    "of the size of an effect, which two thirds of the log are within",
    "an effect that explains a log from one whose place it takes: what drifts, or follows another law",
    set_on=NOT_SET,
    too_low="weak effects, whose size each part knows badly, end as `unknown`",
    too_high="a resistance that drifts is named as one that is larger",
)
PARTIAL_GAIN = SECTION.add(
    "PARTIAL_GAIN",
    400.0,
    "cost",
    "an effect that stands beside something unknown from one that takes up a little of it",
    set_on=NOT_SET,
    too_low="a small wrong name beside `unknown`",
    too_high="a small right one is not named beside `unknown`",
)
PARTIAL_SHARE = SECTION.add(
    "PARTIAL_SHARE",
    0.02,
    "of the squared gap on validation records",
    "an effect beside something unknown that unseen records confirm from one that they do not",
    set_on=NOT_SET,
    too_low="a name that only the fit records want",
    too_high="a small right effect beside something large is not named",
)
LINEAR_SHARE = SECTION.add(
    "LINEAR_SHARE",
    0.1,
    "of a residual",
    "what a linear signature explains from what it may miss: large residuals count that much less in the ranking",
    set_on=NOT_SET,
    too_low="the effect with the most linear signature ranks first, whatever it explains",
    too_high="large effects rank no higher than small ones",
)
LIKENESS = SECTION.add(
    "LIKENESS",
    0.3,
    "of the gain that the signature of a start promises",
    "starts of a nonlinear effect that a better point may save from hopeless ones",
    set_on=NOT_SET,
    too_low="backlash and resonance are not tried: no start of the grid is right",
    too_high="a wide search in every case",
)
