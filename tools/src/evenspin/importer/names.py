"""What quantity a column's name says it is."""

from __future__ import annotations

import re
from dataclasses import dataclass

# Quantities, the unit of the format's column, and the dimension that a printed unit has to have.
QUANTITIES = {
    "t_s": "time",
    "theta_m_rad": "angle",
    "theta_e_rad": "angle",
    "speed_rad_s": "speed",
    "speed_ref_rad_s": "speed",
    "iq_a": "current",
    "id_a": "current",
    "iq_ref_a": "current",
    "id_ref_a": "current",
    "ia_a": "current",
    "ib_a": "current",
    "ic_a": "current",
    "ialpha_a": "current",
    "ibeta_a": "current",
    "vq_v": "voltage",
    "vd_v": "voltage",
    "va_v": "voltage",
    "vb_v": "voltage",
    "vc_v": "voltage",
    "valpha_v": "voltage",
    "vbeta_v": "voltage",
    "duty_a": "share",
    "duty_b": "share",
    "duty_c": "share",
    "vdc_v": "voltage",
    "load_torque_nm": "torque",
    "torque_nm": "torque",
}

MOST_WORDS = 8  # of a dotted path, whose last ones name the signal

MEASURED = (
    r"(?: (?:meas|measured|act|actual|fb|fbk|feedback|est|estimate|estimated|ist|filt|filtered|in|pu|value|mech|m))*"
)
WANTED = r" (?:ref|reference|cmd|command|commanded|set|setpoint|sp|target|soll|demand|desired|des|wanted|dmd|star)"
CURRENT = r"(?:i|cur|curr|current|is|im|motor current|strom|i mot)"
VOLT = r"(?:v|u|volt|voltage|vs|us|spannung)"
SPEED = r"(?:speed|velocity|vel|omega|w|wm|wr|n|rpm|erpm|drehzahl|spd|tacho|tachometer|rotor speed|motor speed|shaft speed|mech speed|mechanical speed|speed m|omega m|omega r|n mot|vitesse)"
ELECTRICAL = r"(?:e|el|elec|elect|electric|electrical|elektrisch)"
ANGLE = r"(?:theta|angle|phi|pos|position|winkel|phase|rotor angle|rotor position|ang|th|tetha|lage)"


@dataclass(frozen=True, slots=True)
class Pattern:
    quantity: str
    words: re.Pattern[str]
    score: int  # of two patterns that fit one quantity, the more telling one


def _p(quantity: str, words: str, score: int = 10) -> Pattern:
    return Pattern(quantity, re.compile(rf"(?:{words})\Z"), score)


PATTERNS = (
    _p("t_s", r"(?:t|time|timestamp|time stamp|zeit|temps|tiempo|elapsed|elapsed time|time elapsed|clock|sim time|rel time|abs time)(?: (?:s|rel|abs))?"),
    _p("t_s", r"(?:ms today|ms|us|micros|millis|sec|secs|seconds)", 8),
    _p("theta_e_rad", rf"{ANGLE} {ELECTRICAL}|{ELECTRICAL} ?{ANGLE}|{ELECTRICAL} rotor (?:angle|position)|rotor {ELECTRICAL} angle|theta ?e|phase (?:angle|pos)"),
    _p("theta_m_rad", rf"{ANGLE} (?:m|mech|mechanical|shaft|rotor)|(?:m|mech|mechanical|shaft|rotor|motor|encoder|enc) {ANGLE}|theta ?(?:m|r)|shaft (?:angle|position)", 12),
    _p("theta_m_rad", rf"(?:{ANGLE}){MEASURED}|encoder|enc|encoder (?:count|counts|position|pos)|shadow count|count in cpr|pos (?:estimate|cpr)|qep(?: pos| position)?|counts"),
    _p("speed_ref_rad_s", rf"{SPEED}{WANTED}|{WANTED.strip()} {SPEED}|(?:n|w|omega|speed) ?soll|vel setpoint|input vel|sollwert drehzahl", 14),
    _p("speed_rad_s", rf"{SPEED}{MEASURED}|(?:meas|measured|actual|act) {SPEED}|drehzahl ist"),
    _p("speed_rad_s", r"(?:encoder|shaft|rotor|motor|mech|mechanical) (?:vel|velocity|speed|rpm)", 12),
    _p("iq_ref_a", rf"{CURRENT} ?s?q{WANTED}|q(?: axis)?(?: current)?{WANTED}|{CURRENT} q axis{WANTED}|iq ?(?:ref|cmd|set|soll)|{WANTED.strip()} (?:iq|i q|q current)", 14),
    _p("id_ref_a", rf"{CURRENT} ?s?d{WANTED}|d(?: axis)?(?: current)?{WANTED}|{CURRENT} d axis{WANTED}|id ?(?:ref|cmd|set|soll)|{WANTED.strip()} (?:id|i d|d current)", 14),
    _p("iq_a", rf"(?:{CURRENT} ?s?q|q(?: axis)? ?(?:current|cur|curr)|{CURRENT} q axis|torque current|motor iq){MEASURED}"),
    _p("id_a", rf"(?:{CURRENT} ?s?d|d(?: axis)? ?(?:current|cur|curr)|{CURRENT} d axis|flux current|motor id){MEASURED}"),
    _p("ialpha_a", rf"{CURRENT} ?s?(?:alpha|al|alfa){MEASURED}|alpha current"),
    _p("ibeta_a", rf"{CURRENT} ?s?(?:beta|be){MEASURED}|beta current"),
    _p("ia_a", rf"(?:{CURRENT} ?s?(?:a|u|1)|(?:phase|ph) ?(?:a|u|1) (?:current|cur|i)|(?:current|i) (?:phase|ph) ?(?:a|u|1)|strom [u1]){MEASURED}"),
    _p("ib_a", rf"(?:{CURRENT} ?s?(?:b|v|2)|(?:phase|ph) ?(?:b|v|2) (?:current|cur|i)|(?:current|i) (?:phase|ph) ?(?:b|v|2)|strom [v2]){MEASURED}"),
    _p("ic_a", rf"(?:{CURRENT} ?s?(?:c|w|3)|(?:phase|ph) ?(?:c|w|3) (?:current|cur|i)|(?:current|i) (?:phase|ph) ?(?:c|w|3)|strom [w3]){MEASURED}"),
    _p("vq_v", rf"(?:{VOLT} ?s?q|q(?: axis)? ?(?:voltage|volt)|{VOLT} q axis)(?:{MEASURED}|{WANTED})"),
    _p("vd_v", rf"(?:{VOLT} ?s?d|d(?: axis)? ?(?:voltage|volt)|{VOLT} d axis)(?:{MEASURED}|{WANTED})"),
    _p("valpha_v", rf"{VOLT} ?s?(?:alpha|al|alfa)(?:{MEASURED}|{WANTED})"),
    _p("vbeta_v", rf"{VOLT} ?s?(?:beta|be)(?:{MEASURED}|{WANTED})"),
    _p("va_v", rf"(?:{VOLT} ?s?(?:a|an|u|1)|(?:phase|ph) ?(?:a|u|1) (?:voltage|volt|v|u)|(?:voltage|v) (?:phase|ph) ?(?:a|u|1))(?:{MEASURED}|{WANTED})"),
    _p("vb_v", rf"(?:{VOLT} ?s?(?:b|bn|2)|(?:phase|ph) ?(?:b|v|2) (?:voltage|volt|v|u)|(?:voltage|v) (?:phase|ph) ?(?:b|v|2))(?:{MEASURED}|{WANTED})"),
    _p("vc_v", rf"(?:{VOLT} ?s?(?:c|cn|w|3)|(?:phase|ph) ?(?:c|w|3) (?:voltage|volt|v|u)|(?:voltage|v) (?:phase|ph) ?(?:c|w|3))(?:{MEASURED}|{WANTED})"),
    _p("duty_a", r"(?:duty|dty|pwm|dtc|mod|ta) ?(?:a|u|1)|d ?a"),
    _p("duty_b", r"(?:duty|dty|pwm|dtc|mod|tb) ?(?:b|v|2)|d ?b"),
    _p("duty_c", r"(?:duty|dty|pwm|dtc|mod|tc) ?(?:c|w|3)|d ?c"),
    _p("vdc_v", r"(?:[vu] ?(?:dc|bus|in|dclink|dc link|dc bus|supply|bat|batt|zk)|dc ?link(?: voltage| volt)?|dc ?bus(?: voltage)?|bus (?:voltage|volt|v)|(?:input|supply|battery|dc) (?:voltage|volt|v)|vbus voltage|zwischenkreisspannung)(?: (?:meas|measured|act|v))?"),
    _p("load_torque_nm", r"(?:load|brake) (?:torque|t|tq|m)|(?:torque|t|tq|m|tau) ?(?:load|l|brake|last)|t ?l|tload|lastmoment"),
    _p("torque_nm", rf"(?:torque|te|tem|t ?e|tq|tau|trq|moment|drehmoment|shaft torque|motor torque|electromagnetic torque|torque (?:shaft|sensor|transducer)){MEASURED}"),
)  # fmt: skip


def words_of(name: str) -> str:
    """A name as lower-case words: `motorSpeed_ref`, `axis0.encoder.vel_estimate` and `I_q (meas.)` read alike."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", " ", name)
    text = (
        text.replace("\u03b8", "theta").replace("\u03c9", "omega").replace("\u03b1", "alpha").replace("\u03b2", "beta")
    )
    text = text.replace("\u03c6", "phi").replace("\u03c4", "tau").replace("*", " ref").lower()
    return re.sub(r"[^a-z0-9]+", " ", text).strip()


def quantities_of(name: str) -> list[tuple[str, int]]:
    """Quantities that a name may mean, best first; of a dotted path the last parts are tried, too."""
    words = words_of(name).split()
    found: dict[str, int] = {}
    for first in range(min(len(words), MOST_WORDS)):
        text = " ".join(words[first:])
        for pattern in PATTERNS:
            if pattern.words.match(text):
                found[pattern.quantity] = max(found.get(pattern.quantity, 0), pattern.score - first)
        if found:
            break
    return sorted(found.items(), key=lambda item: -item[1])
