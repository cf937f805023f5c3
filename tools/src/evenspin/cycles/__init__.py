"""Cycles of the C28x, estimated from the compiled code."""
