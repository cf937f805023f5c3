"""Cost of one operation on the C28x with FPU32 and TMU0, no wait states, in cycles; docs/cycles.md has the evidence.

A cost is what an operation adds to code that TI's compiler has scheduled, not its latency. The first table has the
classes of tests/budget/listings.csv, counts of functions that TI's compiler made: it was fitted to the repositories in
`FITTED`, starting from what their instructions say one by one, and rounded to a tenth. The second table has what is not
in that file.
"""

from __future__ import annotations

FITTED = ("josearistidesbail/foc-f28379d-fsae", "gib-79/OBC_BiDi")

COSTS = {
    "fop": 1.5,  # float add, subtract, multiply: 2p, and one of eight shares its cycle with a move
    "fneg": 1.0,
    "fdiv": 4.1,  # DIVF32, its slots mostly filled
    "fcmp": 1.5,  # CMPF32, and MOVST0 where a branch follows
    "select": 2.0,  # of any kind: two conditional moves, or a branch
    "minmax": 0.9,  # MINF32, MAXF32
    "fhard": 2.1,  # float constant in arithmetic, low half not zero: MOVIZ and MOVXI; else it is free
    "kmove": 1.0,  # float constant stored or handed over, low half zero: MOVIZ
    "kmove2": 2.0,  # the same, low half not zero
    "f2i": 4.9,  # conversion, slots, move to the CPU's registers
    "i2f": 3.7,
    "convmem": 2.6,  # either, the whole number only in memory
    "mem": 1.1,  # load, store
    "glob": 0.4,  # of a variable with a name: MOVW DP, for every second access
    "vol": 0.1,  # volatile
    "stk32": 0.8,  # whole number of 32 bits stored as a constant
    "stk16": 0.3,
    "gsmall": 0.0,  # address with an offset of up to 7 words: *+XARn[0..7]
    "gbig": 0.9,  # beyond
    "gvar": 2.2,  # variable index
    "ldptr": 0.5,  # address loaded: waits up to 3, mostly filled
    "iop": 1.0,  # whole numbers: add, subtract, product, and, or, exclusive or
    "icmp": 1.3,
    "shift": 2.0,
    "cast": 0.3,
    "brc": 4.2,  # branch on a condition: 7 taken, 4 not; on the longest path 22 % are taken
    "bru": 1.0,  # jump: most are laid out in line
    "switch": 12.0,  # chain of CMPB and B
    "phi": 0.7,
    "call": 12.2,  # LCR 4, LRETR 8
    "args": 0.7,
    "tmu": 4.0,
    "intrin": 2.3,  # smaller and larger of two whole numbers, magnitude
    "frame": 14.8,  # a function's own: LCR 4, LRETR 8, and what it saves
    "isr": 65.0,  # interrupt: entry 14, registers, IRET 8; 34 to 80 in listings, by what is saved
}

OTHER = {
    "lop": 2.0,  # 64 bits: ADDUL and ADDCL
    "lshift": 2.0,  # 64 bits: LSL64, ASR64, by a constant; else a loop of it
    "lmul": 10.0,  # 64 bits: three products and their sums
    "lwide": 3.0,  # 32 by 32 to 64 bits: XT, IMPYL, QMPYL
    "lcmp": 3.0,  # CMP64
    "lconv": 25.0,  # between float and 64 bits: library
    "idiv": 42.0,  # library: RPT #31 || SUBCUL, call included
    "idivk": 10.0,  # by a constant: a product's upper half, and a shift
    "ldiv": 600.0,  # 64 bits: library, bit by bit
    "frem": 300.0,
    "moved": 5.0,  # bits from float registers to the CPU's or back, unchanged
    "block": 6.0,  # copy or fill of memory: RPT...
    "blockword": 1.0,  # ...and each word
    "sqrt": 5.0,  # SQRTF32
    "regread": 4.0,  # register of a peripheral: MOVW DP, and a read with two wait states
    "regwrite": 2.0,
    "pointed": 2.0,  # a call by a pointer: its address
    "lock": 1.0,  # SETC, CLRC and the like, PUSH and POP of a status
}

ALL = {**COSTS, **OTHER}
CALLED_TWICE = 12.0  # LCR and LRETR of a call: in the costs of the caller's call and of the called function's frame


def callee_cost() -> float:
    """What a call costs beside the instructions of both functions."""
    return COSTS["call"] + COSTS["frame"] - CALLED_TWICE


def tenths(counts: dict[str, int]) -> int:
    """Cost of so many operations of each class, a call with what the called function saves, in tenths of a cycle."""
    total = sum(ALL[name] * count for name, count in counts.items())
    total += counts.get("call", 0) * (COSTS["frame"] - CALLED_TWICE)
    return round(10.0 * total)
