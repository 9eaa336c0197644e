"""The commands."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

import pinmech as pm
from pinmech.cli import values as typed
from pinmech.cli.arguments import (
    Joints,
    Json,
    Modes,
    Name,
    NoLimits,
    Outputs,
    Seconds,
    load_mechanism,
    print_answer,
    print_json,
    read_modes,
    read_outputs,
    read_pose,
)
from pinmech.description.library import find_description
from pinmech.description.schema import json_schema
from pinmech.description.source import read_file
from pinmech.errors import InputError
from pinmech.files.names import slug
from pinmech.show import quantities, records
from pinmech.show.terminal.console import console, table
from pinmech.show.terminal.info import print_info
from pinmech.show.terminal.mobility import print_mobility
from pinmech.show.terminal.singularity import print_singularity

app = typer.Typer(
    name="pinmech",
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def root(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    """Closed-loop pointing and orienting mechanisms, from the drawing to the actuator table.

    Angles are in degrees and lengths in mm, typed and printed, unless you type
    a unit: alpha=10, alpha=0.1rad, z=12mm, z=0.012m. With --json all is in SI
    units and radians.

    \b
    [bold]Examples[/bold]
      pinmech list
      pinmech info antenna_3rsu
      pinmech inverse antenna_3rsu alpha=10 beta=5
      pinmech forward antenna_3rsu arm1=30 arm2=60
      pinmech singularity antenna_3rsu alpha=10 beta=5 --drive 12
      pinmech mobility antenna_3rsu
      pinmech size antenna_relay --out out
      pinmech view antenna_3rsu alpha=10 beta=5 --out page.html

    \b
    [bold]Exit codes[/bold]
      0  done
      1  there is no answer: out of reach, beyond a limit, singular (size: in every row)
      2  the input cannot be used; the message says what to change
    """
    if version:
        sys.stdout.write(f"pinmech {pm.__version__}\n")
        raise typer.Exit


@app.command("list")
def list_command(as_json: Json = False) -> None:
    """List the built-in mechanisms."""
    titles = {n: read_file(find_description(n)).description.title for n in pm.mechanisms()}
    if as_json:
        print_json([{"name": name, "title": title} for name, title in titles.items()])
    else:
        console().print(table(("name", "title"), titles.items(), ()))


@app.command()
def info(name: Name, seconds: Seconds = None, as_json: Json = False) -> None:
    """Say what a mechanism is: outputs, actuators, drives, loops, cones, limbs, home."""
    mechanism = load_mechanism(name, seconds)
    if as_json:
        print_json(records.info_record(mechanism))
    else:
        print_info(mechanism, console())


@app.command()
def inverse(
    *,
    name: Name,
    outputs: Outputs = None,
    mode: Modes = None,
    no_limits: NoLimits = False,
    seconds: Seconds = None,
    joints: Joints = False,
    as_json: Json = False,
) -> None:
    """Inverse kinematics: the actuator values at given outputs.

    The answer is in the working mode of the home pose unless --mode says otherwise.

    \b
    pinmech inverse antenna_3rsu alpha=10 beta=5
    pinmech inverse antenna_3rsu alpha=0.4rad beta=-12.6 --mode arm1=-1
    """
    mechanism = load_mechanism(name, seconds)
    target = read_outputs(mechanism, outputs)
    solution = pm.inverse(mechanism, target, mode=read_modes(mode), limits=not no_limits)
    print_answer(mechanism, solution, joints=joints, as_json=as_json)


@app.command()
def forward(
    *,
    name: Name,
    actuators: Annotated[
        list[str] | None,
        typer.Argument(metavar="ACTUATOR=VALUE", help="Values in deg or mm, or as 0.1rad."),
    ] = None,
    no_limits: NoLimits = False,
    seconds: Seconds = None,
    joints: Joints = False,
    as_json: Json = False,
) -> None:
    """Forward kinematics: the outputs at given actuator values.

    Give any actuators that determine the pose, or more, if they agree. The answer is the pose
    that the mechanism reaches from home when the actuators move there in a straight line.

    \b
    pinmech forward antenna_3rsu arm1=30 arm2=60
    """
    mechanism = load_mechanism(name, seconds)
    given = typed.values(actuators or [], quantities.actuators(mechanism), "actuator")
    solution = pm.forward(mechanism, given, limits=not no_limits)
    print_answer(mechanism, solution, joints=joints, as_json=as_json)


@app.command()
def singularity(
    *,
    name: Name,
    outputs: Outputs = None,
    drive: Annotated[
        str | None,
        typer.Option("--drive", metavar="DRIVE", help="A drive of the mechanism; see info."),
    ] = None,
    mode: Modes = None,
    no_limits: NoLimits = False,
    seconds: Seconds = None,
    as_json: Json = False,
) -> None:
    """Which singularities a pose is at, or how near: kinds, distances, directions.

    Without outputs: at home. Without --drive: the drive with the most actuators.

    \b
    pinmech singularity antenna_3rsu alpha=10 beta=5 --drive 12
    """
    mechanism = load_mechanism(name, seconds)
    mechanism.drive(drive)
    state = read_pose(mechanism, outputs, mode, no_limits)
    found = pm.singularity(state, drive=drive)
    if as_json:
        print_json(records.singularity_record(state, found))
    else:
        print_singularity(state, found, console())


@app.command()
def mobility(
    *,
    name: Name,
    outputs: Outputs = None,
    lock: Annotated[
        list[str] | None,
        typer.Option("--lock", metavar="JOINT", help="Take this joint as welded. May be repeated."),
    ] = None,
    mode: Modes = None,
    no_limits: NoLimits = False,
    seconds: Seconds = None,
    as_json: Json = False,
) -> None:
    """How many ways a pose can move, from the rank of its loop closures; limb by limb.

    Without outputs: at home.

    \b
    pinmech mobility spherical_3paur
    pinmech mobility antenna_3rsu alpha=10 beta=5 --lock arm1
    """
    mechanism = load_mechanism(name, seconds)
    state = read_pose(mechanism, outputs, mode, no_limits)
    found, screws = pm.mobility(state, locked=lock or ()), pm.limb_screws(state)
    if as_json:
        print_json(records.mobility_record(state, found, screws))
    else:
        print_mobility(state, found, screws, console())


@app.command()
def size(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="A case file, or the name of a built-in case.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the files; made if need be.")
    ] = Path("out"),
) -> None:
    """Torque and actuator sizing table of a case: torques, speeds, power, work.

    Prints the tables; writes them as CSV, Markdown and HTML (sizing_CASE), with plots of the
    torques (torque_CASE.LOADCASE.png) and a page that shows the first load case in motion
    (view_CASE.LOADCASE.html). The files of several cases may lie in one folder.

    Exits with 0 when at least one row of the table has numbers, with a warning when others have
    none (a drive at a singularity, a pose out of reach), and with 1 when no row has.

    \b
    pinmech size antenna_relay
    pinmech size scripts/cases/antenna_relay.yaml --out out/relay
    """
    from pinmech.show.report import report, shortfall

    sized = report(case, out, console())
    if lacking := shortfall(sized):
        nothing = sized.failed == len(sized.rows)
        sys.stderr.write(f"pinmech: {'' if nothing else 'warning: '}{lacking}\n")
        if nothing:
            raise typer.Exit(1)


@app.command()
def view(
    *,
    name: Name,
    outputs: Outputs = None,
    trajectory: Annotated[
        Path | None,
        typer.Option("--trajectory", metavar="CSV", help="Follow this file: time, then outputs."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="HTML", help="The page; default NAME.html.")
    ] = None,
    show_it: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
    mode: Modes = None,
    no_limits: NoLimits = False,
    seconds: Seconds = None,
) -> None:
    """Write a page that shows the mechanism in 3D; it works offline.

    At home, at given outputs, or following a trajectory file.

    \b
    pinmech view antenna_3rsu
    pinmech view antenna_3rsu alpha=10 beta=5 --out page.html --open
    pinmech view antenna_3rsu --trajectory scripts/trajectories/relay_iss.csv
    """
    from pinmech.show.scene.pages import view_trajectory

    mechanism = load_mechanism(name, seconds)
    if trajectory is None:
        viewer = pm.view(read_pose(mechanism, outputs, mode, no_limits))
    elif outputs:
        raise InputError("give either outputs or --trajectory, not both")
    else:
        viewer = view_trajectory(mechanism, trajectory, mode=read_modes(mode), limits=not no_limits)
    for note in viewer.notes:
        sys.stderr.write(f"pinmech: {note}\n")
    page = viewer.write_html(out or Path(f"{slug(mechanism.name)}.html"))
    sys.stdout.write(f"wrote {page}\n")
    if show_it:
        webbrowser.open(page.resolve().as_uri(), new=2)


@app.command()
def schema() -> None:
    """Print the JSON schema of a description file, for editors.

    \b
    pinmech schema > mechanism.schema.json
    """
    print_json(json_schema())
