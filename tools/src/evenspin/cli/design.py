"""`evenspin design rc|aro|ripple|rdc`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.design_aro import design_aro
from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, output_file, write_json

app = typer.Typer(no_args_is_help=True, help="Design of controllers: margins and bounds before anything turns.")

Number = float | None


def register(parent: typer.Typer) -> None:
    app.command("aro")(design_aro)
    parent.add_typer(app, name="design")


@app.callback()
def group() -> None:
    """Design of controllers: margins and bounds before anything turns."""


def _option(text: str, min: int | None = None, max: int | None = None) -> typer.models.OptionInfo:
    return typer.Option(help=text, show_default="from the model", min=min, max=max)


@app.command("rc")
def design_rc(
    model: Annotated[str, typer.Option(help="A model file .toml, or a built-in model.")] = "guo2024",
    k_rc: Annotated[Number, _option("Learning gain k_rc, no unit.")] = None,
    lead: Annotated[int | None, _option("Phase lead m, samples.", min=0, max=15)] = None,
    q_side: Annotated[Number, _option("Taps beside the middle one of Q(z), no unit.")] = None,
    q_centre: Annotated[Number, _option("Middle tap of Q(z), no unit.")] = None,
    q_side2: Annotated[Number, _option("Taps of Q(z) two samples away, no unit; 0: three taps.")] = None,
    order: Annotated[int | None, _option("Order of the interpolation.", min=1, max=3)] = None,
    fal: Annotated[bool, typer.Option(help="With fal: bounds are divided by its largest gain.")] = False,
    inertia_kgm2: Annotated[Number, _option("Total inertia, kg m^2.")] = None,
    viscous_nms: Annotated[Number, _option("Viscous friction, N m s/rad.")] = None,
    torque_per_a_nm: Annotated[Number, _option("Torque constant 1.5 p psi, N m/A.")] = None,
    kp: Annotated[Number, _option("Proportional gain of the speed loop, A per unit of the error.")] = None,
    ki: Annotated[Number, _option("Integral gain of the speed loop, A per unit and s.")] = None,
    error_gain: Annotated[
        Number, _option("Unit of the speed error: 1: rad/s, pole pairs: electrical, 9.55: rpm.")
    ] = None,
    bandwidth_rad_s: Annotated[Number, _option("Bandwidth of the current loop, rad/s.")] = None,
    delay_s: Annotated[float, typer.Option(help="Delay of the loop beyond the hold of the speed controller, s.")] = 0.0,
    speed_rpm: Annotated[float, typer.Option(help="Speed whose ripple the controller is tuned to, rpm.")] = 307.0,
    gain_at: Annotated[
        list[float] | None,
        typer.Option(help="Frequency for |1 + G_RC|, Hz; may be repeated.", show_default="ripple and CRC period"),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Bode plots: FILE.svg or FILE.png.")] = None,
    json_file: JsonFile = None,
) -> None:
    """Stability of a speed loop, and of a repetitive controller in it. Exit status 1 when it is not stable.

    M is the closed speed loop without it; |Q (1 - k_rc z^m M)| < 1 at every frequency is stable at every speed. The
    verdict is that of the loop as the drive runs it, and must hold for gains 5 % off.

    Example: `evenspin design rc --k-rc 0.525 --gain-at 20.83 --gain-at 20.47`
    """
    from evenspin.design.command import Choices, prepare, tables_of
    from evenspin.report.plotfile import check_plot_file
    from evenspin.tableview import print_table

    check_json_file(json_file)
    if plot is not None:
        check_plot_file(plot)
    choices = Choices(
        gain=k_rc,
        lead=lead,
        q_side=q_side,
        q_centre=q_centre,
        q_side2=q_side2,
        order=order,
        fal=fal,
        inertia_kgm2=inertia_kgm2,
        viscous_nms=viscous_nms,
        torque_per_a_nm=torque_per_a_nm,
        kp_a_per_unit=kp,
        ki_a_per_unit_s=ki,
        error_gain=error_gain,
        current_bandwidth_rad_s=bandwidth_rad_s,
        delay_s=delay_s,
        speed_rpm=speed_rpm,
        gain_at_hz=tuple(gain_at or ()),
    )
    drawn = output_file(plot, "--plot", model) if plot is not None else None
    work = prepare(model, choices)
    screen = console(json_file)
    for view in tables_of(work):
        print_table(view, screen)
    if drawn is not None:
        from evenspin.design.plots import write_bode

        with drawn as place:
            write_bode(place, work.found or work.first_order)
        screen.print(str(plot), style="bold")
    if json_file is not None:
        write_json(work.as_json(), json_file)
    if not work.stable:
        raise typer.Exit(1)


@app.command("ripple")
def design_ripple(
    model: Annotated[str, typer.Option(help="A model file .toml, or a built-in model.")] = "guo2024",
    offset_a: Annotated[Number, _option("Offset of the sensor of phase a, A.")] = None,
    offset_b: Annotated[Number, _option("Offset of the sensor of phase b, A.")] = None,
    gain_a: Annotated[Number, _option("Gain of the sensor of phase a.")] = None,
    gain_b: Annotated[Number, _option("Gain of the sensor of phase b.")] = None,
    iq_a: Annotated[float, typer.Option("--iq-a", help="Mean q current, A.")] = 1.0,
    speed_rpm: Annotated[
        list[float] | None,
        typer.Option(help="Speed, rpm; may be repeated.", show_default="150, 203, 255, 295"),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """What errors of the current sensors do to the speed under PI control, and the speed at which it is worst.

    Example: `evenspin design ripple --offset-a 0.1 --gain-b 0.97 --iq-a 3.5`
    """
    from evenspin.design.ripple import SPEEDS_RPM, prepare, tables_of
    from evenspin.tableview import print_table

    check_json_file(json_file)
    given = {"offset_a_a": offset_a, "offset_b_a": offset_b, "gain_a": gain_a, "gain_b": gain_b}
    found = prepare(model, iq_a, tuple(speed_rpm or SPEEDS_RPM), given)
    for view in tables_of(found):
        print_table(view, console(json_file))
    if json_file is not None:
        write_json(found.as_json(), json_file)


@app.command("rdc")
def design_rdc(
    model: Annotated[str, typer.Option(help="A model file .toml, or a built-in model.")] = "yeh2024",
    kpp: Annotated[Number, _option("Gain of the position controller k_pp, 1/s.")] = None,
    kvp: Annotated[Number, _option("Gain of the velocity controller k_vp, A s/rad.")] = None,
    ti: Annotated[Number, _option("Integral time of the velocity controller T_i, s.")] = None,
    torque_per_a_nm: Annotated[Number, _option("Torque constant K_t = 1.5 p psi, N m/A.")] = None,
    inertia_kgm2: Annotated[Number, _option("Inertia J, kg m^2.")] = None,
    viscous_nms: Annotated[Number, _option("Viscous friction B, N m s/rad.")] = None,
    rho: Annotated[Number, _option("Bound of the robust term, N m.")] = None,
    sigma: Annotated[Number, _option("Half width of its linear part.")] = None,
    q: Annotated[float, typer.Option(help="Q = q I of the Lyapunov equation.")] = 1.0,
    delay_samples: Annotated[int | None, _option("Delay of the torque command, samples.", min=0, max=7)] = None,
    identified: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="JSON of `evenspin identify`: does rho cover what its intervals leave open?"),
    ] = None,
    speed_rpm: Annotated[Number, _option("With --identified: fastest speed of the axis, r/min; 20.")] = None,
    accel_rad_s2: Annotated[
        Number, _option("With --identified: largest acceleration of the command, rad/s^2; 0.")
    ] = None,
    turns: Annotated[Number, _option("With --identified: turns of a motion, over which lines drift; 10.")] = None,
    json_file: JsonFile = None,
) -> None:
    """The Lyapunov matrix of robust driving control, stability, and the robust term against chatter.

    Prints the drive parameters to paste. A rho / sigma that chatters with this delay is warned of, one that chatters
    without any delay is refused.

    Example: `evenspin design rdc --rho 0.15 --sigma 0.02`
    """
    from evenspin.design.rdc_command import drive_text, prepare, tables_of, uncertainty_of
    from evenspin.design.source import calculated_with
    from evenspin.tableview import print_table

    check_json_file(json_file)
    choices = {
        "kpp_per_s": kpp,
        "kvp_a_per_rad_s": kvp,
        "ti_s": ti,
        "torque_per_a_nm": torque_per_a_nm,
        "inertia_kgm2": inertia_kgm2,
        "viscous_nms": viscous_nms,
        "delay_samples": delay_samples,
        "rho_nm": rho,
        "sigma": sigma,
        "q": q,
    }
    found = prepare(model, choices)
    left_open = uncertainty_of(identified, speed_rpm, accel_rad_s2, turns)
    screen = console(json_file)
    for view in tables_of(found, left_open):
        print_table(view, screen)
    screen.print(drive_text(found))
    names = ("inertia_kgm2", "viscous_nms", "psi_wb", "position_kp_per_s", "position_kv_a_per_rad_s", "position_ti_s")
    given = dict(zip(names, (inertia_kgm2, viscous_nms, torque_per_a_nm, kpp, kvp, ti), strict=True))
    screen.print(calculated_with(model, names, given), soft_wrap=True)
    if json_file is not None:
        content = found.as_json()
        write_json(content | ({"uncertainty": left_open.as_json()} if left_open is not None else {}), json_file)
