// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/files/spool.h"
#include "program/judge/tally.h"
#include "program/writers/svg/instances.h"
#include "program/writers/svg/sheet.h"
#include "program/writers/svg/targets.h"
#include "program/writers/text_writer.h"

namespace panelcal {

/// The content of a picture besides the operations.
struct SvgScene {
  std::vector<SvgTarget> targets;
  std::string title;
  std::vector<std::string> provenance;  ///< the file's maker and inputs; one line each
  bool shows_rapid_moves = true;
};

/// A picture of the corrected job for people, to scale: holes, slots and routs in a colour per
/// tool, targets with residuals, frames of step-and-repeat instances, a legend. Compensated routs
/// are shifted by half of the compensation value, as the controller does, each by itself. Memory
/// does not grow with the number of holes.
///
/// The size of the picture and its tools are known with the last operation, so the drawing waits in
/// a spool, with marks where colours and thin lines go.
///
/// See    docs/formats/svg.md; tests/program/writers/svg/writer_test.cc
class SvgWriter final : public TextWriter {
 public:
  SvgWriter(ByteSink& bytes, SvgScene scene);
  SvgWriter(const SvgWriter&) = delete;
  SvgWriter& operator=(const SvgWriter&) = delete;

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  /// Drawing of a tool, and its operations.
  struct Ink {
    svg::Color color;
    double width_mm = 0;  ///< the tool's diameter, or a stand-in
    bool is_width_known = false;
    std::int64_t n_holes = 0;
    std::int64_t n_slots = 0;
    std::int64_t n_routs = 0;
  };

  void end() override;
  Ink& ink_of(int tool);
  void set_width(Ink& ink, const Tool& tool);
  void open_holes(int tool);
  void close_holes();
  void put_slot(const Operation& operation,
                int tool,
                const PlacedPoint& start,
                const PlacedPoint& end);
  void put_rapid_move(const PlacedPoint& place);
  void choose_colors();
  void put_rout(const Rout& rout);
  void flush_contour();
  void flush_rapid_moves();
  std::vector<svg::LegendRow> legend(const svg::Targets& targets) const;

  ByteSink& bytes_;
  Spool drawing_;
  SvgScene scene_;
  Tally tally_;
  std::map<int, Tool> tools_;  ///< as far as the job has come
  std::map<int, Ink> inks_;

  std::optional<int> hole_tool_;  ///< a group of this tool's holes is open
  Ink* hole_ink_ = nullptr;
  std::string hole_end_;  ///< the text behind the center of a hole

  std::optional<Eigen::Vector2d> router_mm_;  ///< place of the router
  double left_mm_ = 0;                        ///< shift by compensation to the left
  std::string contour_;                       ///< path data not yet written
  int contour_tool_ = 0;
  std::string rapid_moves_;
  bool has_rapid_moves_ = false;
  bool has_compensation_ = false;
  svg::Instances instances_;
};

}  // namespace panelcal
