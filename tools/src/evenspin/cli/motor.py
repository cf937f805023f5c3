"""`evenspin motor new`: from a name plate to a model file and a drive file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json

if TYPE_CHECKING:
    from evenspin.motor.resolve import Resolved

app = typer.Typer(no_args_is_help=True, help="A motor of your own: from a name plate to a model and a drive.")


def register(parent: typer.Typer) -> None:
    app.command("new")(new)
    parent.add_typer(app, name="motor")


@app.callback()
def group() -> None:
    """A motor of your own: from a name plate to a model and a drive."""


def _plate(text: str, panel: str) -> typer.models.OptionInfo:
    return typer.Option(help=text, show_default=False, rich_help_panel=panel)


MOTOR, CURRENT, SHAFT, ENCODER, BOARD = "Motor", "Currents and torque", "Shaft", "Encoder", "Supply and board"


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the model.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the files; default: NAME.", show_default=False),
    ] = None,
    pole_pairs: Annotated[int | None, _plate("Pole pairs.", MOTOR)] = None,
    poles: Annotated[int | None, _plate("Poles, twice the pole pairs.", MOTOR)] = None,
    kv: Annotated[float | None, _plate("Speed constant, r/min per V line to line, peak.", MOTOR)] = None,
    kt: Annotated[float | None, _plate("Torque constant, N m per A (--currents).", MOTOR)] = None,
    ke: Annotated[float | None, _plate("Voltage constant, V per 1000 r/min (--ke-as).", MOTOR)] = None,
    ke_as: Annotated[str, _plate("ll-rms, ll-peak, phase-rms or phase-peak.", MOTOR)] = "ll-rms",
    psi_wb: Annotated[float | None, _plate("Flux linkage, Wb, peak of a phase.", MOTOR)] = None,
    ohm_ll: Annotated[float | None, _plate("Resistance between two terminals, ohm.", MOTOR)] = None,
    ohm_phase: Annotated[float | None, _plate("Resistance of a phase, ohm.", MOTOR)] = None,
    mh_ll: Annotated[float | None, _plate("Inductance between two terminals, mH.", MOTOR)] = None,
    mh_phase: Annotated[float | None, _plate("Inductance of a phase, mH.", MOTOR)] = None,
    mh_d: Annotated[float | None, _plate("Inductance of the d axis, mH.", MOTOR)] = None,
    mh_q: Annotated[float | None, _plate("Inductance of the q axis, mH.", MOTOR)] = None,
    rated_current: Annotated[float | None, _plate("Rated current, A.", CURRENT)] = None,
    peak_current: Annotated[float | None, _plate("Peak current, A.", CURRENT)] = None,
    currents: Annotated[str, _plate("Currents and Kt are rms or peak.", CURRENT)] = "rms",
    rated_torque: Annotated[float | None, _plate("Rated torque, N m.", CURRENT)] = None,
    rated_speed: Annotated[float | None, _plate("Rated speed, r/min.", CURRENT)] = None,
    rated_power: Annotated[float | None, _plate("Rated power, W.", CURRENT)] = None,
    max_speed: Annotated[float | None, _plate("Largest speed, r/min.", CURRENT)] = None,
    gcm2: Annotated[float | None, _plate("Rotor inertia, g cm2.", SHAFT)] = None,
    kgcm2: Annotated[float | None, _plate("Rotor inertia, kg cm2.", SHAFT)] = None,
    kgm2: Annotated[float | None, _plate("Rotor inertia, kg m2.", SHAFT)] = None,
    load_kgm2: Annotated[float | None, _plate("Inertia of the load at the motor shaft, kg m2.", SHAFT)] = None,
    viscous_nms: Annotated[float | None, _plate("Viscous friction, N m s/rad.", SHAFT)] = None,
    lines: Annotated[int | None, _plate("Encoder lines per turn; a line gives four counts.", ENCODER)] = None,
    counts: Annotated[int | None, _plate("Encoder counts per turn.", ENCODER)] = None,
    bits: Annotated[int | None, _plate("Encoder bits per turn.", ENCODER)] = None,
    supply: Annotated[float | None, _plate("Dc-link voltage, V.", BOARD)] = None,
    board_current: Annotated[float | None, _plate("Largest phase current of the board, A peak.", BOARD)] = None,
    board_voltage: Annotated[float | None, _plate("Largest dc-link voltage of the board, V.", BOARD)] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """A model and a drive for a motor of your own, from its name plate in the units that are printed there.

    Without any of the numbers a terminal is asked for them. DIR/model.toml is the machine, DIR/drive.toml its drive
    with limits and first gains, DIR/first.toml a run to begin with; every number says where it comes from. What the
    plate leaves open is estimated, with a range, and marked. Numbers that contradict each other are named, and nothing
    is written.

    Example: `evenspin motor new mine --pole-pairs 7 --kv 270 --ohm-ll 0.11 --mh-ll 0.06 --lines 2048 --supply 24
    --rated-current 12`
    """
    from evenspin.motor.plate import names_of_plate
    from evenspin.output import OutputFolder
    from evenspin.tableview import print_table

    options = dict(locals())
    given: dict[str, Any] = {name: options[name] for name in names_of_plate() if options[name] is not None}
    screen = console(STDOUT if as_json else None)
    if given.keys() <= {"currents", "ke_as"} and sys.stdin.isatty() and not as_json:
        from evenspin.motor.questions import answers

        given |= answers(lambda text: typer.prompt(text, default="", show_default=False, err=True), screen.print)
    _check_name(name)
    folder = out if out is not None else Path(name)
    output = OutputFolder(folder, origin(), force=force)
    found = _resolved(given)
    texts, views = _files(name, found)
    with output as place:
        for file, text in texts.items():
            (place / file).write_text(text, encoding="utf-8")
    for view in views:
        print_table(view, screen)
    for line in found.remarks:
        screen.print(f"Note: {line}", soft_wrap=True)
    screen.print(f"{folder}/model.toml", style="bold")
    screen.print(f"Next: evenspin tune {folder}/model.toml --goal smooth --out {folder}-drive.toml", soft_wrap=True)
    if as_json:
        write_json(_json(name, folder, found), STDOUT)


def _check_name(name: str) -> None:
    from evenspin.errors import InputError

    if not name.strip() or any(c in name for c in "/\\\n\r"):
        raise InputError("motor new", "NAME", name, "a name without slashes", "give the folder with --out")


def _resolved(given: dict[str, Any]) -> Resolved:
    from evenspin.errors import EvenspinError
    from evenspin.motor.plate import Plate
    from evenspin.motor.resolve import resolve

    found = resolve(Plate(**given))
    if found.contradictions:
        count = len(found.contradictions)
        text = "; ".join(found.contradictions)
        raise EvenspinError(f"motor new: {count} contradiction{'s' * (count > 1)}, nothing was written: {text}")
    return found


def _files(name: str, found: Resolved) -> tuple[dict[str, str], list[Any]]:
    """The files by their names, and what is shown of them."""
    from evenspin.bench.schema import own_schema
    from evenspin.motor import files
    from evenspin.tableview import TableView
    from evenspin.tune.first_drive import first_drive

    first = first_drive(found)
    numbers = {key: (each.value, each.comment) for key, each in found.numbers.items()}
    numbers |= {key: (value, "a board on which the limits of the drive fit") for key, value in first.board.items()}
    head = [
        "Made by `evenspin motor new` from a name plate; every number says where it comes from.",
        "ESTIMATE: nothing on the plate says it. [range] is what each number is good for.",
    ]
    texts = {
        files.MODEL: files.model_toml(name, numbers, files.ranges_of(found), head),
        files.DRIVE: files.drive_toml(
            first.drive,
            first.comments,
            ["Limits and first gains for model.toml. `evenspin tune` makes better ones and checks them in simulation."],
            own_schema().hash,
        ),
        files.FIRST: files.first_toml(0.5 * found.max_speed_rad_s.value, 0.3 * found.plant["rated_torque_nm"]),
    }
    rows = [
        (key, f"{each.value:.5g}", _unit(key), "" if each.low == each.high else f"{each.low:.3g} .. {each.high:.3g}",
         ("ESTIMATE, " if each.estimated else "") + each.origin)
        for key, each in found.numbers.items()
    ]  # fmt: skip
    marks = ["bad" if each.estimated else "" for each in found.numbers.values()]
    text = "Red: estimated." if any(marks) else ""
    return texts, [TableView(name, text, ("number", "value", "unit", "range", "from"), rows, marks, left=1)]


def _unit(name: str) -> str:
    from evenspin.native import tables

    return tables().model[name].unit


def _json(name: str, folder: Path, found: Resolved) -> dict[str, Any]:
    return {
        "name": name,
        "model": str(folder / "model.toml"),
        "drive": str(folder / "drive.toml"),
        "plant": {
            key: {
                "value": each.value,
                "low": each.low,
                "high": each.high,
                "from": each.origin,
                "estimated": each.estimated,
            }
            for key, each in found.numbers.items()
        },
        "estimated": found.estimated,
        "remarks": list(found.remarks),
    }
