// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/command_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {

void add_init_options(CLI::App& command, InitOptions& o) {
  command.add_option("--template", o.kind, "Kind of machine (default: asked for at a terminal)")
      ->check(CLI::IsMember({"usb-camera-linuxcnc", "usb-camera-grbl", "gige-cnc7", "folder"}));
  command.add_option("-o,--output", o.output, "The new file")->capture_default_str();
  command.add_option("--name", o.name, "Of the machine, for reports");
  command.add_option("--camera", o.camera, "Address of the camera, for the commands in the file");
  command.add_option("--device", o.device, "Serial device of a GRBL (default: /dev/ttyUSB0)");
  command.add_option("--host", o.host, "Name or address of the control (default: this computer)");
  command
      .add_option("--um-per-px", o.um_per_px, "A pixel on the panel, um (default: 20 USB, else 10)")
      ->check(CLI::Range(0.1, 1000.0));
  command
      .add_option("--picture-px",
                  o.picture_px,
                  "Width,height of pictures (default: 640,480 USB, else 1280,1024)")
      ->delimiter(',')
      ->expected(2)
      ->check(CLI::Range(16, 65536));
  command
      .add_option("--fiducial-mm",
                  o.fiducials_mm,
                  "Diameters of round bright targets, vision tools 1, 2, ...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(0.01, 1000.0));
  command
      .add_option("--travel-mm", o.travel_mm, "Left,lower,right,upper edge of the machine's travel")
      ->delimiter(',')
      ->expected(4);
  command.add_option("--safe-z-mm", o.safe_z_mm, "Machine Z at and above which X and Y may move");
  command
      .add_option(
          "--camera-offset-mm", o.camera_offset_mm, "Spindle-camera offset X,Y (default: assumed)")
      ->delimiter(',')
      ->expected(2);
  command
      .add_option("--camera-offset-sigma-um",
                  o.camera_offset_sigma_um,
                  "Its sigma in x and in y (default: 1000, assumed)")
      ->check(CLI::NonNegativeNumber);
  command.add_option("CALIBRATION",
                     o.calibration,
                     "A camera calibration that exists (default: one is assumed and written)");
}

}  // namespace panelcal
