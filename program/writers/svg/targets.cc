// SPDX-License-Identifier: Apache-2.0
#include "program/writers/svg/targets.h"

#include <algorithm>
#include <cmath>

#include "program/text/xml_text.h"

namespace panelcal::svg {
namespace {

/// The longest arrow, as a part of the longer side.
constexpr double kLongestArrow = 0.08;
/// More targets than this are drawn smaller.
constexpr double kLargeTargets = 60;

/// An arrow as path data.
std::string arrow(const Eigen::Vector2d& from_mm, const Eigen::Vector2d& v_mm, double head_mm) {
  const double length_mm = v_mm.norm();
  if (!(length_mm > 0)) return {};
  const Eigen::Vector2d tip_mm = from_mm + v_mm;
  const Eigen::Vector2d back_mm = -std::min(head_mm, 0.5 * length_mm) / length_mm * v_mm;
  const Eigen::Vector2d aside_mm(-0.5 * back_mm.y(), 0.5 * back_mm.x());
  std::string path = "M";
  append_mm(path, from_mm);
  path += 'L';
  append_mm(path, tip_mm);
  path += 'M';
  append_mm(path, tip_mm + back_mm + aside_mm);
  path += 'L';
  append_mm(path, tip_mm);
  path += 'L';
  append_mm(path, tip_mm + back_mm - aside_mm);
  return path;
}

}  // namespace

Targets::Targets(const std::vector<SvgTarget>& targets, const Sheet& sheet) : targets_(targets) {
  const double n = static_cast<double>(targets.size());
  size_mm_ = 0.8 * sheet.text_mm() * std::clamp(std::sqrt(kLargeTargets / (n + 1)), 0.3, 1.0);
  for (const SvgTarget& target : targets) {
    if (target.residual) longest_mm_ = std::max(longest_mm_, target.residual->in_mm().norm());
  }
  if (longest_mm_ > 0) arrow_scale_ = nice_below(kLongestArrow * sheet.side_mm() / longest_mm_);
}

/// Two arms, and the ring as two half circles.
std::string Targets::cross(const Eigen::Vector2d& at_mm) const {
  const double radius_mm = 0.6 * size_mm_;
  std::string path = "M";
  append_mm(path, at_mm - Eigen::Vector2d(size_mm_, 0));
  path += 'h';
  append_mm(path, 2 * size_mm_);
  path += 'M';
  append_mm(path, at_mm - Eigen::Vector2d(0, size_mm_));
  path += 'v';
  append_mm(path, 2 * size_mm_);
  path += 'M';
  append_mm(path, at_mm - Eigen::Vector2d(radius_mm, 0));
  for (const double step_mm : {2 * radius_mm, -2 * radius_mm}) {
    path += 'a';
    append_mm(path, {radius_mm, radius_mm});
    path += " 0 0 1 ";
    append_mm(path, {step_mm, 0});
  }
  return path;
}

std::string Targets::marks() const {
  std::string out;
  std::string arrows;
  for (const SvgTarget& target : targets_) {
    const std::string path = cross(target.at.in_mm());
    out += "<path class=\"halo\" d=\"" + path + "\"/><path class=\"target\" d=\"" + path + "\"/>\n";
    if (!target.residual) continue;
    arrows += arrow(target.at.in_mm(), arrow_scale_ * target.residual->in_mm(), 0.5 * size_mm_);
  }
  if (!arrows.empty()) out += "<path class=\"residual\" d=\"" + arrows + "\"/>\n";
  return out;
}

std::string Targets::labels() const {
  std::string out;
  for (const SvgTarget& target : targets_) {
    if (target.label.empty()) continue;
    const Eigen::Vector2d& at_mm = target.at.in_mm();
    out += "<text x=\"";
    append_mm(out, at_mm.x() + 0.75 * size_mm_);
    out += "\" y=\"";
    append_mm(out, -at_mm.y() - 0.6 * size_mm_);
    out += "\" class=\"label\" style=\"font-size:";
    append_mm(out, size_mm_);
    out += "px\">";
    append_xml_text(out, target.label);
    out += "</text>\n";
  }
  return out;
}

}  // namespace panelcal::svg
