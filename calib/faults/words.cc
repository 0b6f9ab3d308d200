// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/words.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

/// Of a map that can be turned round.
constexpr double kLeastDeterminant = 0.1;

/// In um below a millimetre.
std::string length(double mm) {
  return std::abs(mm) < 1 ? fmt::format("{:.1f} um", mm * 1e3) : fmt::format("{:.3f} mm", mm);
}

std::string place(const Eigen::Vector2d& p_mm) {
  return fmt::format("({:.4f}, {:.4f}) mm", p_mm.x(), p_mm.y());
}

std::string pad_name(const KnownPad& pad) {
  std::string out =
      pad.tool > 0 ? fmt::format("the hole of tool {} at nominal {}", pad.tool, place(pad.place_mm))
                   : "the target at nominal " + place(pad.place_mm);
  if (pad.line > 0) out += fmt::format(" (line {})", pad.line);
  return out;
}

/// Facts about the place of a target that was seen there and should be elsewhere.
std::string damaged_words(const FaultStory& story, const Series& series) {
  const ToldTarget& target = series.targets[*story.i_point];
  const bool sees_place = target.axes == ObservedAxes::Both &&
                          std::abs(story.told.linear.determinant()) > kLeastDeterminant;
  if (series.pads == nullptr || !sees_place) return ": a damaged mark, or another pad";
  const Eigen::Vector2d seen_mm =
      story.told.linear.inverse() * (target.to_mm - story.told.translation_mm);
  constexpr double kNear_mm = 1;
  const auto is_another = [&](std::size_t i) {
    return (series.pads->all()[i].place_mm - target.from_mm).norm() > 1e-3;
  };
  if (std::ranges::any_of(series.pads->within(seen_mm, kNear_mm), is_another)) {
    return ": a damaged mark, or a pad near by";
  }
  return ", where the program drills nothing: a damaged or covered mark";
}

std::string liar_words(const FaultStory& story, const Series& series, std::string_view target) {
  const std::size_t n_others = series.targets.size() - 1;
  std::string off = fmt::format(
      "{} is {} from where the other {} put it", target, length(story.off_mm), n_others);
  switch (story.cause) {
    case FaultCause::WrongPad:
      return fmt::format("{}, and {} from where they put {}: that was taken for it",
                         off,
                         length(story.pad_off_mm),
                         pad_name(*story.pad));
    case FaultCause::OutOfFocus:
      return off + ", and its picture is worse than theirs: out of focus, or dirty";
    default:
      return off + damaged_words(story, series);
  }
}

std::string_view turn_words(StoryKind kind) {
  switch (kind) {
    case StoryKind::QuarterLeft:
      return "the panel is turned by 90 degrees counter-clockwise";
    case StoryKind::QuarterRight:
      return "the panel is turned by 90 degrees clockwise";
    case StoryKind::MirroredX:
      return "the panel is mirrored, left and right exchanged: the other side is up";
    case StoryKind::MirroredY:
      return "the panel is mirrored, top and bottom exchanged: the other side is up";
    case StoryKind::MirroredDiagonal:
    case StoryKind::MirroredAntidiagonal:
      return "the panel is mirrored and turned by 90 degrees: the other side is up";
    default:
      return "the panel is turned by 180 degrees";
  }
}

std::string scale_words(double factor) {
  const auto is = [factor](double other) { return std::abs(factor / other - 1) < 1e-9; };
  std::string_view why = "zero suppression or number of digits";
  if (is(25.4) || is(1 / 25.4)) why = "inches and millimetres exchanged";
  if (is(2.54) || is(1 / 2.54) || is(0.254) || is(1 / 0.254)) {
    why = "inches and millimetres exchanged, and zero suppression or number of digits";
  }
  return fmt::format("the panel is {:.4g} times as large as programmed: {}", factor, why);
}

std::string far_words(const Evidence& told, const Series& series) {
  const PanelDeformation d = deformation_of(told.linear);
  const Eigen::Vector2d middle = middle_mm(series);
  const Eigen::Vector2d shift_mm = told.linear * middle + told.translation_mm - middle;
  return fmt::format(
      "the targets fit each other, but shifted by ({:.3f}, {:.3f}) mm, turned by {:.3f} mrad and "
      "stretched by {:.0f} ppm in x and {:.0f} ppm in y: another revision, or laid outside the "
      "limits",
      shift_mm.x(),
      shift_mm.y(),
      d.rotation_rad * 1e3,
      (d.scale_x - 1) * 1e6,
      (d.scale_y - 1) * 1e6);
}

/// The deformation that the model leaves out, as far as the affine map has it.
std::string softer_words(const Evidence& told, PanelModel model) {
  const PanelDeformation d = deformation_of(told.linear);
  std::string what;
  if (model == PanelModel::Offset)
    what = fmt::format("turned by {:.3f} mrad, ", d.rotation_rad * 1e3);
  if (model != PanelModel::Stretch) {
    what += fmt::format("stretched by {:.0f} ppm in x and {:.0f} ppm in y, ",
                        (d.scale_x - 1) * 1e6,
                        (d.scale_y - 1) * 1e6);
  }
  what += fmt::format("skewed by {:.0f} ppm", d.shear * 1e6);
  return fmt::format("model \"{}\" does not include: panel {}", name(model), what);
}

}  // namespace

std::string words_of(const FaultStory& story,
                     const Series& series,
                     std::span<const ExaminedTarget> targets) {
  if (story.i_point) return liar_words(story, series, targets[*story.i_point].name);
  switch (story.cause) {
    case FaultCause::TurnedQuarter:
    case FaultCause::TurnedHalf:
    case FaultCause::Mirrored:
      return std::string(turn_words(story.kind));
    case FaultCause::WrongScale:
      return scale_words(story.factor);
    case FaultCause::WrongRevision:
      if (story.kind == StoryKind::Far) return far_words(story.told, series);
      return "several targets are elsewhere than programmed: another revision or another panel";
    case FaultCause::SofterPanel:
      return softer_words(story.told, series.model);
    default:
      return story.kind == StoryKind::Noise
                 ? "the measurements scatter more than their stated sigma"
                 : "nothing is wrong with any one target";
  }
}

}  // namespace internal

std::string_view name(FaultCause cause) {
  switch (cause) {
    case FaultCause::WrongPad:
      return "wrong pad";
    case FaultCause::DamagedMark:
      return "damaged mark";
    case FaultCause::TurnedQuarter:
      return "turned by 90 degrees";
    case FaultCause::TurnedHalf:
      return "turned by 180 degrees";
    case FaultCause::Mirrored:
      return "mirrored";
    case FaultCause::WrongScale:
      return "wrong scale";
    case FaultCause::WrongRevision:
      return "wrong revision";
    case FaultCause::OutOfFocus:
      return "out of focus";
    case FaultCause::SofterPanel:
      return "softer than the model";
    case FaultCause::Unexplained:
      break;
  }
  return "unexplained";
}

std::string SeriesFault::text() const {
  if (suspicions.empty()) return "the targets do not fit each other";
  const std::string_view unweighed =
      weighs_taken_pads
          ? ""
          : "; whether other pads were taken for the targets cannot be told: noise or "
            "limits allow too many";
  if (is_named() || suspicions.size() == 1) return suspicions[0].text + std::string(unweighed);
  std::string out =
      i_outlier ? "of one cause or another: " : "the data do not single out one cause: ";
  for (std::size_t i = 0; i < suspicions.size(); ++i) {
    out += fmt::format(
        "{}{} ({:.2g})", i == 0 ? "" : "; or ", suspicions[i].text, suspicions[i].probability);
  }
  return out + std::string(unweighed);
}

}  // namespace panelcal
