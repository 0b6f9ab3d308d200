# SPDX-License-Identifier: Apache-2.0
"""panelcal makes a drilling machine hit the panel on the table, not the panel in the drawing.

The same code as the command ``panelcal``, with the same answers to the bit; pictures,
places and covariances are numpy arrays.

A job, from the program as it was drawn to holes where the panel really is::

    import panelcal

    machine = panelcal.read_machine("machine.toml")
    program = panelcal.read_program("panel.exc", machine)
    print(len(program.holes), "holes,", len(program.requests), "targets to measure")

    job = panelcal.correct(program, machine, images="pictures")
    print(job.verdict)                       # drill, warned, hold or forced
    if job.may_be_drilled:
        print(job.holes.actual_mm)           # (n, 2): where the machine is to drill
        print(job.holes.sigma_mm)            # (n, 2): one standard deviation

A picture, and the target in it::

    target = panelcal.Target("disc", size_px=80)
    image = panelcal.render(target, size_px=(480, 480), center_px=(240.3, 238.9), noise=3)
    found = panelcal.locate(image, target)
    print(found.center_px, found.cov_px2)    # px, px^2

=========================  ==================================================
read_machine               machine.toml and the calibrations it names
read_program               a drill program: operations, holes, targets
plan                       which targets are good enough, before measuring
correct                    the main job: measure, fit, gate, correct
locate                     find a target in a picture
render, Samples            pictures whose truth is known
fit_panel                  the map from nominal to measured places
fit_surface, read_surface  heights of a panel with their uncertainty
calibrate_camera, calibrate_table, calibrate_spindle_camera
                           calibrations from pictures and measured places
history                    the entries of a calibration ledger
=========================  ==================================================

Units and frames: the name of every number says its unit (``_mm``, ``_um``, ``_px``, ``_rad``).
Nominal places are the program's, after step and repeat; actual places are what the machine
is told. Pixel (0, 0) is the centre of the top-left pixel, x right, y down. Covariances
are full matrices in units squared. docs/conventions.md has the rest.

Problems are raised as `panelcal.Error`, with file, line and column. A measurement outside of
a limit is no error: it is a result that says so.

Threads: every object is immutable but `Image`, whose pixels may be written to by one thread
alone; long calls release the GIL, so that a thread pool uses all cores.
"""
from __future__ import annotations

import dataclasses
import json
import os
from typing import Any, Iterable, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import (CameraMapping, Detection, Image, Machine, PanelFit, Samples, Surface, Target,
                    __version__)
from ._error import Error

Path = Union[str, "os.PathLike[str]"]

for _type in (CameraMapping, Detection, Error, Image, Machine, PanelFit, Samples, Surface, Target):
    _type.__module__ = __name__  # where its users find it

__all__ = [
    "Calibration", "CameraMapping", "Detection", "Error", "Image", "Job", "Machine",
    "Operations", "PanelFit", "Program", "Samples", "SpindleCamera", "Surface", "Target",
    "__version__", "calibrate_camera", "calibrate_spindle_camera", "calibrate_table", "correct",
    "fit_panel", "fit_surface", "history", "locate", "located_row", "parse_machine", "plan", "read_image",
    "read_machine", "read_program", "read_surface", "render", "write_png",
]


def _path(path: Path | None) -> str:
    return "" if path is None else os.fsdecode(os.fspath(path))


# --- Machines and programs ---------------------------------------------------------------------


def read_machine(file: Path) -> Machine:
    """Read machine.toml and the calibration files that it names.

    Parameters
    ----------
    file : path

    Returns
    -------
    Machine

    Raises
    ------
    Error
        With line and column; an unknown key names the nearest known one.
    """
    return _core.read_machine(_path(file))


def parse_machine(text: str, file: Path = "machine.toml") -> Machine:
    """Read a machine from text.

    Parameters
    ----------
    text : str
        As machine.toml has it.
    file : path
        Stands in messages; calibration files are looked for beside it.

    Returns
    -------
    Machine
    """
    return _core.parse_machine(text, _path(file))


def _machine(machine: Machine | Path | None) -> Machine | None:
    return machine if machine is None or isinstance(machine, Machine) else read_machine(machine)


@dataclasses.dataclass(frozen=True, eq=False)
class Operations:
    """Operations of a program in columns, a row for each, in the order of execution.

    ``operations[mask]`` takes rows, as an array does; ``len(operations)`` counts them. The arrays
    are those that C++ filled: nothing was copied.

    Attributes
    ----------
    op : ndarray of str, shape (n,)
        tool, drill, rout, position, ... as docs/formats/operations.md has them. A slot has two
        rows: slot, and slot_end for its other end.
    line : ndarray of int, shape (n,)
        Of the program.
    tool : ndarray of int, shape (n,)
        0 where there is none.
    diameter_mm : ndarray, shape (n,)
        Of the tool in force; NaN where it is not known, or the operation has no place.
    nominal_mm : ndarray, shape (n, 2)
        After step and repeat, before any correction; NaN without a place.
    actual_mm : ndarray, shape (n, 2)
        What the machine is told, in its own coordinates.
    cov_mm2 : ndarray, shape (n, 2, 2)
        Covariance of the place that is drilled; zero without a correction.
    risk : ndarray, shape (n,)
        Probability that the hole breaks its tolerance; NaN where it is not stated.
    board : ndarray of int, shape (n,)
        Index into `boards`.
    boards : list of tuple of int
        Indices of step and repeat, outermost first.
    """

    op: NDArray[np.str_]
    line: NDArray[np.int32]
    tool: NDArray[np.int32]
    diameter_mm: NDArray[np.float64]
    nominal_mm: NDArray[np.float64]
    actual_mm: NDArray[np.float64]
    cov_mm2: NDArray[np.float64]
    risk: NDArray[np.float64]
    board: NDArray[np.uint32]
    boards: list[tuple[int, ...]]

    @property
    def sigma_mm(self) -> NDArray[np.float64]:
        """One standard deviation along x and y, shape (n, 2)."""
        return np.sqrt(np.stack([self.cov_mm2[:, 0, 0], self.cov_mm2[:, 1, 1]], axis=1))

    @property
    def holes(self) -> Operations:
        """The drilled holes alone."""
        return self[self.op == "drill"]

    def __len__(self) -> int:
        return len(self.line)

    def __getitem__(self, rows: Any) -> Operations:
        columns = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        boards = columns.pop("boards")
        return Operations(boards=boards, **{name: column[rows] for name, column in columns.items()})


def _operations(columns: Mapping[str, Any]) -> Operations:
    columns = dict(columns)
    words = np.array(columns.pop("ops") or [""])
    return Operations(op=words[columns.pop("op")],
                      boards=[tuple(board) for board in columns.pop("boards")], **columns)


class Program:
    """A drill program that was read and checked; `read_program` makes one.

    Attributes
    ----------
    file : str
    dialect : str
        Excellon or SIEB & MEYER.
    number_format : str
        How its numbers are read, in words.
    tools : dict of int to dict
        diameter_mm, feed_mm_s, speed_rpm, ... as far as the program states them.
    operations : Operations
        What it does on a perfect panel.
    holes : Operations
        The drilled holes alone.
    requests : list of dict
        The targets that it wants measured, in order, as docs/formats/measurements.md has them.
    diagnostics : list of dict
        Warnings.

    Notes
    -----
    Immutable: threads may share it.
    """

    def __init__(self, read: _core.ReadProgram) -> None:
        self._source = read.source
        self.file: str = read.file
        self.dialect: str = read.dialect
        self.number_format: str = read.number_format
        self.tools: dict[int, dict[str, Any]] = read.tools
        self.operations = _operations(read.operations)
        self.holes = self.operations.holes
        self.requests: list[dict[str, Any]] = [json.loads(line) for line in read.requests]
        self.diagnostics: list[dict[str, Any]] = read.diagnostics

    def __repr__(self) -> str:
        return (f"<panelcal.Program {self.file}: {self.dialect}, {len(self.holes)} holes, "
                f"{len(self.requests)} targets>")


def _program_source(program: Program | Path, name: str) -> _core.ProgramSource:
    if isinstance(program, Program):
        return program._source
    path = _path(program)
    is_text = isinstance(program, str) and ("\n" in program or "\r" in program)
    return _core.ProgramSource(name if is_text else path, path if is_text else None)


def read_program(program: Path, machine: Machine | Path | None = None, *,
                 name: str = "program") -> Program:
    """Read and check a drill program: Excellon (CNC-7) or SIEB & MEYER.

    Parameters
    ----------
    program : path, or str with a line end
        A file, or the program itself.
    machine : Machine or path, optional
        Whose ``[program]``, work zero and limits hold; by default a machine that states nothing.
    name : str
        Of a program that is given as text, for messages.

    Returns
    -------
    Program

    Raises
    ------
    Error
        The first error in it, with its place; `Error.log` has all of them.

    Examples
    --------
    >>> program = panelcal.read_program("M48\\nMETRIC,LZ\\nT1C0.8\\n%\\nT1\\nX010Y020\\nM30\\n")
    >>> program.holes.nominal_mm
    array([[10., 20.]])
    """
    return Program(_core.ReadProgram(_program_source(program, name), _machine(machine)))


# --- Jobs --------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, eq=False)
class Job:
    """A job that was measured; `correct` makes one.

    Attributes
    ----------
    verdict : str
        drill, warned, hold or forced.
    may_be_drilled : bool
        Every series of targets is inside its limits, nothing is wrong in the program, and no
        tolerance holds it.
    facts : dict or None
        All facts, as share/schema/job.schema.json describes them: the document that
        ``panelcal run --json`` writes. Its ``output`` is ``-`` where there is no file.
    operations : Operations or None
        The corrected program; None if it may not be drilled and nothing forced it.
    measurements : list of dict
        One for each target, in order; `correct` takes them again and gives the same job.
    program : bytes or None
        The corrected program in the format that was asked for, if it was not written to a file.
    is_written : bool
        The output is there.
    diagnostics : list of dict
        Errors and warnings: severity, code, file, line, column, what, expected, text.
    """

    verdict: str
    may_be_drilled: bool
    facts: dict[str, Any] | None
    operations: Operations | None
    measurements: list[dict[str, Any]]
    program: bytes | None
    is_written: bool
    diagnostics: list[dict[str, Any]]

    @property
    def holes(self) -> Operations | None:
        """The drilled holes of `operations`."""
        return None if self.operations is None else self.operations.holes

    def __repr__(self) -> str:
        n_holes = 0 if self.holes is None else len(self.holes)
        return f"<panelcal.Job {self.verdict}: {n_holes} holes, {len(self.measurements)} targets>"


def correct(program: Program | Path, machine: Machine | Path,
            measurements: Path | Iterable[Mapping[str, Any]] | None = None, *,
            images: Path | None = None, driver: str | None = None, probes: Path | None = None,
            surface: Path | None = None, uncorrected: bool = False, output: Path | None = None,
            format: str | None = None, resolution_um: float | None = None, force: bool = False,
            turned_deg: int | None = None, truth: Path | None = None, clock: str | None = None,
            n_threads: int = 1, facts: bool = True) -> Job:
    """Measure the targets of a program, fit the panel, hold it against its limits, correct it.

    What ``panelcal run`` does. One of `measurements`, `images`, `driver` and `uncorrected` says
    where the places of the targets come from.

    Parameters
    ----------
    program : Program, path or str with a line end
        As `read_program` takes it; it is read as this machine reads it.
    machine : Machine or path
    measurements : path or iterable of dict, optional
        Recorded measurements, a file of JSON Lines or its rows: a request (`Program.requests`) with
        ``status`` (found, not_found, ambiguous, rejected), and if found ``measured`` [x, y] in mm
        and ``cov`` [xx, xy, yy] in mm^2.
    images : path, optional
        A folder of pictures with images.csv.
    driver : str, optional
        ``"sim"``: the virtual machine of ``[sim]``.
    probes : path, optional
        Recorded probe readings, where the program probes.
    surface : path, optional
        A map of the board's surface (`Surface.save`), for depths.
    uncorrected : bool
        The program measures no target, and that is meant.
    output : path, optional
        Gets the corrected program, whole or not at all; its extension tells the format. It must not
        be a file that the job reads (output-in-use).
    format : str, optional
        jsonl, csv, excellon, sieb-meyer, gcode or svg; without `output` `Job.program` has it.
    resolution_um : float, optional
        Of coordinates in a program.
    force : bool
        Write a job that its limits refuse all the same.
    turned_deg : int, optional
        The panel lies turned by 90, 180 or 270 degrees, and is meant to.
    truth : path, optional
        truth.json of a simulated job, to compare the holes with.
    clock : str, optional
        The time of the job, such as ``2026-11-21T13:45:00``; by default now.
    n_threads : int
        Look at recorded pictures; 0: one for each processor. No result depends on it.
    facts : bool
        Make the facts, and the small pictures that they describe. Without them a job of a few
        pictures takes less time.

    Returns
    -------
    Job
        Also if limits refuse it: test `Job.may_be_drilled`.

    Raises
    ------
    Error
        What kept the job from being measured: the program, the machine's file, a picture.
    """
    machine = _machine(machine)
    options = _core.CorrectOptions()
    options.images = _path(images)
    options.driver = driver or ""
    options.probes = _path(probes)
    options.surface = _path(surface)
    options.uncorrected = uncorrected
    options.output = _path(output)
    options.format = format or ""
    options.resolution_um = resolution_um
    options.force = force
    options.turned_deg = turned_deg
    options.truth = _path(truth)
    options.clock = clock or ""
    options.n_threads = n_threads
    options.facts = facts
    if isinstance(measurements, (str, os.PathLike)):
        options.measurements = _path(measurements)
    elif measurements is not None:
        options.measurements_text = "".join(json.dumps(row) + "\n" for row in measurements)
    done = _core.correct(_program_source(program, "program"), machine, options)
    return Job(verdict=done["verdict"], may_be_drilled=done["may_be_drilled"],
               facts=None if done["facts"] is None else json.loads(done["facts"]),
               operations=None if done["operations"] is None else _operations(done["operations"]),
               measurements=[json.loads(line) for line in done["measurements"].splitlines()],
               program=done["program"], is_written=done["is_written"],
               diagnostics=done["diagnostics"])


def plan(program: Program | Path, machine: Machine | Path, *, measurements: Path | None = None,
         fiducial_sigma_um: float | None = None, n_added: int = 1,
         clock: str | None = None) -> dict[str, Any]:
    """Tell how well the targets of a program determine its holes, before anything is measured.

    What ``panelcal plan --json`` writes.

    Parameters
    ----------
    program : Program, path or str with a line end
    machine : Machine or path
    measurements : path, optional
        Of an earlier job: the noise of its targets.
    fiducial_sigma_um : float, optional
        Noise of a target's picture along each axis; by default 2 um.
    n_added : int
        Further targets to propose together, 1 to 20.
    clock : str, optional
        The time of the plan, as `correct` takes it.

    Returns
    -------
    dict
        As share/schema/plan.schema.json describes it.
    """
    return json.loads(_core.plan(_program_source(program, "program"), _machine(machine),
                                 _path(measurements), fiducial_sigma_um, n_added, clock or ""))


# --- Pictures ----------------------------------------------------------------------------------


def read_image(file: Path) -> Image:
    """Read a PNG, TIFF, BMP or JPEG file as a grey picture; colour becomes luma.

    Parameters
    ----------
    file : path

    Returns
    -------
    Image
    """
    return _core.read_image(_path(file))


def write_png(file: Path, image: Image) -> None:
    """Write a picture as PNG, 8 or 16 bit, whole or not at all.

    Parameters
    ----------
    file : path
    image : Image
    """
    _core.write_png(_path(file), image)


def locate(image: Image | ArrayLike, target: Target | int, machine: Machine | None = None, *,
           mapping: CameraMapping | None = None,
           search_center_px: tuple[float, float] | None = None,
           search_radius_px: float | None = None, full_scale: float | None = None,
           **limits: float) -> Detection:
    """Find a target in a picture and fit it to a fraction of a pixel.

    Parameters
    ----------
    image : Image or array_like, shape (height, width)
        An `Image` is looked at as it is; of an array one copy is made, as `Image` makes it. Make
        the `Image` yourself to look for several targets in it.
    target : Target or int
        What to look for; a number is that of a vision tool of `machine`.
    machine : Machine, optional
        Whose camera took the picture: its mapping and its limits of ``[vision]`` hold.
    mapping : CameraMapping, optional
        For targets in mm, where there is no machine.
    search_center_px, search_radius_px : (float, float), float, optional
        The circle in which the target's middle may be; by default the whole picture.
    full_scale : float, optional
        Level of white of floating-point pixels: 255 or 65535.
    **limits : float
        min_contrast, min_score, min_visible, max_blur_px, max_clipped, max_oval, max_roughness,
        max_lobes, ambiguity_margin: as docs/formats/machine_toml.md has them.

    Returns
    -------
    Detection
        Also if nothing was found: test `Detection.found`.

    Examples
    --------
    >>> target = panelcal.Target("disc", size_px=40)
    >>> image = panelcal.render(target, size_px=(200, 150), center_px=(100.25, 74.5))
    >>> panelcal.locate(image, target).center_px.round(2)
    array([100.25,  74.5 ])
    """
    return _core.locate(image, target, machine, mapping, search_center_px, search_radius_px,
                        full_scale, limits)


def located_row(detection: Detection, image: str = "", tool: int = 0,
                candidates: bool = False) -> dict[str, Any]:
    """Give a detection as ``panelcal locate`` prints it: docs/formats/located_targets.md.

    Parameters
    ----------
    detection : Detection
    image : str
        Name of the picture.
    tool : int
        Number of the vision tool.
    candidates : bool
        List all places that were looked at.

    Returns
    -------
    dict
    """
    return json.loads(detection._row(image, tool, candidates))


def render(target: Target, *, size_px: tuple[int, int] = (640, 480),
           center_px: tuple[float, float] | None = None, mapping: CameraMapping | None = None,
           turn_rad: float = 0, level: float = 0.7, ground: float = 0.3, blur_px: float = 1,
           noise: float = 0, seed: int = 1, full_scale: float = 255) -> Image:
    """Draw a picture of one target whose place is known exactly.

    A pixel has the light that falls on its area, by integration without supersampling.

    Parameters
    ----------
    target : Target
    size_px : (int, int)
        Width and height.
    center_px : (float, float), optional
        The target's place; by default the middle.
    mapping : CameraMapping, optional
        Of the camera, for targets in mm.
    turn_rad : float
        On top of the target's own angle.
    level, ground : float
        Brightness of the target and of its surroundings, 0 to 1 of white.
    blur_px : float
        Sigma of the lens, 0.2 or more; the pixel comes on top.
    noise : float
        Sigma per pixel, grey levels.
    seed : int
        Of the noise: equal arguments give equal pictures.
    full_scale : float
        Level of white, 255 or 65535.

    Returns
    -------
    Image

    See Also
    --------
    Samples : with debris, neighbours and board texture, as ``[sim]`` describes them.
    """
    if center_px is None:
        center_px = ((size_px[0] - 1) / 2, (size_px[1] - 1) / 2)
    return _core.render(target, size_px, center_px, mapping, turn_rad, level, ground, blur_px, noise,
                        seed, full_scale)


# --- Fits --------------------------------------------------------------------------------------


def fit_panel(nominal_mm: ArrayLike, measured_mm: ArrayLike, cov_mm2: ArrayLike = 0.002, *,
              model: str = "auto") -> PanelFit:
    """Fit the map that carries nominal targets onto measured ones.

    Parameters
    ----------
    nominal_mm, measured_mm : array_like, shape (n, 2)
    cov_mm2 : array_like, shape (n, 2, 2) or (2, 2), or float
        Covariance of each measured place; a single number is one standard deviation in mm.
    model : str
        auto (what the targets speak for), offset, rigid, similarity, stretch, affine, or smooth
        (six targets or more).

    Returns
    -------
    PanelFit
        Call it with nominal places to get actual ones.

    Raises
    ------
    Error
        targets-too-few, series-degenerate, measurement-invalid, panel-mirrored, panel-folded.

    Examples
    --------
    >>> corners = [[0, 0], [300, 0], [300, 200], [0, 200]]
    >>> seen = [[0.1, 0.2], [300.1, 0.2], [300.1, 200.2], [0.1, 200.2]]
    >>> fit = panelcal.fit_panel(corners, seen, model="offset")
    >>> fit([[150, 100]])[0]
    array([[150.1, 100.2]])
    """
    return _core.fit_panel(nominal_mm, measured_mm, cov_mm2, model)


def fit_surface(places_mm: ArrayLike | Path, heights_mm: ArrayLike | None = None,
                sigma_um: ArrayLike | None = None, *, model: str = "auto",
                max_extrapolation_mm: float = 5, z_axis: int | None = None) -> Surface:
    """Fit a surface to probed heights; probes that do not fit the others are left out.

    What ``panelcal surface fit`` does.

    Parameters
    ----------
    places_mm : array_like, shape (n, 2), or path
        Nominal places of the probes, or a file of probed heights (docs/formats/height_files.md).
    heights_mm : array_like, shape (n,)
        Above the table; not with a file.
    sigma_um : array_like, shape (n,), or float, optional
        What each probe scatters; by default 5 um is assumed, and learned from the residuals too.
    model : str
        auto, or a word of ``panelcal surface fit --model``.
    max_extrapolation_mm : float
        Farther outside of the probes a height is refused.
    z_axis : int, optional
        Of a file with several.

    Returns
    -------
    Surface
    """
    if isinstance(places_mm, (str, os.PathLike)):
        if heights_mm is not None:
            raise TypeError("fit_surface() takes a file, or places and heights")
        sigma = None if sigma_um is None else float(np.asarray(sigma_um))
        return _core.fit_surface_file(_path(places_mm), sigma, z_axis, model, max_extrapolation_mm)
    if heights_mm is None:
        raise TypeError("fit_surface() misses heights_mm")
    return _core.fit_surface(places_mm, heights_mm, sigma_um, model, max_extrapolation_mm)


def read_surface(file: Path) -> Surface:
    """Read a map that `Surface.save` or ``panelcal surface fit`` wrote.

    Parameters
    ----------
    file : path

    Returns
    -------
    Surface
    """
    return _core.read_surface(_path(file))


# --- Calibrations ------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, eq=False)
class Calibration:
    """A calibration of a camera or of a table, from data. Nothing is installed.

    Attributes
    ----------
    calibration : dict
        The file's content: parameters with units, covariance, date and provenance.
    text : str
        Its bytes, as ``panelcal calibrate ... -o FILE`` writes them.
    refusal : str
        What speaks against it; empty if nothing does.
    report : str
        In words.
    chi_square, degrees_of_freedom : float
        Of the residuals.
    excess : float
        By how much the looks scatter more than they say; 1 where they do not.
    """

    calibration: dict[str, Any]
    text: str
    refusal: str
    report: str
    chi_square: float
    degrees_of_freedom: float
    excess: float

    def save(self, file: Path, *, force: bool = False) -> None:
        """Write the calibration file that machine.toml names.

        Parameters
        ----------
        file : path
        force : bool
            Also if something speaks against it.

        Raises
        ------
        ValueError
            `refusal` is not empty.
        """
        if self.refusal and not force:
            raise ValueError(f"refused: {self.refusal} (force=True)")
        partial = _path(file) + ".partial"
        with open(partial, "w", encoding="utf-8") as out:
            out.write(self.text)
            out.flush()
            os.fsync(out.fileno())
        os.replace(partial, file)


def _calibration(made: _core.Calibrated) -> Calibration:
    return Calibration(json.loads(made.text), made.text, made.refusal, made.report,
                             made.chi_square, made.degrees_of_freedom, made.excess)


def calibrate_camera(machine: Machine | Path, images: Path, *, plate: Path | None = None,
                     tool: int | None = None, focal_px: float | None = None,
                     clock: str | None = None) -> Calibration:
    """Calibrate the camera from recorded pictures of one mark, or of a plate.

    What ``panelcal calibrate camera --images`` does, without installing anything.

    Parameters
    ----------
    machine : Machine or path
    images : path
        A folder with images.csv; of a plate one for each pose, 0, 1, ...
    plate : path, optional
        The plate's file.
    tool : int, optional
        Vision tool of the mark.
    focal_px : float, optional
        Distance of the panel over the scale, from the lens' data sheet.
    clock : str, optional
        Date of the calibration, ``2026-11-21T02:00:00Z``; by default now.

    Returns
    -------
    Calibration
    """
    return _calibration(_core.calibrate_camera(_machine(machine), _path(images),
                                               None if plate is None else _path(plate), tool,
                                               focal_px, clock or ""))


def calibrate_table(machine: Machine | Path, plate: Path, *, images: Path | None = None,
                    measurements: Path | None = None,
                    clock: str | None = None) -> Calibration:
    """Calibrate the table: the map of its errors, from looks at a plate.

    What ``panelcal calibrate table`` does, without installing anything.

    Parameters
    ----------
    machine : Machine or path
    plate : path
        The plate's file.
    images : path, optional
        Folders with pictures of the plate, one for each pose.
    measurements : path, optional
        Or looks that another vision system measured, JSON Lines.
    clock : str, optional
        Date of the calibration, ``2026-11-21T02:00:00Z``; by default now.

    Returns
    -------
    Calibration
    """
    return _calibration(_core.calibrate_table(_machine(machine), _path(plate),
                                              None if images is None else _path(images),
                                              None if measurements is None else _path(measurements),
                                              clock or ""))


@dataclasses.dataclass(frozen=True, eq=False)
class SpindleCamera:
    """The offset of the camera from the spindle; `calibrate_spindle_camera` makes one.

    Attributes
    ----------
    offset_mm : ndarray, shape (2,)
        Point on the optical axis minus point under the spindle, machine directions.
    cov_mm2 : ndarray, shape (2, 2)
        Right in the mean, although the scatter is estimated from the same holes.
    wander_um, repeatability_um : (float, float)
        One standard deviation along x and y: between holes, and between looks at one.
    outliers : list of int
        Holes that do not fit the others and are left out.
    chi_square : float
    degrees_of_freedom : int
    report : str
        In words.
    """

    offset_mm: NDArray[np.float64]
    cov_mm2: NDArray[np.float64]
    wander_um: tuple[float, float]
    repeatability_um: tuple[float, float]
    outliers: list[int]
    chi_square: float
    degrees_of_freedom: int
    report: str


def calibrate_spindle_camera(drilled_mm: ArrayLike, hole: Sequence[int] | ArrayLike,
                             spindle_mm: ArrayLike, seen_mm: ArrayLike,
                             cov_mm2: ArrayLike) -> SpindleCamera:
    """Fit the spindle-camera offset to looks at holes that the spindle drilled.

    Parameters
    ----------
    drilled_mm : array_like, shape (n, 2)
        Where the spindle was sent to drill, machine; all holes from one side.
    hole : array_like of int, shape (m,)
        For each look the hole that it shows, from 0.
    spindle_mm : array_like, shape (m, 2)
        Where the spindle stood during the look, machine.
    seen_mm : array_like, shape (m, 2)
        The hole's middle from the optical axis, machine directions.
    cov_mm2 : array_like, shape (m, 2, 2) or (2, 2), or float
        Of what was seen; a single number is one standard deviation in mm.

    Returns
    -------
    SpindleCamera

    Raises
    ------
    Error
        calibration-data: too few holes, or too many that do not fit.
    """
    return SpindleCamera(**_core.calibrate_spindle_camera(drilled_mm, hole, spindle_mm, seen_mm,
                                                          cov_mm2))


def history(ledger: Path) -> list[dict[str, Any]]:
    """Read all entries of a calibration ledger, in their order.

    Parameters
    ----------
    ledger : path
        As ``[ledger] file`` of machine.toml names it.

    Returns
    -------
    list of dict
        As share/schema/ledger-entry.schema.json describes them, with the key ``id``.
    """
    return [json.loads(line) for line in _core.history(_path(ledger))]
