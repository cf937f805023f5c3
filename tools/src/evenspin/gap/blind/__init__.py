"""Blind cases: logs with hidden effects, made by a simulator that shares no code with the one that is fitted."""
