# SPDX-License-Identifier: Apache-2.0
"""Probed heights of a surface that is known, as files of other programs.

Written from the public descriptions of the formats, not from panelcal's readers. Each maker returns the text, and what
a reader must find: {(x mm, y mm): height mm} and the places that have no height.
"""
import json

NX, NY = 5, 4
X0, Y0, X1, Y1 = 10.0, 20.0, 70.0, 65.0


def height(x, y):
    """Tilted along both axes and twisted: no two rows, columns or corners are alike."""
    return round(0.004 * x - 0.0021 * y + 0.00004 * x * y + 0.1, 3)


def place(i, j):
    return X0 + (X1 - X0) / (NX - 1) * i, Y0 + (Y1 - Y0) / (NY - 1) * j


NODES = [place(i, j) for j in range(NY) for i in range(NX)]
TRUTH = {at: height(*at) for at in NODES}


def rows(text=lambda z: f"{z:.6f}"):
    """From low y, heights as texts."""
    return [[text(height(*place(i, j))) for i in range(NX)] for j in range(NY)]


def without(*nodes):
    gone = {place(i, j) for i, j in nodes}
    return {at: z for at, z in TRUTH.items() if at not in gone}, gone


def printer_cfg(name="default", bed=""):
    points = "".join(f"#*# \t  {', '.join(row)}\n" for row in rows())
    return (f"[mcu]\nserial: /dev/ttyUSB0\n\n[bed_mesh]\nspeed: 120  # mm/s\nprobe_count: 5, 4\n{bed}\n[extruder]\nnozzle_diameter: 0.4\n\n"
            "#*# <---------------------- SAVE_CONFIG ---------------------->\n"
            "#*# DO NOT EDIT THIS BLOCK OR BELOW. The contents are auto-generated.\n#*#\n"
            "#*# [probe]\n#*# z_offset = 1.300\n#*#\n"
            f"#*# [bed_mesh {name}]\n#*# version = 1\n#*# points =\n{points}"
            f"#*# tension = 0.2\n#*# min_x = {X0}\n#*# algo = bicubic\n#*# y_count = {NY}\n#*# mesh_y_pps = 2\n"
            f"#*# min_y = {Y0}\n#*# x_count = {NX}\n#*# max_y = {Y1}\n#*# mesh_x_pps = 2\n#*# max_x = {X1}\n")


def klipper():
    return printer_cfg(), TRUTH, set()


def klipper_faulty_region():
    """Klipper puts the mean of probes about it at the node (20.0..45.0, 30..40): column 1 and 2, row 1."""
    kept, gone = without((1, 1), (2, 1))
    return printer_cfg(bed="faulty_region_1_min: 20, 30\nfaulty_region_1_max: 45, 40\n"), kept, gone


def klipper_round():
    """A round bed of radius 30 about (40, 40): 5 x 5 nodes every 15 mm; rows are filled up with their ends' heights."""
    nodes = {(10.0 + 15 * i, 10.0 + 15 * j) for i in range(5) for j in range(5)}
    inside = {at for at in nodes if (at[0] - 40) ** 2 + (at[1] - 40) ** 2 <= 30.001 ** 2}
    lines = []
    for j in range(5):
        y = 10.0 + 15 * j
        xs = sorted(x for x, at_y in inside if at_y == y)
        lines.append(", ".join(f"{height(min(max(10.0 + 15 * i, xs[0]), xs[-1]), y):.6f}" for i in range(5)))
    text = ("[bed_mesh]\nmesh_radius: 30\nmesh_origin: 40, 40\nround_probe_count: 5\n\n#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n"
            + "".join(f"#*# \t  {line}\n" for line in lines)
            + "#*# x_count = 5\n#*# y_count = 5\n#*# mesh_x_pps = 2\n#*# mesh_y_pps = 2\n#*# algo = lagrange\n#*# tension = 0.2\n"
            "#*# min_x = 10.0\n#*# max_x = 70.0\n#*# min_y = 10.0\n#*# max_y = 70.0\n")
    return text, {at: height(*at) for at in inside}, nodes - inside


def mesh_object():
    matrix = [[height(*place(i, j)) for i in range(NX)] for j in range(NY)]
    fine = [[0.0] * (3 * NX - 2) for _ in range(3 * NY - 2)]
    return {"profile_name": "default", "mesh_min": [X0, Y0], "mesh_max": [X1, Y1], "probed_matrix": matrix, "mesh_matrix": fine,
            "profiles": {"default": {"points": matrix, "mesh_params": {
                "min_x": X0, "max_x": X1, "min_y": Y0, "max_y": Y1, "x_count": NX, "y_count": NY, "mesh_x_pps": 2, "mesh_y_pps": 2,
                "algo": "bicubic", "tension": 0.2}}}}


def moonraker():
    answer = {"result": {"eventtime": 578243.5, "status": {"bed_mesh": mesh_object()}}}
    return json.dumps(answer, indent=2), TRUTH, set()


def moonraker_profile():
    """No mesh is loaded: BED_MESH_CLEAR leaves an empty matrix."""
    mesh = mesh_object() | {"profile_name": "", "probed_matrix": [[]], "mesh_matrix": [[]]}
    return json.dumps({"bed_mesh": mesh}), TRUTH, set()


def signed(z):
    return f"{z:+.3f}"


def numbered_grid(title, cells):
    """Marlin's print_2d_array: rows from low y."""
    text = title + "\n" + "".join(f"{i:7d}" for i in range(NX)) + "\n"
    return text + "".join(f"{j:2d} {' '.join(row)}\n" for j, row in enumerate(cells)) + "\n"


def marlin_bilinear():
    """G29 V4: the touches state the places, out and back; the corner (4, 3) was not reached, and extrapolated."""
    order = [(i, j) for j in range(NY) for i in (range(NX) if j % 2 == 0 else reversed(range(NX))) if (i, j) != (4, 3)]
    touches = "".join("Bed X: {:.3f} Y: {:.3f} Z: {:.3f}\n".format(*place(i, j), height(*place(i, j))) for i, j in order)
    kept, gone = without((4, 3))
    return ("echo:busy: processing\nG29 Auto Bed Leveling\n" + touches + numbered_grid("Bilinear Leveling Grid:", rows(signed))
            + "X:70.00 Y:65.00 Z:10.00 E:0.00 Count X:5600 Y:5200 Z:4000\nok P15 B3\n"), kept, gone


def marlin_grid_alone():
    """M420 V in a log of OctoPrint; places by --mesh-mm. Node (2, 1) was never probed."""
    cells = rows(signed)
    cells[1][2] = " ====="
    text = "M420 V\necho:Bed Leveling On\necho:Fade Height 10.00\n" + numbered_grid("Bilinear Leveling Grid:", cells) + "ok\n"
    log = "".join(f"2026-11-28 02:{k // 60:02d}:{k % 60:02d},{k:03d} - Recv: {line}\n" for k, line in enumerate(text.splitlines()))
    kept, gone = without((2, 1))
    return log.replace("Recv: M420 V", "Send: M420 V"), kept, gone


def marlin_mesh():
    """Mesh bed leveling: five digits."""
    text = f"Mesh Bed Leveling ON\n{NX}x{NY} mesh. Z offset: 0.00000\n" + numbered_grid("Measured points:", rows(lambda z: f"{z:+.5f}")) + "ok\n"
    return text, TRUTH, set()


def corner(x, y):
    return f"({int(x):3d},{int(y):3d})"


def marlin_unified():
    """G29 T0: rows from high y, whole mm at the corners, brackets where the nozzle is, a point for no height."""
    lines = ["", "Bed Topography Report:", "", f"    {corner(X0, Y1)}{' ' * 22}{corner(X1, Y1)}",
             "       " + "".join(f" {i}      " for i in range(NX))]
    for j in reversed(range(NY)):
        cells = "".join(f"[{signed(height(*place(i, j)))}]" if (i, j) == (0, 0) else "   .    " if (i, j) == (3, 2)
                        else f" {signed(height(*place(i, j)))} " for i in range(NX))
        lines.append(f"{j:2d} |{cells}")
        if j:
            lines.append("   |")
    lines += [lines[4], f"    {corner(X0, Y0)}{' ' * 22}{corner(X1, Y0)}", "", "ok P15 B3", ""]
    kept, gone = without((3, 2))
    return "\n".join(lines), kept, gone


def marlin_unified_older():
    """Marlin 1.1.8 and older: corners in nodes and mm, no numbers of rows; times as Repetier-Host puts them ahead."""
    lines = ["Bed Topography Report:", "", f"(0,{NY - 1})                           ({NX - 1},{NY - 1})",
             f"({int(X0)},{int(Y1)})                        ({int(X1)},{int(Y1)})"]
    for j in reversed(range(NY)):
        lines.append("".join(f"[{height(*place(i, j)):6.3f}]" if (i, j) == (2, 2) else f" {height(*place(i, j)):6.3f}  " for i in range(NX)))
        lines.append(" ")
    lines[-1:] = [f"({int(X0)},{int(Y0)})                            ({int(X1)},{int(Y0)})", f"(0,0)                             ({NX - 1},0)", "ok"]
    return "".join(f"18:36:{k:02d}.{37 * k % 1000:03d} : {line}\n" for k, line in enumerate(lines)), TRUTH, set()


def marlin_touches():
    """G29 V4 of a plane: no grid, the touches alone."""
    return "".join("Bed X: {:.3f} Y: {:.3f} Z: {:.3f}\n".format(*at, z) for at, z in TRUTH.items()) + "ok\n", TRUTH, set()


WCO = (-120.5, -80.25, -31.004)


def prb(at, z, decimals=3, scale=1.0, success=1):
    machine = [(value + offset) / scale for value, offset in zip((*at, z), WCO)]
    return f"[PRB:{','.join(f'{value:.{decimals}f}' for value in machine)}:{success}]\n"


def wco(decimals=3, scale=1.0):
    return ",".join(f"{value / scale:.{decimals}f}" for value in WCO)


def grbl_status():
    """A console with status reports; the place (55, 50) was not touched, and $# repeats the last probe."""
    text = ("Grbl 1.1h ['$' for help]\n<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\n[MSG:'$H'|'$X' to unlock]\nok\n"
            f"<Idle|MPos:-110.500,-60.250,-30.000|FS:0,0|WCO:{wco()}>\n")
    lost = place(3, 2)
    for at, z in TRUTH.items():
        text += f"G0 X{at[0]} Y{at[1]}\nok\n<Run|MPos:-100.000,-60.000,-30.000|FS:500,0|Ov:100,100,100>\nG38.3 Z-2 F50\n"
        text += prb(at, -2.0, success=0) if at == lost else prb(at, z)
        text += "ok\n"
    last = prb(*list(TRUTH.items())[-1])
    text += f"[G54:{wco()}]\n[G55:0.000,0.000,0.000]\n[G28:0.000,0.000,0.000]\n[G92:0.000,0.000,0.000]\n[TLO:0.000]\n{last}ok\n"
    kept, gone = without((3, 2))
    return text, kept, gone


def grbl_parameters():
    """No status report: G55 is active, and G92 and TLO share in the zero."""
    text = ("[GC:G0 G55 G17 G21 G90 G94 M5 M9 T0 F0 S0]\nok\n[G54:1.000,2.000,3.000]\n[G55:-130.500,-80.250,-30.004]\n[G56:0.000,0.000,0.000]\n"
            "[G92:10.000,0.000,0.500]\n[TLO:-1.500]\n[PRB:0.000,0.000,0.000:0]\nok\n")
    return text + "".join(prb(at, z) + "ok\n" for at, z in TRUTH.items()), TRUTH, set()


def grbl_inch():
    """$13=1: all of it in inches, four decimals."""
    text = f"$10=1\n$13=1\nok\n<Idle|MPos:0.0000,0.0000,0.0000|FS:0,0|WCO:{wco(4, 25.4)}>\n"
    return text + "".join(prb(at, z, 4, 25.4) + "ok\n" for at, z in TRUTH.items()), TRUTH, set()


def candle():
    cells = rows(lambda z: f"{z:.3f}".rstrip("0"))
    cells[2][1] = "nan"
    head = f"{X0:.2f};{Y0:.2f};{X1 - X0:.2f};{Y1 - Y0:.2f}\r\n{NX}.00;{NY}.00;-1.00;1.00\r\n0;0.50;0.50\r\n"
    kept, gone = without((1, 2))
    return head + "".join(";".join(row) + "\r\n" for row in cells), kept, gone


def csv_plan():
    """The list of `surface plan`, with heights written behind it but at two places."""
    kept, gone = without((0, 1), (4, 0))
    return "x,y\n" + "".join(f"{x:.9g},{y:.9g}" + ("" if (x, y) == place(0, 1) else "," if (x, y) == place(4, 0) else f",{height(x, y)}") + "\n"
                             for x, y in NODES), kept, gone


def csv_german():
    """Semicolons, decimal commas, another order of the columns, micrometres and a column that means nothing here."""
    lines = [f"{k};{1000 * z:.1f};{at[1]:.3f};{at[0]:.3f}".replace(".", ",") for k, (at, z) in enumerate(TRUTH.items())]
    return "\ufeffNr;H\u00f6he Z [\u00b5m];Y (mm);X (mm)\r\n" + "".join(line + "\r\n" for line in lines), TRUTH, set()


def csv_inch():
    return "x_in\ty_in\theight_in\n" + "".join(f"{x / 25.4:.9f}\t{y / 25.4:.9f}\t{z / 25.4:.9f}\n" for (x, y), z in TRUTH.items()), TRUTH, set()


def csv_blanks():
    return "# x y z\n" + "".join(f"{x:.3f}  {y:.3f}  {z:.4f}\n" for (x, y), z in TRUTH.items()), TRUTH, set()


def csv_unknown_names():
    return "easting,northing,level\n" + "".join(f"{x},{y},{z}\n" for (x, y), z in TRUTH.items()), TRUTH, set()


# Format as panelcal names it, name of the file, maker, options.
FLAGS = ("--mesh-mm", f"{X0},{Y0},{X1},{Y1}")
FILES = [("klipper", "printer.cfg", klipper, ()), ("klipper", "faulty.cfg", klipper_faulty_region, ()), ("klipper", "round.cfg", klipper_round, ()),
         ("moonraker", "answer.json", moonraker, ()), ("moonraker", "cleared.json", moonraker_profile, ()),
         ("marlin", "bilinear.log", marlin_bilinear, ()), ("marlin", "octoprint.log", marlin_grid_alone, FLAGS),
         ("marlin", "mesh.txt", marlin_mesh, FLAGS), ("marlin", "unified.txt", marlin_unified, ()),
         ("marlin", "unified_flags.txt", marlin_unified, FLAGS), ("marlin", "older.log", marlin_unified_older, ()),
         ("marlin", "touches.log", marlin_touches, ()), ("grbl", "status.log", grbl_status, ()), ("grbl", "parameters.log", grbl_parameters, ()),
         ("grbl", "inch.log", grbl_inch, ()), ("candle", "board.map", candle, ()), ("csv", "plan.csv", csv_plan, ()),
         ("csv", "german.csv", csv_german, ()), ("csv", "inch.tsv", csv_inch, ()), ("csv", "blanks.txt", csv_blanks, ()),
         ("csv", "names.csv", csv_unknown_names, ())]
