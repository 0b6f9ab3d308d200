// SPDX-License-Identifier: Apache-2.0
#include "program/writers/svg/writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using svg::append_mm;

/// Drawn for a tool of unknown diameter.
constexpr double kUnknownDiameterMm = 0.5;
/// Path data of contours and rapid moves leave in pieces of about this size.
constexpr std::size_t kPieceBytes = 32768;
/// Legend rows besides those of tools: targets, residuals, rapid moves, compensation, instances.
constexpr std::size_t kOtherRows = 5;

/// Room for everything with the widths of the tools, and some around it.
svg::Sheet sheet_of(const SvgScene& scene, const Tally& tally) {
  BoundingBox<frame::Actual> box;
  if (!tally.tools_used().empty()) {
    const auto& worked = tally.corrected_box();
    box.add(worked.is_empty() ? Position<frame::Actual>() : worked.low());
    box.add(worked.is_empty() ? Position<frame::Actual>() : worked.high());
  }
  for (const SvgTarget& target : scene.targets) box.add(target.at);
  Eigen::Vector2d low_mm(0, 0);
  Eigen::Vector2d high_mm(0, 0);
  if (!box.is_empty()) {
    low_mm = box.low().in_mm();
    high_mm = box.high().in_mm();
  }
  double widest_mm = kUnknownDiameterMm;
  for (const auto& [number, tool] : tally.tools()) {
    if (tool.diameter) widest_mm = std::max(widest_mm, tool.diameter->in_mm());
  }
  const double margin_mm = 0.04 * (high_mm - low_mm).maxCoeff() + widest_mm;
  return {low_mm.array() - margin_mm,
          high_mm.array() + margin_mm,
          tally.tools_used().size() + kOtherRows,
          scene.title,
          scene.provenance};
}

// A mark in the drawing: kMarkBegin, what it stands for, kMarkEnd.
constexpr char kMarkBegin = '\x01';
constexpr char kMarkEnd = '\x02';
constexpr char kColorMark = 'c';   ///< and a tool's number
constexpr char kDarkerMark = 'd';  ///< the same
constexpr char kThinMark = 'w';    ///< and a width in mm that it is not to exceed

std::string mark(char kind, int tool) {
  return fmt::format("{}{}{}{}", kMarkBegin, kind, tool, kMarkEnd);
}

std::string thin_mark(double at_most_mm) {
  return fmt::format("{}{}{}{}", kMarkBegin, kThinMark, at_most_mm, kMarkEnd);
}

template <class Number>
Number mark_number(std::string_view text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Passes a drawing on, with what its marks stand for.
class MarkReader final : public ByteSink {
 public:
  using Meaning = std::function<std::string(char kind, std::string_view argument)>;

  MarkReader(ByteSink& bytes, Meaning meaning) : bytes_(bytes), meaning_(std::move(meaning)) {}

  Expected<void> write(std::string_view bytes) override {
    std::string out;
    out.reserve(bytes.size());
    while (!bytes.empty()) {
      const std::size_t end = bytes.find(is_in_mark_ ? kMarkEnd : kMarkBegin);
      (is_in_mark_ ? mark_ : out) += bytes.substr(0, end);
      if (end == std::string_view::npos) break;
      bytes.remove_prefix(end + 1);
      if (is_in_mark_) out += meaning_(mark_.front(), std::string_view(mark_).substr(1));
      mark_.clear();
      is_in_mark_ = !is_in_mark_;
    }
    return bytes_.write(out);
  }

 private:
  ByteSink& bytes_;
  Meaning meaning_;
  bool is_in_mark_ = false;
  std::string mark_;
};

std::string grouped(std::int64_t n) {
  std::string digits = fmt::format("{}", n);
  for (std::size_t end = digits.size(); end > 3;) {
    end -= 3;
    digits.insert(end, 1, ',');
  }
  return digits;
}

void append_count(std::string& out, std::int64_t n, std::string_view noun) {
  if (n == 0) return;
  if (!out.empty()) out += ", ";
  out += grouped(n);
  out += ' ';
  out += noun;
  if (n != 1) out += 's';
}

std::string shortest(double value, int n_decimals) {
  std::string out;
  append_fixed(out, value, n_decimals);
  return out;
}

}  // namespace

SvgWriter::SvgWriter(ByteSink& bytes, SvgScene scene)
    : TextWriter(drawing_), bytes_(bytes), scene_(std::move(scene)) {
}

void SvgWriter::begin(const ProgramInfo& info) {
  tally_.begin(info);
  tools_ = info.tools;
}

SvgWriter::Ink& SvgWriter::ink_of(int tool) {
  const auto known = inks_.find(tool);
  if (known != inks_.end()) return known->second;
  Ink ink;
  ink.width_mm = kUnknownDiameterMm;
  const auto data = tools_.find(tool);
  if (data != tools_.end()) set_width(ink, data->second);
  return inks_.emplace(tool, ink).first->second;
}

void SvgWriter::choose_colors() {
  std::size_t i_color = 0;
  for (auto& [tool, ink] : inks_) {
    ink.color = svg::tool_color(i_color);
    if (tool != 0) ++i_color;  // T0 is drawn without one
  }
}

void SvgWriter::set_width(Ink& ink, const Tool& tool) {
  ink.is_width_known = tool.diameter.has_value();
  ink.width_mm = tool.diameter.value_or(mm(kUnknownDiameterMm)).in_mm();
}

// --- drawing -----------------------------------------------------------------------------------

void SvgWriter::put(const Operation& operation) {
  tally_.put(operation);
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    open_holes(drill->tool);
    ++hole_ink_->n_holes;
    text() += "<circle cx=\"";
    append_mm(text(), drill->corrected.in_mm().x());
    text() += "\" cy=\"";
    append_mm(text(), drill->corrected.in_mm().y());
    text() += hole_end_;
    instances_.add(operation, *drill, hole_ink_->width_mm / 2);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    put_rout(*rout);
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    put_rapid_move(*move);
  } else if (const auto* compensation = std::get_if<Compensation>(&operation.what)) {
    const double half_mm = compensation->value.value_or(Length()).in_mm() / 2;
    left_mm_ = compensation->side == CompensationSide::Left    ? half_mm
               : compensation->side == CompensationSide::Right ? -half_mm
                                                               : 0;
  } else if (std::holds_alternative<Retract>(operation.what)) {
    flush_contour();
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    put_slot(operation, slot->tool, slot->start, slot->end);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
    left_mm_ = 0;  // the cycle begins with G40
    put_slot(operation, step_slot->tool, step_slot->start, step_slot->end);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    flush_contour();
    close_holes();
    if (change->tool.number > 0) {
      tools_[change->tool.number] = change->tool;
      const auto ink = inks_.find(change->tool.number);
      if (ink != inks_.end()) set_width(ink->second, change->tool);
    }
  }
  flush_if_large();
}

/// Holes without a tool are outlines, whatever else is known.
void SvgWriter::open_holes(int tool) {
  if (hole_tool_ == tool) return;
  flush_contour();
  close_holes();
  hole_tool_ = tool;
  hole_ink_ = &ink_of(tool);
  text() += tool > 0 ? fmt::format("<g class=\"t{}\" fill=\"{}\">\n", tool, mark(kColorMark, tool))
                     : "<g class=\"untooled\">\n";
  hole_end_ = "\" r=\"";
  append_mm(hole_end_, hole_ink_->width_mm / 2);
  hole_end_ += "\"/>\n";
}

void SvgWriter::close_holes() {
  if (hole_tool_) text() += "</g>\n";
  hole_tool_.reset();
}

void SvgWriter::put_slot(const Operation& operation,
                         int tool,
                         const PlacedPoint& start,
                         const PlacedPoint& end) {
  flush_contour();
  close_holes();
  Ink& ink = ink_of(tool);
  ++ink.n_slots;
  text() += "<path d=\"M";
  append_mm(text(), start.corrected.in_mm());
  text() += 'L';
  append_mm(text(), end.corrected.in_mm());
  internal::append_format(text(),
                          "\" class=\"way\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                          mark(kColorMark, tool),
                          shortest(ink.width_mm, 3));
  instances_.add(operation, start, ink.width_mm / 2);
  instances_.add(operation, end, ink.width_mm / 2);
}

/// The control switches compensation off during the move (CNC-7 manual, Rout Mode).
void SvgWriter::put_rapid_move(const PlacedPoint& place) {
  flush_contour();
  left_mm_ = 0;
  const Eigen::Vector2d to_mm = place.corrected.in_mm();
  if (router_mm_ && scene_.shows_rapid_moves) {
    has_rapid_moves_ = true;
    rapid_moves_ += 'M';
    append_mm(rapid_moves_, *router_mm_);
    rapid_moves_ += 'L';
    append_mm(rapid_moves_, to_mm);
    if (rapid_moves_.size() >= kPieceBytes) flush_rapid_moves();
  }
  router_mm_ = to_mm;
}

void SvgWriter::put_rout(const Rout& rout) {
  const Eigen::Vector2d to_mm = rout.corrected.in_mm();
  Eigen::Vector2d from_mm = router_mm_.value_or(to_mm);
  Eigen::Vector2d drawn_to_mm = to_mm;
  router_mm_ = to_mm;

  const bool is_line = rout.kind == RoutKind::Line;
  const Eigen::Vector2d center_mm = rout.corrected_center.in_mm();
  double radius_mm = (from_mm - center_mm).norm();
  if (left_mm_ != 0) {
    has_compensation_ = true;
    if (is_line) {
      const Eigen::Vector2d along = (to_mm - from_mm).normalized();
      const Eigen::Vector2d shift_mm = left_mm_ * Eigen::Vector2d(-along.y(), along.x());
      from_mm += shift_mm;
      drawn_to_mm += shift_mm;
    } else {
      // Left of a counter-clockwise arc is inside.
      const double inward_mm = rout.kind == RoutKind::Counterclockwise ? left_mm_ : -left_mm_;
      radius_mm = std::max(0.0, radius_mm - inward_mm);
      from_mm = center_mm + radius_mm * (from_mm - center_mm).normalized();
      drawn_to_mm = center_mm + radius_mm * (to_mm - center_mm).normalized();
    }
  }

  if (contour_.empty() || contour_tool_ != rout.tool) {
    flush_contour();
    close_holes();
    contour_tool_ = rout.tool;
  }
  if (contour_.empty() || left_mm_ != 0) {
    contour_ += 'M';
    append_mm(contour_, from_mm);
  }
  if (is_line) {
    contour_ += 'L';
  } else {
    contour_ += 'A';
    append_mm(contour_, {radius_mm, radius_mm});
    contour_ += rout.kind == RoutKind::Counterclockwise ? " 0 0 1 " : " 0 0 0 ";
  }
  append_mm(contour_, drawn_to_mm);
  ++ink_of(rout.tool).n_routs;
  if (contour_.size() >= kPieceBytes) flush_contour();
}

void SvgWriter::flush_contour() {
  if (contour_.empty()) return;
  const Ink& ink = ink_of(contour_tool_);
  internal::append_format(text(),
                          "<path d=\"{0}\" class=\"rout\" stroke=\"{1}\" stroke-width=\"{2}\"/>\n"
                          "<path d=\"{0}\" class=\"way\" stroke=\"{3}\" stroke-width=\"{4}\"/>\n",
                          contour_,
                          mark(kColorMark, contour_tool_),
                          shortest(ink.width_mm, 3),
                          mark(kDarkerMark, contour_tool_),
                          thin_mark(ink.width_mm / 4));
  contour_.clear();
}

void SvgWriter::flush_rapid_moves() {
  if (rapid_moves_.empty()) return;
  close_holes();
  text() += "<path class=\"rapid\" d=\"" + rapid_moves_ + "\"/>\n";
  rapid_moves_.clear();
}

// --- around it ---------------------------------------------------------------------------------

std::vector<svg::LegendRow> SvgWriter::legend(const svg::Targets& targets) const {
  std::vector<svg::LegendRow> rows;
  for (const auto& [number, ink] : inks_) {
    svg::LegendRow& row = rows.emplace_back();
    row.swatch = number > 0
                     ? fmt::format("<circle r=\".45\" fill=\"{}\"/>", ink.color.hex())
                     : "<circle r=\".4\" fill=\"none\" stroke=\"#222\" stroke-width=\".1\"/>";
    row.text = number > 0 ? fmt::format("T{}, ", number) : "no tool, ";
    row.text += ink.is_width_known ? shortest(ink.width_mm, 3) + " mm"
                                   : "diameter unknown, drawn " + shortest(ink.width_mm, 3) + " mm";
    append_count(row.detail, ink.n_holes, "hole");
    append_count(row.detail, ink.n_slots, "slot");
    append_count(row.detail, ink.n_routs, "rout move");
  }
  if (!scene_.targets.empty()) {
    rows.push_back(
        {"<path d=\"M-.5 0h1M0-.5v1M-.3 0a.3 .3 0 0 1 .6 0a.3 .3 0 0 1-.6 0\" "
         "fill=\"none\" stroke=\"#111\" stroke-width=\".08\"/>",
         "vision target",
         grouped(static_cast<std::int64_t>(scene_.targets.size()))});
  }
  if (const double scale = targets.arrow_scale(); scale > 0) {
    rows.push_back(
        {"<path d=\"M-.5 0H.5L.2 .2M.5 0L.2-.2\" fill=\"none\" stroke=\"#d40000\" "
         "stroke-width=\".1\"/>",
         "residual, drawn " + (scale < 1e3 ? shortest(scale, 6) : grouped(std::llround(scale))) +
             " times longer",
         "longest " + shortest(targets.longest_residual_mm() * 1e3, 2) + " um"});
  }
  if (has_rapid_moves_) {
    rows.push_back(
        {"<path d=\"M-.5 0h1\" stroke=\"#777\" stroke-width=\".08\" "
         "stroke-dasharray=\".25 .12\"/>",
         "rapid move",
         {}});
  }
  if (has_compensation_) {
    rows.push_back({"<path d=\"M-.5 0h1\" stroke=\"#333\" stroke-width=\".08\"/>",
                    "center of the router",
                    "contours shifted by compensation"});
  }
  if (instances_.n() > 0) {
    rows.push_back(
        {"<path d=\"M-.45-.35h.9v.7h-.9z\" fill=\"none\" stroke=\"#777\" "
         "stroke-width=\".08\"/>",
         "step and repeat",
         grouped(static_cast<std::int64_t>(instances_.n())) +
             (instances_.is_complete() ? " instances" : " instances framed, not all")});
  }
  return rows;
}

void SvgWriter::end() {
  flush_contour();
  close_holes();
  flush_rapid_moves();
  if (const std::string frames = instances_.frames(); !frames.empty()) {
    text() += "<path class=\"instance\" d=\"" + frames + "\"/>\n";
  }
  flush();
  if (has_failed()) return;
  choose_colors();
  const svg::Sheet sheet = sheet_of(scene_, tally_);
  const svg::Targets targets(scene_.targets, sheet);
  MarkReader drawing(bytes_, [&](char kind, std::string_view argument) {
    if (kind == kThinMark) {
      return shortest(std::min(sheet.thin_mm(), mark_number<double>(argument)), 4);
    }
    const svg::Color& color = inks_.at(mark_number<int>(argument)).color;
    return (kind == kDarkerMark ? color.darker() : color).hex();
  });
  Expected<void> done = bytes_.write(sheet.open());
  if (done) done = drawing_.pass_to(drawing);
  if (done) {
    done = bytes_.write(targets.marks() + sheet.close(targets.labels(), legend(targets)));
  }
  if (!done) fail(std::move(done).error());
}

}  // namespace panelcal
