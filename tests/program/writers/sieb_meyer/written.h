// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "program/writers/sieb_meyer/writer.h"

#include "tests/program/operations.h"

namespace panelcal::test::to_sieb_meyer {

inline const std::string kBegin = "%%5000\nM49,FV1\nM49,NONIBO\nM49,NIB0.013\nM49,NORA\nM49,NOSA\n";

/// The tools of metric_info, in either language.
inline ProgramInfo info_of(Dialect dialect) {
  ProgramInfo info = metric_info();
  info.file = "p";
  info.dialect = dialect;
  return info;
}

struct Written {
  std::string text;
  std::string body;  ///< between the lines of every program and the tool table
  std::vector<std::string> losses;
  std::string failure;
};

inline Written write_out(const std::vector<What>& operations,
                         const ProgramInfo& info,
                         ProgramWriterOptions options = {}) {
  StringSink bytes;
  SiebMeyerWriter writer(bytes, std::move(options));
  writer.begin(info);
  put_all(writer, operations);
  const Expected<void> done = writer.finish();
  Written written;
  written.text = bytes.text();
  if (!done) written.failure = done.error().text();
  for (const Diagnostic& loss : writer.losses().kept()) written.losses.push_back(loss.text());
  if (const auto at = written.text.find(kBegin); at != std::string::npos) {
    const auto end = written.text.find("$\n");
    written.body = written.text.substr(at + kBegin.size(), end - at - kBegin.size());
  }
  return written;
}

inline Written from_excellon(const std::vector<What>& operations,
                             ProgramWriterOptions options = {}) {
  return write_out(operations, info_of(Dialect::Excellon), std::move(options));
}
inline Written from_sieb_meyer(const std::vector<What>& operations,
                               ProgramWriterOptions options = {}) {
  return write_out(operations, info_of(Dialect::SiebMeyer), std::move(options));
}
inline ProgramWriterOptions kept() {
  return {.allow_losses = true, .keeps_vision = true};
}

inline ToolChange take(int number, double diameter_mm) {
  return {{.number = number, .diameter = mm(diameter_mm)}, {}};
}
inline Plunge plunge(int tool, DepthOfCut cut = {}) {
  return {tool, PlungeKind::Plain, {}, cut};
}
inline Drill drill_at(double x_mm, double y_mm, DepthOfCut cut) {
  Drill hole = drill(1, x_mm, y_mm);
  hole.cut = cut;
  return hole;
}
inline DepthOfCut z(double z_mm) {
  return {.z = mm(z_mm), .depth = {}, .surface = {}};
}
inline DepthOfCut below(double depth_mm, std::optional<Length> surface = {}) {
  return {.z = {}, .depth = mm(depth_mm), .surface = surface, .control = DepthControl::Depth};
}

}  // namespace panelcal::test::to_sieb_meyer
