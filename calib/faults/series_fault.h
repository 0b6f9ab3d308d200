// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace panelcal {

enum class FaultCause : std::uint8_t {
  WrongPad,       ///< one target is another pad or hole of the program
  DamagedMark,    ///< one target is off, and nothing is where it was seen
  TurnedQuarter,  ///< the panel lies turned by 90 or 270 degrees
  TurnedHalf,
  Mirrored,       ///< the other side is up
  WrongScale,     ///< unit or zero suppression: factor 25.4 or a power of ten
  WrongRevision,  ///< the targets fit each other, but not the program; or several are elsewhere
  OutOfFocus,     ///< one target is off, and its picture is worse than the others'
  SofterPanel,    ///< the panel is bent in a way that the model does not know
  Unexplained,    ///< noise larger than stated, or chance
};

/// "wrong pad", "damaged mark" and so on.
std::string_view name(FaultCause cause);

/// The possible causes of a series of targets that do not fit.
struct SeriesFault {
  struct Suspicion {
    FaultCause cause = FaultCause::Unexplained;
    std::optional<std::size_t> i_point;  ///< the target that lies, if one does
    double probability = 0;              ///< among the causes that were considered
    std::string text;                    ///< in words, with numbers
  };
  double p_value = 1;                 ///< that healthy targets fit as badly as these
  double false_alarm = 0;             ///< the p-value below which targets are accused; 0: never
  int degrees_of_freedom = 0;         ///< redundant equations there were
  std::vector<Suspicion> suspicions;  ///< the likeliest first; several if data cannot tell
  /// The one target that lies, whatever the reason, with a probability above kNamed.
  std::optional<std::size_t> i_outlier;
  /// True if it was also weighed that the panel lies turned or mirrored, so that pads were taken
  /// for the targets. False: limits or noise allow too many ways.
  bool weighs_taken_pads = true;
  /// The outlier was left out, and the others fit each other and the limits.
  bool is_resolved = false;

  static constexpr double kNamed = 0.99;

  /// The likeliest cause is beyond doubt.
  bool is_named() const {
    return weighs_taken_pads && !suspicions.empty() && suspicions[0].probability > kNamed;
  }
  /// One sentence: what it is, or what it may be and that the data cannot tell.
  std::string text() const;
};

}  // namespace panelcal
