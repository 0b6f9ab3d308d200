// SPDX-License-Identifier: Apache-2.0
#include "tests/machine/devices/controls/linuxcnc/fault_series.h"

#include <chrono>
#include <thread>

#include "machine/config/machine_config.h"
#include "machine/devices/controls/linuxcnc/linuxcnc.h"

namespace panelcal::test {
namespace {

Expected<void> job(int port) {
  MachineConfig config;
  config.control = control_of_fake(port);
  PANELCAL_TRY(const OpenedControl control, internal::open_linuxcnc(config));
  PANELCAL_CHECK(control.stage->move_to(position_mm<frame::Machine>(40, 30)));
  PANELCAL_CHECK(control.stage->move_to(position_mm<frame::Machine>(140, 90)));
  ProbeRequest request;
  request.expected = position_mm<frame::Actual>(60, 50);
  PANELCAL_TRY(const ProbeReading reading, control.probe->probe(request));
  if (reading.heights.size() == 1 && std::abs(reading.heights[0].height.in_mm() - 0.25) < 1e-5) {
    return {};
  }
  return failure({Code::Internal, {}, "a height that is not the surface's", ""});
}

}  // namespace

ControlSetting control_of_fake(int port) {
  ControlSetting out;
  out.driver = ControlKind::LinuxCnc;
  out.port = port;
  out.limit = seconds(10);
  out.probe = ControlProbe{60, mm(-10), mm(-20), mm(-12)};
  return out;
}

FaultedJob run_with_fault(CncFault fault, int at, int in_move) {
  FakeLinuxCnc fake({.surface_mm = [](double, double) { return -11.75; },
                     .fault_at = at,
                     .fault_in_move = in_move,
                     .fault = fault});
  FaultedJob out;
  const auto done = job(fake.port());
  if (!done) out.text = done.error().text();
  const Eigen::Vector3d before_mm = fake.place_mm();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  out.moves_on = fake.moves() || fake.place_mm() != before_mm;
  out.n_requests = fake.n_requests();
  out.was_low = fake.was_low_in_xy();
  return out;
}

std::string_view cause_of(CncFault fault) {
  switch (fault) {
    case CncFault::None:
      return "";
    case CncFault::Close:
    case CncFault::Gone:
      return "lost connection";
    case CncFault::Silence:
      return "does not answer";
    case CncFault::Garbage:
    case CncFault::Nak:
      return "";  // also a refused password, and what the control then says of itself
    case CncFault::Estop:
      return "emergency stop";
    case CncFault::Limit:
      return "joint 1 is at a limit";
    case CncFault::Fault:
      return "joint 2 has a fault";
    case CncFault::Pause:
      return "paus";
    case CncFault::Hold:
      return "feed hold";
    case CncFault::Mode:
      return "mode";
    case CncFault::Steal:
      return "another client";
    case CncFault::Error:
      return "following error";
    case CncFault::ProbeStuck:
      return "probe touches";
  }
  return "";
}

}  // namespace panelcal::test
