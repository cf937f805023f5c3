"""Instructions of LLVM's text as the classes of the cost table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from evenspin.cycles.layout import Layout

FLOAT = {"fadd": "fop", "fsub": "fop", "fmul": "fop", "fneg": "fneg", "fdiv": "fdiv", "frem": "frem", "fcmp": "fcmp"}
CONVERSION = {"fptosi": "f2i", "fptoui": "f2i", "sitofp": "i2f", "uitofp": "i2f"}
INTEGER = dict.fromkeys(("add", "sub", "and", "or", "xor", "mul"), "iop")
INTEGER |= {"shl": "shift", "lshr": "shift", "ashr": "shift", "icmp": "icmp"}
LONG = {"iop": "lop", "shift": "lshift", "icmp": "lcmp"}
DIVISION = ("sdiv", "udiv", "srem", "urem")
CASTS = ("sext", "zext", "trunc", "freeze", "ptrtoint", "inttoptr")

# Functions of driverlib in the interrupts: registers that they read and write, instructions beside. They are inline
# with constant arguments, so nothing else is left of them.
REGISTERS = {
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
    "port_take": (0, 0, 3),  # a word by its address: MOVL XAR, MOV
    "port_put": (0, 0, 3),
    "SCI_getRxStatus": (1, 0, 0),
    "SCI_getOverflowStatus": (1, 0, 2),
    "SCI_getRxFIFOStatus": (1, 0, 2),
    "SCI_getTxFIFOStatus": (1, 0, 2),
    "SCI_readCharNonBlocking": (1, 0, 1),
    "SCI_writeCharNonBlocking": (0, 1, 0),
    "fake_eint": (0, 0, 2),  # CLRC INTM
    "fake_dint": (0, 0, 1),
}

# Instructions that control/numeric/tmu.h and fpu.h name: no call.
MARKED = {"tmu_sin_turns": "tmu", "tmu_cos_turns": "tmu", "tmu_sqrt": "sqrt", "fpu_min": "minmax", "fpu_max": "minmax",
          "port_min": "minmax", "port_max": "minmax"}  # fmt: skip

INSTRUCTION = re.compile(r"^\s+(?:(?P<result>%[-\w.$]+|%\"[^\"]+\")\s*=\s*)?(?P<rest>[a-z]\S*.*)$")
FLAGS = re.compile(r"\b(?:tail|musttail|notail|nuw|nsw|exact|inbounds|volatile|nnan|ninf|nsz|fast|nneg|disjoint)\b ?")
FLOAT_CONSTANT = re.compile(r"(?<![%@\w.])(?:0x[0-9A-F]{16}|-?\d+\.\d+e[+-]\d+)")
MEMORY = re.compile(r"@llvm\.(?:memcpy|memmove|memset)[^(]*\(.*?i(?:32|64) (?P<size>\d+|%[-\w.]+), i1")
WIDENED = re.compile(r"^\s+(?P<result>%[-\w.$]+) = [sz]ext (?:nneg )?i(?:8|16|32) .* to i64")
OPERANDS = re.compile(r"^mul i64 (?P<a>[-%\w.$]+), (?P<b>[-%\w.$]+)")
HALF = re.compile(r"^(?:[la]shr i64 \S+, 32\b|and i64 \S+, 4294967295\b)")
CALLED = re.compile(r"@([\w.$]+)\(")
INDEX = re.compile(r"i64 (%[-\w.$]+)")


def is_easy(constant: str) -> bool:
    """Whether the low half of this float constant is zero, so that one instruction makes it or it is an operand."""
    import struct

    if constant.startswith("0x"):
        value = struct.unpack(">d", bytes.fromhex(constant[2:]))[0]
    else:
        value = float(constant)
    try:
        return struct.unpack(">I", struct.pack(">f", value))[0] & 0xFFFF == 0
    except OverflowError:
        return False


def result_and_text(line: str) -> tuple[str | None, str]:
    """Name of the result and the instruction without flags; empty for what is none."""
    match = INSTRUCTION.match(line)
    if match is None or line.lstrip().startswith(";"):
        return None, ""
    return match["result"], FLAGS.sub("", match["rest"])


@dataclass
class Function:
    """What one instruction cannot say by itself: names of values by where they come from and go to."""

    layout: Layout
    narrow: set[str] = field(default_factory=set)  # 64-bit values that hold 32 bits
    in_memory: set[str] = field(default_factory=set)  # whole numbers from memory, or only stored
    indices: set[str] = field(default_factory=set)  # 64-bit values that only choose an address: 32 bits on the C28x

    @classmethod
    def read(cls, lines: Sequence[str], layout: Layout) -> Function:
        return cls(layout, narrow_values(lines), names_in_memory(lines), index_values(lines))

    def classes(self, line: str) -> Counter[str]:
        """Classes of one line, and how many of each."""
        result, text = result_and_text(line)
        code = text.split(" ", 1)[0].rstrip(",")
        if not text:
            return Counter()
        if code == "call":
            return called(text)
        if code in ("load", "store"):
            return self.memory(line, code, text)
        found: Counter[str] = Counter()
        name = self.arithmetic(code, text, result)
        if name:
            found[name] = 1
        elif code == "getelementptr":
            return self.layout.address(text)
        elif code == "br":
            found["brc" if text.startswith("br i1") else "bru"] = 1
        elif code in ("switch", "phi", "select"):
            found[code] = 1
        if code in FLOAT or (code == "select" and "float" in text):
            found["fhard"] += sum(not is_easy(constant) for constant in FLOAT_CONSTANT.findall(text))
        return +found

    def arithmetic(self, code: str, text: str, result: str | None) -> str | None:
        """The class of a calculation."""
        wide = re.match(r"(?:icmp \w+|\w+) i64 ", text) is not None and result not in self.indices
        if code == "icmp" and text.split()[3].rstrip(",") in self.narrow:
            wide = False
        if code in FLOAT:
            return FLOAT[code]
        if code in CONVERSION:
            if " i64" in text:
                return "lconv"
            word = text.split()[2]
            return "convmem" if (result if code.startswith("fpto") else word) in self.in_memory else CONVERSION[code]
        if code == "bitcast":
            return "moved" if "float" in text and "<" not in text else None
        if code in DIVISION:
            by_constant = re.search(r", \d+$", text.split(", !")[0]) is not None
            return "ldiv" if wide else "idivk" if by_constant else "idiv"
        if HALF.match(text):
            return "cast"  # half of a register pair: it is there already
        if code in INTEGER:
            if wide and code == "mul":
                operands = OPERANDS.match(text)
                product = operands is not None and {operands["a"], operands["b"]} <= self.narrow
                return "lwide" if product else "lmul"
            return LONG[INTEGER[code]] if wide else INTEGER[code]
        return "cast" if code in CASTS else None

    def memory(self, line: str, code: str, text: str) -> Counter[str]:
        """A load or a store."""
        found = Counter({"mem": 2 if re.match(r"(?:load|store) i64", text) else 1})
        found["vol"] = int("load volatile " in line)
        found["glob"] = int(re.search(r"ptr (?:@|getelementptr [^%]*@)", text) is not None)
        found["ldptr"] = int(text.startswith("load ptr"))
        if code == "store":
            kind, value = text.split()[1], text.split()[2].rstrip(",")
            if kind == "float" and not value.startswith("%"):
                found["kmove" if value == "undef" or is_easy(value) else "kmove2"] = 1
            elif re.match(r"-?\d|true|false|null", value):
                found["stk32" if kind in ("i32", "i64", "ptr") else "stk16"] = 1
        return +found


def narrow_values(lines: Sequence[str]) -> set[str]:
    """Values of 64 bits that hold 32: what was widened, by whichever path it came."""
    found = {match["result"] for match in map(WIDENED.match, lines) if match is not None}
    for line in lines:
        result, text = result_and_text(line)
        if result is not None and HALF.match(text):
            found.add(result)
        if result is not None and text.startswith("phi i64"):
            sources = re.findall(r"\[ ([^,\s]+),", text)
            if all(source in found or source.isdigit() for source in sources):
                found.add(result)
    return found


def names_in_memory(lines: Sequence[str]) -> set[str]:
    """Whole numbers of one function that are loaded or read from a register, and those only stored or written."""
    found: set[str] = set()
    made: list[str] = []
    for line in lines:
        result, text = result_and_text(line)
        if result is None:
            continue
        name = CALLED.search(text)
        if re.match(r"load i\d", text) or (name and REGISTERS.get(name[1], (0,))[0] == 1):
            found.add(result)
        elif text.startswith(("fptosi", "fptoui")):
            made.append(result)
    for converted in made:
        uses = list(uses_of(converted, lines))
        if uses and all(goes_to_memory(line) for line in uses):
            found.add(converted)
    return found


def uses_of(name: str, lines: Iterable[str]) -> Iterable[str]:
    word = re.compile(rf"{re.escape(name)}(?![-\w.$])")
    return (line for line in lines if word.search(line) and f"{name} = " not in line)


def goes_to_memory(line: str) -> bool:
    name = CALLED.search(line)
    return re.match(r"\s+store ", line) is not None or (name is not None and REGISTERS.get(name[1], (0, 0))[1] == 1)


def index_values(lines: Sequence[str]) -> set[str]:
    """Values of 64 bits that end in addresses only: pointers have 32 bits on the C28x."""
    reached: set[str] = set()
    for line in lines:
        if " = getelementptr " in line:
            reached.update(INDEX.findall(line))
    texts = {result: text for result, text in map(result_and_text, lines) if result is not None}
    grown = True
    while grown:
        grown = False
        for name in tuple(reached):
            text = texts.get(name, "")
            if re.match(r"(?:add|sub|shl|or|and|phi|select i1 \S+,|mul) i64", text):
                operands = set(re.findall(r"%[-\w.$]+", text.split(", !")[0])) & texts.keys()
                more = {operand for operand in operands if " i64" in f" {texts[operand]}" and operand not in reached}
                grown = grown or bool(more)
                reached |= more
    return reached


def called(text: str) -> Counter[str]:
    """A call: of a function, or of what stands for instructions."""
    block = MEMORY.search(text)
    if block is not None:
        return Counter({"block": 1, "blockword": int(block["size"]) // 2 if block["size"].isdigit() else 0})
    name = CALLED.search(text)
    if name is not None and name[1].startswith("llvm."):
        if re.match(r"llvm\.(lifetime|dbg|assume|experimental|va_)", name[1]):
            return Counter()
        if name[1].startswith("llvm.fabs"):
            return Counter({"fneg": 1})
        return Counter({"intrin": 2 if ".i64" in name[1] else 1})
    constants = FLOAT_CONSTANT.findall(text)
    if name is not None and name[1] in MARKED:
        return +Counter({MARKED[name[1]]: 1, "fhard": sum(not is_easy(constant) for constant in constants)})
    if name is not None and name[1] in REGISTERS:
        reads, writes, beside = REGISTERS[name[1]]
        return +Counter({"regread": reads, "regwrite": writes, "lock": beside})
    easy = sum(is_easy(constant) for constant in constants)
    return +Counter({"call": 1, "args": arguments(text), "pointed": int(name is None), "kmove": easy,
                     "kmove2": len(constants) - easy})  # fmt: skip


def arguments(text: str) -> int:
    """How many arguments the call has."""
    inside = text[text.index("(") + 1 : text.rindex(")")]
    depth, count = 0, 1 if inside.strip() else 0
    for letter in inside:
        depth += (letter in "([{<") - (letter in ")]}>")
        count += letter == "," and depth == 0
    return count
