#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Puts four fiducials around a KiCad board and exports it as its user would: F.Cu as Gerber X2, plated and
unplated holes apart. Needs the system's Python, which has pcbnew.

usage: kicad_fiducials.py BOARD OUTPUT
prints the fiducials' places, mm, y up
"""

import json
import sys

import pcbnew

MM = 1_000_000


def add_fiducial(board, name, x, y):
    footprint = pcbnew.FOOTPRINT(board)
    footprint.SetReference(name)
    footprint.SetPosition(pcbnew.wxPoint(x, y))
    pad = pcbnew.PAD(footprint)
    pad.SetShape(pcbnew.PAD_SHAPE_CIRCLE)
    pad.SetAttribute(pcbnew.PAD_ATTRIB_SMD)
    pad.SetProperty(pcbnew.PAD_PROP_FIDUCIAL_GLBL)
    pad.SetSize(pcbnew.wxSize(MM, MM))
    layers = pcbnew.LSET()
    for layer in (pcbnew.F_Cu, pcbnew.F_Mask):
        layers.AddLayer(layer)
    pad.SetLayerSet(layers)
    pad.SetPosition(pcbnew.wxPoint(x, y))
    footprint.Add(pad)
    board.Add(footprint)


def plot_copper(board, folder):
    plotter = pcbnew.PLOT_CONTROLLER(board)
    options = plotter.GetPlotOptions()
    options.SetOutputDirectory(folder)
    options.SetUseGerberX2format(True)
    options.SetIncludeGerberNetlistInfo(True)
    plotter.SetLayer(pcbnew.F_Cu)
    plotter.OpenPlotfile("F_Cu", pcbnew.PLOT_FORMAT_GERBER, "top copper")
    plotter.PlotLayer()
    plotter.ClosePlot()


def main():
    path, folder = sys.argv[1:]
    board = pcbnew.LoadBoard(path)
    box = board.GetBoardEdgesBoundingBox()
    margin = 3 * MM
    places = [(x, y) for y in (box.GetBottom() - margin, box.GetTop() + margin)
              for x in (box.GetLeft() + margin, box.GetRight() - margin)]
    for i, (x, y) in enumerate(places):
        add_fiducial(board, f"FID{i + 1}", x, y)
    plot_copper(board, folder)
    drills = pcbnew.EXCELLON_WRITER(board)
    drills.SetOptions(False, False, pcbnew.wxPoint(0, 0), False)
    drills.SetFormat(True, pcbnew.GENDRILL_WRITER_BASE.DECIMAL_FORMAT)
    drills.CreateDrillandMapFilesSet(folder, True, False)
    print(json.dumps([(x / MM, -y / MM) for x, y in places]))


if __name__ == "__main__":
    main()
