"""Yeh and Liu 2024, Machines 12, 771: P-PI, SILC, SRC and RDC of a position drive. See docs/reference/yeh2024.md."""

from evenspin.reproduce.yeh2024.result import METHODS, Result, reproduce

__all__ = ["METHODS", "Result", "reproduce"]
