"""Blind cases: logs with hidden effects, made by a simulator that shares no code with the one that is fitted.

What a case is made of stands here a second time on purpose: experiments, tolerances, the gap, the orders of cogging,
and the referee's parameters. They check those that the search reads (evenspin.log, evenspin.effects).
"""
