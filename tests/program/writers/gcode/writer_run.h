// SPDX-License-Identifier: Apache-2.0
// Operations, and the G-code that the writer makes of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "program/writers/gcode/writer.h"
#include <gtest/gtest.h>

#include "tests/program/operations.h"

namespace panelcal::test {

inline const std::string kModes = "G17 G21 G40 G54 G61 G80 G90 G91.1 G94 G98\n";

/// Holes go 1.8 mm, contours 2 mm below the board's surface, which is Z 0.
inline GcodeSetting on_the_board() {
  GcodeSetting setting;
  setting.safe_z = mm(5);
  setting.usual.drill_z = mm(-1.8);
  setting.usual.rout_z = mm(-2);
  setting.usual.infeed = mm_per_s(20);
  setting.usual.speed = rpm(30'000);
  return setting;
}

/// The tool is zeroed on the table.
inline GcodeSetting on_the_table() {
  GcodeSetting setting = on_the_board();
  setting.usual.drill_z = setting.usual.rout_z = std::nullopt;
  setting.table_z = mm(0);
  return setting;
}

struct Written {
  std::string text;  ///< behind the line of modes, which other flavours keep
  std::vector<std::string> losses;
  std::string failure;
};

/// Work zero is where test::place() has it.
inline Written write_out(const std::vector<What>& operations,
                         const GcodeSetting& setting = on_the_board(),
                         const ProgramInfo& info = metric_info()) {
  StringSink bytes;
  GcodeWriter writer(bytes, {.work_zero = position_mm<frame::Machine>(100, 200)}, setting);
  writer.begin(info);
  put_all(writer, operations);
  const Expected<void> done = writer.finish();
  Written written;
  written.text = bytes.text();
  const bool is_other = setting.flavour && *setting.flavour != GcodeFlavour::LinuxCnc;
  EXPECT_TRUE(is_other || written.text.empty() || written.text.starts_with(kModes)) << written.text;
  if (written.text.starts_with(kModes)) written.text.erase(0, kModes.size());
  if (!done) written.failure = done.error().text();
  for (const Diagnostic& loss : writer.losses().kept()) written.losses.push_back(loss.text());
  return written;
}

inline ProgramInfo sieb_meyer_info() {
  ProgramInfo info = metric_info();
  info.dialect = Dialect::SiebMeyer;
  return info;
}

inline ToolChange take(int number) {
  return {{.number = number, .diameter = mm(number == 1 ? 1 : 2.5)}, {}};
}
inline ToolChange take(const Tool& tool) {
  return {tool, {}};
}
inline Drill drill_at(double x_mm, double y_mm, const DepthOfCut& cut) {
  Drill hole = drill(1, x_mm, y_mm);
  hole.cut = cut;
  return hole;
}
inline Plunge plunge(const DepthOfCut& cut = {}) {
  return {2, PlungeKind::Plain, {}, cut};
}
inline DepthOfCut z(double z_mm) {
  DepthOfCut cut;
  cut.z = mm(z_mm);
  return cut;
}
inline DepthOfCut below(double depth_mm) {
  DepthOfCut cut;
  cut.depth = mm(depth_mm);
  cut.control = DepthControl::Depth;
  return cut;
}
inline DepthOfCut below(double depth_mm, double surface_mm) {
  DepthOfCut cut = below(depth_mm);
  cut.surface = mm(surface_mm);
  return cut;
}

}  // namespace panelcal::test
