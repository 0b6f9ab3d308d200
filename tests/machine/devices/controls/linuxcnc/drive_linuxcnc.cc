// SPDX-License-Identifier: Apache-2.0
// Drives the LinuxCNC of a machine file, for the test with the real control:
//
//   drive_linuxcnc MACHINE_TOML
//
// Each line of standard input, "move X Y" or "probe X Y" in mm, is answered by one: "at X Y",
// "height Z", "nothing REASON" or the diagnostic.
#include <iostream>
#include <sstream>
#include <string>

#include "calib/base/interruption.h"
#include "machine/config/machine_config.h"
#include "machine/devices/controls/open/open_control.h"
#include <fmt/format.h>

namespace panelcal::test {
namespace {

std::string answer(const OpenedControl& control, const std::string& line) {
  std::istringstream words(line);
  std::string what;
  double x_mm = 0, y_mm = 0;
  words >> what >> x_mm >> y_mm;
  if (what == "move") {
    const auto at = control.stage->move_to(position_mm<frame::Machine>(x_mm, y_mm));
    if (!at) return at.error().text();
    return fmt::format("at {:.6f} {:.6f}", at->in_mm().x(), at->in_mm().y());
  }
  ProbeRequest request;
  request.expected = position_mm<frame::Actual>(x_mm, y_mm);
  const auto reading = control.probe->probe(request);
  if (!reading) return reading.error().text();
  if (reading->status != ProbeStatus::Found) return "nothing " + reading->reason;
  return fmt::format("height {:.6f}", reading->heights.at(0).height.in_mm());
}

int run(const std::string& file) {
  heed_interruptions();
  const auto config = read_machine_config(file);
  if (!config) {
    std::cout << config.error().text() << std::endl;
    return 2;
  }
  const auto control = open_control(*config);
  if (!control) {
    std::cout << control.error().text() << std::endl;
    return 3;
  }
  std::cout << control->words << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << answer(*control, line) << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace panelcal::test

int main(int argc, char** argv) {
  return argc == 2 ? panelcal::test::run(argv[1]) : 2;
}
