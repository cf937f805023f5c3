"""Cost of one operation on the C28x with FPU32 and TMU0, no wait states, in tenths of a cycle; see docs/cycles.md.

A cost is what an operation adds to code that a compiler has scheduled, not its latency.
"""

from __future__ import annotations

import re
from collections.abc import Container, Sequence

CALL = 160  # LCR 4, LRETR 4, eight pushes, pops and moves of arguments
ISR_FRAME = 650  # interrupt entry 14, save and restore of everything the compiler uses, IRET 8

FLOAT = {"fadd": 20, "fsub": 20, "fmul": 20, "fneg": 10, "fdiv": 60, "frem": 3000, "fcmp": 10}
# F32TOI32 2p, one slot more before the move to the CPU's registers, the move; MOV32 to the FPU's registers 1, four
# slots before its use, I32TOF32 2p: a middle. Where the whole number comes from or goes to memory nothing is moved: 2p.
CONVERSION = {"fptosi": 40, "fptoui": 40, "sitofp": 60, "uitofp": 60, "bitcast": 50}
CONVERSION_IN_MEMORY = 20
INTEGER = {
    "add": 10, "sub": 10, "and": 10, "or": 10, "xor": 10, "shl": 15, "lshr": 15, "ashr": 15, "mul": 20, "icmp": 10,
}  # fmt: skip
DIVISION = {"sdiv": 420, "udiv": 420, "srem": 420, "urem": 420}  # library: RPT #31 || SUBCUL, call included
LONG_LONG = 5  # 64 bits: so many times the 32-bit operation for what is not a product or a quotient
LONG_LONG_MULTIPLY = 100  # three 32 x 32 products and their sums
WIDENING_MULTIPLY = 20  # 32 x 32 to 64: one product for each half, IMPYL and QMPYL
LONG_LONG_DIVIDE = 6000  # library routine, bit by bit
CONSTANT = 15  # MOVIZ and MOVXI of a float constant; 1 where the low half is zero
LOAD = 10
STORE = 10
CONSTANT_INDEX = 3  # beyond *+XARn[7] an offset must be added
VARIABLE_INDEX = 40  # index into an address register and the wait before its use
BRANCH = 60  # 7 taken, 4 not, and MOVST0
JUMP = 25  # most are placed in line
SWITCH = 150
PHI = 5
SELECT = 10
MINMAX = 10
CAST = 3

# Functions of driverlib in the current interrupt: registers that they read and write. They are inline functions with
# constant arguments, so nothing is left of them but that; the address comes first, as for a variable index.
READ_REGISTER = VARIABLE_INDEX + 30  # 1 and two wait states
WRITE_REGISTER = VARIABLE_INDEX + 10
REGISTERS = {  # reads, writes, cycles beside: masks, comparisons, shifts
    "ADC_readResult": (1, 0, 0),
    "ADC_clearInterruptStatus": (0, 1, 0),
    "ADC_getInterruptOverflowStatus": (1, 0, 2),
    "ADC_clearInterruptOverflowStatus": (0, 1, 0),
    "CPUTimer_getTimerCount": (1, 0, 0),
    "ECAP_loadCounter": (1, 1, 1),
    "EPWM_setCounterCompareValue": (0, 1, 0),
    "EPWM_getOneShotTripZoneFlagStatus": (1, 0, 1),
    "EQEP_getPosition": (1, 0, 0),
    "EQEP_getCaptureTimerLatch": (1, 0, 0),
    "EQEP_getDirection": (1, 0, 3),
    "EQEP_getInterruptStatus": (1, 0, 0),
    "EQEP_getIndexPositionLatch": (1, 0, 0),
    "EQEP_clearInterruptStatus": (0, 1, 0),
    "GPIO_writePin": (0, 1, 2),
    "Interrupt_clearACKGroup": (0, 1, 0),
    "Interrupt_disableGlobal": (0, 0, 4),  # PUSH ST1, SETC INTM, POP, mask
    "Interrupt_enableGlobal": (0, 0, 5),
    "SCI_getRxStatus": (1, 0, 0),
    "SCI_getOverflowStatus": (1, 0, 2),
    "SCI_getRxFIFOStatus": (1, 0, 2),
    "SCI_getTxFIFOStatus": (1, 0, 2),
    "SCI_readCharNonBlocking": (1, 0, 1),
    "SCI_writeCharNonBlocking": (0, 1, 0),
    "fake_eint": (0, 0, 2),  # CLRC INTM
    "fake_dint": (0, 0, 1),
}

# Instructions that control/numeric/tmu.h and fpu.h name: published latencies, no call.
MARKED = {"tmu_sin_turns": 40, "tmu_cos_turns": 40, "tmu_sqrt": 50, "fpu_min": 10, "fpu_max": 10,
          "port_min": 10, "port_max": 10}  # fmt: skip

INSTRUCTION = re.compile(r"^\s+(?:(?P<result>%[-\w.$]+|%\"[^\"]+\")\s*=\s*)?(?P<rest>\S.*)$")
FLAGS = re.compile(r"\b(?:tail|musttail|notail|nuw|nsw|exact|inbounds|volatile|nnan|ninf|nsz|fast)\b ?")
FLOAT_CONSTANT = re.compile(r"(?<![%@\w.])(?:0x[0-9A-F]{8,16}|-?\d+\.\d+e[+-]\d+)")
EASY = re.compile(r"^0x[0-9A-F]{4}0{12}$|^-?\d\.0+e\+00$")
MEMORY = re.compile(r"@llvm\.(memcpy|memmove|memset)[^(]*\(.*?i64 (?P<size>\d+|%[-\w.]+), i1")


WIDENED = re.compile(r"^\s+(?P<result>%[-\w.$]+) = [sz]ext (?:nneg )?i(?:8|16|32) ")
OPERANDS = re.compile(r"^mul i64 (?P<a>[-%\w.$]+), (?P<b>[-%\w.$]+)")
HALF = re.compile(r"^(?:[la]shr i64 \S+, 32\b|and i64 \S+, 4294967295\b)")


def widened(line: str) -> str | None:
    """The name of a 64-bit value that this line makes of one of 32 bits or less."""
    match = WIDENED.match(line)
    return match["result"] if match is not None and " to i64" in line else None


def is_widening_product(text: str, narrow: Container[str]) -> bool:
    operands = OPERANDS.match(text)
    return operands is not None and operands["a"] in narrow and operands["b"] in narrow


def cost(line: str, narrow: Container[str] = (), in_memory: Container[str] = ()) -> int:
    """Tenths of a cycle for one instruction of LLVM's text; 0 for what is not an instruction.

    `narrow`: names of 64-bit values that hold 32 bits. `in_memory`: names of whole numbers that come from memory or go
    there.
    """
    match = INSTRUCTION.match(line)
    if match is None or line.lstrip().startswith(";"):
        return 0
    text = FLAGS.sub("", match["rest"])
    code = text.split(" ", 1)[0].rstrip(",")
    wide = " i64" in text.split(",")[0]
    if HALF.match(text) or (code == "mul" and is_widening_product(text, narrow)):
        return WIDENING_MULTIPLY if code == "mul" else CAST  # half of a register pair: it is there already
    total = 0
    if code in FLOAT:
        total = FLOAT[code]
    elif code in CONVERSION:
        if code != "bitcast" and not in_memory_conversion(match, in_memory):
            total = CONVERSION[code] * (LONG_LONG if " i64 " in f"{text} " else 1)
        else:
            total = CONVERSION_IN_MEMORY if code != "bitcast" else CONVERSION[code]
    elif code in DIVISION:
        total = LONG_LONG_DIVIDE if wide else DIVISION[code]
    elif code in INTEGER:
        total = INTEGER[code] if not wide else LONG_LONG_MULTIPLY if code == "mul" else INTEGER[code] * LONG_LONG
    elif code == "load":
        return LOAD * (2 if wide else 1)
    elif code == "store":
        total = STORE * (2 if wide else 1)
    elif code == "getelementptr":
        return CONSTANT_INDEX if not re.search(r"i(?:64|32|16) %", text) else VARIABLE_INDEX
    elif code == "br":
        return BRANCH if text.startswith("br i1") else JUMP
    elif code == "switch":
        return SWITCH
    elif code == "phi":
        return PHI
    elif code == "select":
        total = SELECT
    elif code in ("sext", "zext", "trunc", "freeze", "ptrtoint", "inttoptr"):
        return CAST
    elif code == "call":
        return call_cost(text)
    else:
        return 0
    return total + sum(0 if EASY.match(constant) else CONSTANT for constant in FLOAT_CONSTANT.findall(text))


def in_memory_conversion(match: re.Match[str], in_memory: Container[str]) -> bool:
    """Whether the whole number of this conversion lies in memory."""
    words = match["rest"].split()
    return " i64" not in match["rest"] and (match["result"] if words[0].startswith("fpto") else words[2]) in in_memory


def names_in_memory(lines: Sequence[str]) -> set[str]:
    """Of one function: whole numbers that are loaded or read from a register, and those only stored or written."""
    found: set[str] = set()
    made: dict[str, str] = {}
    for line in lines:
        match = INSTRUCTION.match(line)
        if match is None or match["result"] is None:
            continue
        text = FLAGS.sub("", match["rest"])
        name = re.search(r"@([\w.$]+)\(", text)
        if re.match(r"load (?:volatile )?i\d", match["rest"]) or (name and REGISTERS.get(name[1], (0,))[0] == 1):
            found.add(match["result"])
        elif text.startswith(("fptosi", "fptoui")):
            made[match["result"]] = ""
    for converted in made:
        word = re.compile(rf"{re.escape(converted)}(?![-\w.$])")
        uses = [line for line in lines if word.search(line) and f"{converted} = " not in line]
        if uses and all(goes_to_memory(line) for line in uses):
            found.add(converted)
    return found


def goes_to_memory(line: str) -> bool:
    called = re.search(r"@([\w.$]+)\(", line)
    return re.match(r"\s+store ", line) is not None or (called is not None and REGISTERS.get(called[1], (0, 0))[1] == 1)


def call_cost(text: str) -> int:
    block = MEMORY.search(text)
    if block is not None:
        words = int(block["size"]) // 2 if block["size"].isdigit() else 0
        return 60 + 10 * words
    name = re.search(r"@([\w.$]+)\(", text)
    if name is None:
        return CALL + 20
    if name[1].startswith("llvm."):
        if re.match(r"llvm\.(lifetime|dbg|assume|experimental|va_)", name[1]):
            return 0
        return MINMAX * (LONG_LONG if ".i64" in name[1] else 2)
    constants = sum(0 if EASY.match(constant) else CONSTANT for constant in FLOAT_CONSTANT.findall(text))
    if name[1] in MARKED:
        return MARKED[name[1]] + constants
    if name[1] in REGISTERS:
        reads, writes, beside = REGISTERS[name[1]]
        return reads * READ_REGISTER + writes * WRITE_REGISTER + 10 * beside
    return CALL
