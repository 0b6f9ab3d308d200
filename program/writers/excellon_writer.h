// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panelcal/program/writers/text_writer.h"

namespace panelcal {

/// A plain Excellon program: absolute coordinates with decimal points, no repeats and no vision, in
/// the unit of the source program. Coordinates are the corrected ones relative to work zero; a G93
/// of the source is kept, so that the controller adds work zero exactly as before.
class ExcellonWriter final : public TextWriter {
 public:
  /// `comments` go into the header, one line each: who wrote the file, and from what.
  ExcellonWriter(ByteSink& bytes, std::vector<std::string> comments);

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  void put_tool(const Tool& tool,
                bool with_data,
                std::optional<int> compensation_index = std::nullopt);
  void append_rate(char letter, Feed rate, int n_digits);
  void append_speed(SpindleSpeed speed);
  void append_length(Length length);
  void append_point(const Eigen::Vector2d& p_mm);
  void close_header();
  void write(const ToolChange& change);
  void write(const Drill& drill);
  void write(const Stop& stop);
  void write(const Message& message);
  void write(const Setting& setting);
  void write(const ZeroSet& zero);

  std::vector<std::string> comments_;
  ProgramInfo info_;
  bool in_header_ = true;
};

}  // namespace panelcal
