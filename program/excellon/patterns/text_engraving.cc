// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/text_engraving.h"

#include "program/geometry/dot_font.h"

namespace panelcal::excellon {
namespace {

constexpr Length kDefaultTextPitch = inch(0.0417);

}  // namespace

double text_pitch_mm(std::optional<Length> tool_diameter) {
  const bool is_known = tool_diameter && tool_diameter->in_mm() > 0;
  return (is_known ? kPitchDiameters * *tool_diameter : kDefaultTextPitch).in_mm();
}

tl::expected<std::string, std::size_t> prepare_text(std::string_view text, std::string_view opid) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char c : text[i] == '*' ? opid : text.substr(i, 1)) {
      const char drilled = c == ',' ? ' ' : c;
      if (!glyph(CharacterSet::Excellon4x7, drilled)) return tl::unexpected<std::size_t>(i);
      out += drilled;
    }
  }
  return out;
}

}  // namespace panelcal::excellon
