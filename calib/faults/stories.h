// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/faults/known_pads.h"
#include "calib/faults/panel_evidence.h"
#include "calib/faults/series_fault.h"

namespace panelcal::internal {

/// Pose of the panel in a story, or another property that tells two stories of one cause apart.
enum class StoryKind : std::uint8_t {
  Plain,
  QuarterLeft,   ///< 90 degrees counter-clockwise
  QuarterRight,  ///< 90 degrees clockwise
  MirroredX,     ///< left and right exchanged
  MirroredY,
  MirroredDiagonal,      ///< x and y exchanged
  MirroredAntidiagonal,  ///< x and y exchanged and both negated
  Chance,                ///< nothing is wrong
  Noise,                 ///< more of it than stated
  Far,                   ///< a map that fits, outside the limits
  Moved,                 ///< several targets elsewhere
};

/// One explanation of a series, with its prior times its evidence.
struct FaultStory {
  FaultCause cause = FaultCause::Unexplained;
  StoryKind kind = StoryKind::Plain;
  std::optional<std::size_t> i_point = std::nullopt;
  std::optional<KnownPad> pad = std::nullopt;
  double factor = 1;  ///< of WrongScale: actual over programmed
  double log_weight = 0;
  double off_mm = 0;      ///< of the one target, from where the others put it
  double pad_off_mm = 0;  ///< and from where they put the pad
  Evidence told = {};
};

/// The facts about a target beyond its place.
struct PictureFacts {
  std::optional<double> score;
  double sigma_mm = 0;  ///< of the picture alone
};

struct Series {
  std::span<const ToldTarget> targets;
  std::span<const PictureFacts> facts;
  PanelModel model = PanelModel::Offset;
  GateLimits limits;
  PanelBelief belief;               ///< from the limits
  const KnownPads* pads = nullptr;  ///< null: unknown
};

/// The middle of the panel, about which it may be turned: of all pads, else of the targets.
Eigen::Vector2d middle_mm(const Series& series);

/// True if a target's picture is much worse than the others'.
bool has_bad_picture(std::span<const PictureFacts> facts, std::size_t i);
/// Of what the target shows, the mean over both axes.
double sigma_mm_of(const ToldTarget& target);

/// One target off: at another pad, damaged, out of focus.
void tell_of_liars(const Series& series, std::vector<FaultStory>& stories);
/// The panel turned, mirrored, or of another scale, its targets seen themselves.
void tell_of_lies(const Series& series, std::vector<FaultStory>& stories);
/// The same, where the camera took what lay where it looked.
///
/// Out    false: too many ways to weigh, and none is told of
bool tell_of_taken_pads(const Series& series, std::vector<FaultStory>& stories);
/// Everything else: chance, noise, a softer panel, another revision.
void tell_of_the_rest(const Series& series, std::vector<FaultStory>& stories);

/// The ways in which a panel can lie that are not just a little off.
struct NamedLie {
  FaultCause cause;
  StoryKind kind;
  double factor;
  Eigen::Matrix2d turn;
  /// The middle stays; otherwise work zero does.
  bool is_about_center;
};
std::span<const NamedLie> named_lies();

}  // namespace panelcal::internal
