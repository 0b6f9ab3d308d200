#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the board of the tutorial with KiCad 6: four fiducials, plated and unplated holes; Gerber and drill files.

usage: make_board.py OUTPUT
"""
import sys

import pcbnew

MM = 1_000_000
WIDTH_MM, HEIGHT_MM = 80, 60
FIDUCIALS_MM = [(4, 4), (76, 4), (76, 56), (4, 56)]
MOUNTING_MM = [(10, 5), (70, 5), (70, 55), (10, 55)]
PINS_MM = [(14 + 2.54 * i, y) for y in (12, 27.24, 42.48) for i in range(20)]


def point(x, y):
    return pcbnew.wxPoint(int(round(x * MM)), int(round((HEIGHT_MM - y) * MM)))


def add_pad(board, name, place, attribute, size_mm, drill_mm=0, is_fiducial=False):
    footprint = pcbnew.FOOTPRINT(board)
    footprint.SetReference(name)
    footprint.SetPosition(place)
    pad = pcbnew.PAD(footprint)
    pad.SetShape(pcbnew.PAD_SHAPE_CIRCLE)
    pad.SetAttribute(attribute)
    pad.SetSize(pcbnew.wxSize(int(size_mm * MM), int(size_mm * MM)))
    if drill_mm:
        pad.SetDrillSize(pcbnew.wxSize(int(drill_mm * MM), int(drill_mm * MM)))
    if is_fiducial:
        pad.SetProperty(pcbnew.PAD_PROP_FIDUCIAL_GLBL)
        layers = pcbnew.LSET()
        for layer in (pcbnew.F_Cu, pcbnew.F_Mask):
            layers.AddLayer(layer)
        pad.SetLayerSet(layers)
    pad.SetPosition(place)
    footprint.Add(pad)
    board.Add(footprint)


def main():
    folder = sys.argv[1]
    board = pcbnew.BOARD()
    outline = pcbnew.PCB_SHAPE(board, pcbnew.SHAPE_T_RECT)
    outline.SetLayer(pcbnew.Edge_Cuts)
    outline.SetStart(point(0, 0))
    outline.SetEnd(point(WIDTH_MM, HEIGHT_MM))
    board.Add(outline)
    for i, place in enumerate(FIDUCIALS_MM):
        add_pad(board, f"FID{i + 1}", point(*place), pcbnew.PAD_ATTRIB_SMD, 1, is_fiducial=True)
    for i, place in enumerate(PINS_MM):
        add_pad(board, f"J{i + 1}", point(*place), pcbnew.PAD_ATTRIB_PTH, 1.7, 1.0)
    for i, place in enumerate(MOUNTING_MM):
        add_pad(board, f"H{i + 1}", point(*place), pcbnew.PAD_ATTRIB_NPTH, 3.2, 3.2)
    pcbnew.SaveBoard(f"{folder}/board.kicad_pcb", board)
    board = pcbnew.LoadBoard(f"{folder}/board.kicad_pcb")
    # The place (0, 0) of the files is the board's lower left corner.
    origin = point(0, 0)
    board.GetDesignSettings().SetAuxOrigin(origin)
    plotter = pcbnew.PLOT_CONTROLLER(board)
    options = plotter.GetPlotOptions()
    options.SetOutputDirectory(folder)
    options.SetUseGerberX2format(True)
    options.SetUseAuxOrigin(True)
    plotter.SetLayer(pcbnew.F_Cu)
    plotter.OpenPlotfile("F_Cu", pcbnew.PLOT_FORMAT_GERBER, "top copper")
    plotter.PlotLayer()
    plotter.ClosePlot()
    drills = pcbnew.EXCELLON_WRITER(board)
    drills.SetOptions(False, False, origin, False)
    drills.SetFormat(True, pcbnew.GENDRILL_WRITER_BASE.DECIMAL_FORMAT)
    drills.CreateDrillandMapFilesSet(folder, True, False)


if __name__ == "__main__":
    main()
