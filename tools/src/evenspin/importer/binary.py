"""Tables in the formats of measuring programs, each by its own library; a missing one is named with how to get it."""

from __future__ import annotations

import gc
import importlib
import json
import logging
import struct
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from evenspin.errors import InputError, one_line
from evenspin.importer.table import MOST_COLUMNS, Array, RawColumn, RawTable
from evenspin.importer.units import split_unit

HINT = "docs/import.md says which files can be read"
EXTRA = "pip install 'evenspin[import]'"


def read_parquet(path: Path) -> RawTable:
    parquet = _library("pyarrow.parquet", path)
    try:
        table = parquet.read_table(path)
        columns = [(str(name), _numbers(table.column(i).to_numpy())) for i, name in enumerate(table.column_names)]
    except Exception as error:  # a library's own errors, of many kinds
        raise _unreadable(path, "Parquet", error) from None
    return _table(path, "Parquet", columns)


def read_mat(path: Path) -> RawTable:
    """MATLAB v5 and v7.3. Structures are taken apart; of cells of trials the first is read, the others reported."""
    mat = _library("pymatreader", path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = mat.read_mat(str(path))
    except Exception as error:
        raise _unreadable(path, "MATLAB", error) from None
    notes: list[str] = []
    return _from_tree(path, "MATLAB", content, notes)


def read_npy(path: Path) -> RawTable:
    try:
        with np.load(path, allow_pickle=False) as found:
            content: Any = {name: found[name] for name in found.files} if hasattr(found, "files") else None
    except TypeError:  # a single array is no context manager
        content = np.load(path, allow_pickle=False)
    except Exception as error:
        raise _unreadable(path, "NumPy", error) from None
    if content is None:
        content = np.load(path, allow_pickle=False)
    if isinstance(content, np.ndarray) and content.dtype.names:
        content = {name: content[name] for name in content.dtype.names}
    return _from_tree(path, "NumPy", content if isinstance(content, Mapping) else {"": content}, [])


def read_mdf(path: Path) -> RawTable:
    """MDF 3 and 4: the channels of the group with most rows."""
    asammdf = _library("asammdf", path)
    failed: InputError | None = None
    groups: list[list[Any]] = []
    try:
        with asammdf.MDF(str(path)) as file:
            for index in range(len(file.groups)):
                names = [channel.name for channel in file.groups[index].channels]
                signals = [file.get(name, group=index) for name in names]
                groups.append([s for s in signals if np.asarray(s.samples).dtype.kind in "fiu"])
    except Exception as error:
        failed = _unreadable(path, "MDF", error)
    if failed is not None:
        _forget_silently()
        raise failed
    groups = [signals for signals in groups if signals]
    if not groups:
        raise InputError(path, "channels", 0, "at least one of numbers", HINT)
    best = max(groups, key=lambda signals: (len(signals), len(signals[0].samples)))
    rows = len(best[0].samples)
    columns = [RawColumn("time", "s", np.asarray(best[0].timestamps, dtype=np.float64))]
    for signal in best:
        if len(signal.samples) == rows and np.asarray(signal.samples).ndim == 1:
            name, unit = split_unit(signal.name)
            if name.lower() not in ("t", "time", "timestamps") and name != "time":
                columns.append(RawColumn(name, signal.unit or unit, np.asarray(signal.samples, dtype=np.float64)))
    notes = (f"one of {len(groups)} groups of channels, the largest",) if len(groups) > 1 else ()
    return RawTable(path, "MDF", tuple(columns), None, notes)


def read_tdms(path: Path) -> RawTable:
    """LabVIEW: the group with most channels; a waveform's increment is the rate."""
    tdms = _library("nptdms", path)
    logging.disable()  # what it logs is in the error
    try:
        file = tdms.TdmsFile.read(str(path))
        groups = [[(c.name, dict(c.properties), _numbers(c[:])) for c in group.channels()] for group in file.groups()]
    except Exception as error:
        raise _unreadable(path, "TDMS", error) from None
    finally:
        logging.disable(logging.NOTSET)
    groups = [[item for item in group if len(item[2])] for group in groups]
    best = max(groups, key=len, default=[])
    if not best:
        raise InputError(path, "channels", 0, "at least one of numbers", HINT)
    rows = max(len(values) for _, _, values in best)
    columns, rate = [], None
    for name, properties, values in best:
        if len(values) == rows:
            plain, unit = split_unit(name)
            columns.append(RawColumn(plain, str(properties.get("unit_string", "") or unit), values))
            increment = properties.get("wf_increment")
            if isinstance(increment, float) and increment > 0.0:
                rate = 1.0 / increment
    notes = (f"one of {len(groups)} groups of channels, the largest",) if len(groups) > 1 else ()
    return RawTable(path, "TDMS", tuple(columns), rate, notes)


def read_mcap(path: Path) -> RawTable:
    """Messages in JSON: one row a message, of the topic with most messages; time is the log's."""
    from mcap.exceptions import McapError
    from mcap.stream_reader import StreamReader

    topics: dict[int, tuple[str, str]] = {}
    rows: dict[str, list[tuple[float, dict[str, float]]]] = {}
    own = False
    try:
        with path.open("rb") as file:
            for record in StreamReader(file).records:
                kind = type(record).__name__
                if kind == "Channel":
                    topics[record.id] = (record.topic, record.message_encoding)  # type: ignore[attr-defined]
                    own = own or record.message_encoding == "evenspin-rows"  # type: ignore[attr-defined]
                elif kind == "Message" and topics.get(record.channel_id, ("", ""))[1] == "json":  # type: ignore[attr-defined]
                    content = json.loads(record.data)  # type: ignore[attr-defined]
                    numbers = dict(_leaves("", content))
                    rows.setdefault(topics[record.channel_id][0], []).append((1e-9 * record.log_time, numbers))  # type: ignore[attr-defined]
    except (McapError, ValueError, EOFError, struct.error) as error:
        raise _unreadable(path, "MCAP", error) from None
    if own:
        raise InputError(path, "file", "(a raw recording of evenspin)", "its CSV", "`evenspin bench convert` makes it")
    if not rows:
        kinds = ", ".join(sorted({encoding for _, encoding in topics.values()})) or "none"
        raise InputError(path, "messages", kinds, "in JSON", "export them as CSV")
    messages = max(rows.values(), key=len)
    names = list(dict.fromkeys(name for _, numbers in messages for name in numbers))
    columns = [("time [s]", np.array([t for t, _ in messages]))]
    columns += [(name, np.array([numbers.get(name, np.nan) for _, numbers in messages])) for name in names]
    return _table(path, "MCAP", columns)


def _leaves(prefix: str, content: Any) -> Iterator[tuple[str, float]]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from _leaves(f"{prefix}.{key}" if prefix else str(key), value)
    elif isinstance(content, int | float) and not isinstance(content, bool):
        yield prefix, float(content)


def _from_tree(path: Path, kind: str, content: Mapping[str, Any], notes: list[str]) -> RawTable:
    """Arrays of equal length from nested structures; a matrix is as many columns as it has."""
    found: list[tuple[str, Array]] = []
    rate = None
    for name, value in _arrays("", content, notes):
        if value.size == 1:
            if name.split(".")[-1].lower() in ("fs", "fs_hz", "rate_hz", "sample_rate", "samplerate", "fsample"):
                rate = float(value.ravel()[0])
            elif name.split(".")[-1].lower() in ("ts", "dt", "ts_s", "dt_s", "sample_time") and value.ravel()[0] > 0.0:
                rate = 1.0 / float(value.ravel()[0])
            continue
        flat = np.squeeze(value)
        if flat.ndim == 1:
            found.append((name, flat))
        elif flat.ndim == 2:
            long = flat if flat.shape[0] >= flat.shape[1] else flat.T
            found += [
                (f"{name}.{i + 1}" if name else f"column {i + 1}", long[:, i])
                for i in range(min(long.shape[1], MOST_COLUMNS))
            ]
    if not found:
        raise InputError(path, "arrays", 0, "at least one of numbers", HINT)
    lengths = [len(values) for _, values in found]
    rows = max(set(lengths), key=lambda length: (lengths.count(length), length))
    left = [name for name, values in found if len(values) != rows]
    if left:
        notes.append(f"arrays of another length are left out: {', '.join(left[:8])}")
    return _table(path, kind, [(name, values) for name, values in found if len(values) == rows], rate, notes)


def _arrays(prefix: str, content: Any, notes: list[str]) -> Iterator[tuple[str, Array]]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            if not str(key).startswith("__"):
                yield from _arrays(f"{prefix}.{key}" if prefix else str(key), value, notes)
    elif isinstance(content, list) and content and not np.isscalar(content[0]):
        if len(content) > 1:
            notes.append(f"{prefix}: the first of {len(content)} trials is read")
        yield from _arrays(prefix, content[0], notes)
    else:
        values = np.asarray(content)
        if values.dtype.kind in "fiub" and values.size:
            yield prefix, np.asarray(values, dtype=np.float64)


def _table(
    path: Path, kind: str, columns: Sequence[tuple[str, Array]], rate: float | None = None, notes: Sequence[str] = ()
) -> RawTable:
    if len(columns) > MOST_COLUMNS:
        raise InputError(path, "columns", len(columns), f"at most {MOST_COLUMNS}", HINT)
    named = [(*split_unit(name), values) for name, values in columns]
    kept = [RawColumn(name, unit, np.ascontiguousarray(values, dtype=np.float64)) for name, unit, values in named]
    return RawTable(path, kind, tuple(kept), rate, tuple(notes))


def _numbers(values: Any) -> Array:
    """Numbers as they are, times of day in seconds, anything else as not-a-number."""
    array = np.asarray(values)
    if array.dtype.kind == "M":
        return np.asarray(array.astype("datetime64[ns]").astype(np.int64) * 1e-9, dtype=np.float64)
    if array.dtype.kind == "m":
        return np.asarray(array.astype("timedelta64[ns]").astype(np.int64) * 1e-9, dtype=np.float64)
    if array.dtype.kind in "fiub":
        return np.asarray(array, dtype=np.float64)
    return np.full(len(array), np.nan)


def _library(name: str, path: Path) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.split(".")[0]
        raise InputError(
            path, "file", path.suffix, f"readable: the package {package} is not installed", EXTRA
        ) from None


def _forget_silently() -> None:
    """A reader that failed in its constructor fails again when it is deleted, and Python prints that."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda _: None
    try:
        gc.collect()
    finally:
        sys.unraisablehook = hook


def _unreadable(path: Path, kind: str, error: Exception) -> InputError:
    said = one_line(str(error))[:80] or type(error).__name__
    return InputError(path, "file", f"({said})", f"a readable {kind} file", HINT)
