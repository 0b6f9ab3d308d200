// SPDX-License-Identifier: Apache-2.0
// Operations made by hand, for tests of sinks.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/byte_sink.h"
#include "program/model/operation.h"
#include "program/writers/text_writer.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::test {

/// Corrected to (x, y) mm from (x - 0.25, y - 0.5), with sigmas of 2 and 3 um; work zero is at
/// (100, 200).
inline PlacedPoint place(double x_mm, double y_mm) {
  const Eigen::Vector2d at_mm(x_mm, y_mm);
  return {position_mm<frame::Nominal>(at_mm - Eigen::Vector2d(0.25, 0.5)),
          position_mm<frame::Actual>(at_mm),
          displacement_mm<frame::Machine>(at_mm),
          position_mm<frame::Machine>(at_mm + Eigen::Vector2d(100, 200)),
          Eigen::Vector2d(4e-6, 9e-6).asDiagonal()};
}

inline Drill drill(int tool, double x_mm, double y_mm) {
  return {place(x_mm, y_mm), tool};
}

inline RapidMove rapid_move(double x_mm, double y_mm) {
  return {place(x_mm, y_mm)};
}

inline Rout rout_line(int tool, double x_mm, double y_mm, Feed feed = mm_per_s(20)) {
  Rout rout{place(x_mm, y_mm)};
  rout.tool = tool;
  rout.feed = feed;
  return rout;
}

inline Rout rout_arc(
    RoutKind kind, int tool, double x_mm, double y_mm, double center_x_mm, double center_y_mm) {
  Rout rout = rout_line(tool, x_mm, y_mm);
  rout.kind = kind;
  rout.corrected_center = position_mm<frame::Actual>(center_x_mm, center_y_mm);
  rout.commanded_center = displacement_mm<frame::Machine>(center_x_mm, center_y_mm);
  rout.center = position_mm<frame::Machine>(center_x_mm + 100, center_y_mm + 200);
  return rout;
}

inline Function function(FunctionKind kind, std::string_view text) {
  Function function;
  function.kind = kind;
  function.text = text;
  return function;
}

/// A metric program with tools 1 (1 mm) and 2 (2.5 mm) in its header.
inline ProgramInfo metric_info() {
  ProgramInfo info;
  info.file = "p.exc";
  info.format = {.unit = LengthUnit::Millimeter, .integer_digits = 3, .decimal_digits = 3};
  info.tools = {{1, {.number = 1, .diameter = mm(1)}}, {2, {.number = 2, .diameter = mm(2.5)}}};
  return info;
}

using What = decltype(Operation::what);

/// Passes operations to a sink, numbering their lines from 10 on.
inline void put_all(OperationSink& sink, const std::vector<What>& operations) {
  int line = 10;
  for (const What& what : operations) sink.put({line++, {}, what, {}, nullptr});
}

/// Text of a writer for these operations.
template <class Writer, class... Arguments>
std::string written(const std::vector<What>& operations,
                    const ProgramInfo& info,
                    Arguments&&... arguments) {
  StringSink bytes;
  Writer writer(bytes, std::forward<Arguments>(arguments)...);
  writer.begin(info);
  put_all(writer, operations);
  const Expected<void> done = writer.finish();
  EXPECT_TRUE(done) << done.error().text();
  return bytes.text();
}

}  // namespace panelcal::test
