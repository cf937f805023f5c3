"""What a page may say, and the frame of rows as the page reads it."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from evenspin.scope import messages


def test_a_frame_has_a_head_then_times_then_columns() -> None:
    octets = messages.frame(messages.LIVE, 7, np.array([0.5, 0.75]), np.array([[1, 2, 3], [4, 5, 6]], np.float32))

    assert struct.unpack_from("<IIII", octets) == (1, 7, 2, 3)
    assert struct.unpack_from("<2d", octets, 16) == (0.5, 0.75)
    assert struct.unpack_from("<6f", octets, 32) == (1.0, 4.0, 2.0, 5.0, 3.0, 6.0)
    assert len(octets) == 16 + 16 + 24


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "Invalid JSON"),
        ("[]", "object"),
        ('{"do": "explode"}', "do"),
        ('{"do": "set", "values": {"rc_gain": NaN}}', "rc_gain"),
        ('{"do": "set", "values": {"rc_gain": "much"}}', "rc_gain"),
        ('{"do": "start", "speed_rad_s": 1e999}', "speed_rad_s"),
        ('{"do": "stop", "why": "x"}', "why"),
        ('{"do": "capture", "signals": ["iq_a"], "rows": 0}', "rows"),
    ],
)
def test_what_is_no_request_is_refused_in_one_line(text: str, said: str) -> None:
    with pytest.raises(messages.BadRequestError) as refused:
        messages.parse(text)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_stop_and_looking_need_no_control_and_everything_that_moves_does() -> None:
    assert messages.parse('{"do": "stop"}').do not in messages.NEEDS_CONTROL
    assert {"arm", "start", "setpoint", "set", "clear_fault"} <= messages.NEEDS_CONTROL
    assert not {"stop", "spectrum", "document", "take_control"} & messages.NEEDS_CONTROL
