// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/text_engraving.h"

#include <algorithm>

namespace panelcal::excellon {
namespace {

constexpr double kPitchDiameters = 1.2;
constexpr Length kDefaultPitch = inch(0.0417);

struct Picture {
  char c;
  std::string_view rows;  // from the top, with a blank between two
};

constexpr std::array kFont = {
    Picture{'A', ".##. #..# #..# #### #..# #..# #..#"},
    Picture{'B', "###. #..# #..# ###. #..# #..# ###."},
    Picture{'C', ".##. #..# #... #... #... #..# .##."},
    Picture{'D', "##.. #.#. #..# #..# #..# #.#. ##.."},
    Picture{'E', "#### #... #... ###. #... #... ####"},
    Picture{'F', "#### #... #... ###. #... #... #..."},
    Picture{'G', ".### #... #... #.## #..# #..# .###"},
    Picture{'H', "#..# #..# #..# #### #..# #..# #..#"},
    Picture{'I', "###. .#.. .#.. .#.. .#.. .#.. ###."},
    Picture{'J', "...# ...# ...# ...# ...# #..# .##."},
    Picture{'K', "#..# #..# #.#. ##.. #.#. #..# #..#"},
    Picture{'L', "#... #... #... #... #... #... ####"},
    Picture{'M', "#..# #### #### #..# #..# #..# #..#"},
    Picture{'N', "#..# ##.# ##.# #.## #.## #..# #..#"},
    Picture{'O', ".##. #..# #..# #..# #..# #..# .##."},
    Picture{'P', "###. #..# #..# ###. #... #... #..."},
    Picture{'Q', ".##. #..# #..# #..# #..# #.#. .#.#"},
    Picture{'R', "###. #..# #..# ###. #.#. #..# #..#"},
    Picture{'S', ".### #... #... .##. ...# ...# ###."},
    Picture{'T', "###. .#.. .#.. .#.. .#.. .#.. .#.."},
    Picture{'U', "#..# #..# #..# #..# #..# #..# .##."},
    Picture{'V', "#.#. #.#. #.#. #.#. #.#. #.#. .#.."},
    Picture{'W', "#..# #..# #..# #..# #### #### #..#"},
    Picture{'X', "#..# #..# .##. .##. .##. #..# #..#"},
    Picture{'Y', "#.#. #.#. #.#. .#.. .#.. .#.. .#.."},
    Picture{'Z', "#### ...# ...# ..#. .#.. #... ####"},
    Picture{'0', ".##. #..# #.## #### ##.# #..# .##."},
    Picture{'1', "..#. .##. #.#. ..#. ..#. ..#. ..#."},
    Picture{'2', ".##. #..# ...# ..#. .#.. #... ####"},
    Picture{'3', "#### ...# ..#. .##. ...# #..# .##."},
    Picture{'4', "...# ..## .#.# #..# #### ...# ...#"},
    Picture{'5', "#### #... ###. ...# ...# #..# .##."},
    Picture{'6', "..#. .#.. #... ###. #..# #..# .##."},
    Picture{'7', "#### ...# ...# ..#. ..#. .#.. .#.."},
    Picture{'8', ".##. #..# #..# .##. #..# #..# .##."},
    Picture{'9', ".##. #..# #..# .### ...# ..#. .#.."},
    Picture{'+', ".... .... .#.. ###. .#.. .... ...."},
    Picture{'-', ".... .... .... ###. .... .... ...."},
    Picture{'/', "...# ...# ..#. ..#. .#.. .#.. #..."},
    Picture{' ', ".... .... .... .... .... .... ...."},
};

const Picture* picture_of(char c) {
  const auto* const found = std::ranges::find(kFont, c, &Picture::c);
  return found == kFont.end() ? nullptr : &*found;
}

}  // namespace

std::optional<Glyph> glyph(char c) {
  const Picture* const picture = picture_of(c);
  if (!picture) return std::nullopt;
  Glyph out;
  for (std::size_t column = 0; column < kGlyphColumns; ++column) {
    for (std::size_t i = 0; i < kGlyphRows; ++i) {
      const std::size_t row = column % 2 == 0 ? i : kGlyphRows - 1 - i;
      const std::size_t line = kGlyphRows - 1 - row;
      if (picture->rows[line * (kGlyphColumns + 1) + column] == '#') {
        out.add({static_cast<std::int8_t>(column), static_cast<std::int8_t>(row)});
      }
    }
  }
  return out;
}

double text_pitch_mm(std::optional<Length> tool_diameter) {
  const bool is_known = tool_diameter && tool_diameter->in_mm() > 0;
  return (is_known ? kPitchDiameters * *tool_diameter : kDefaultPitch).in_mm();
}

tl::expected<std::string, std::size_t> prepare_text(std::string_view text, std::string_view opid) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char c : text[i] == '*' ? opid : text.substr(i, 1)) {
      const char drilled = c == ',' ? ' ' : c;
      if (!picture_of(drilled)) return tl::unexpected<std::size_t>(i);
      out += drilled;
    }
  }
  return out;
}

}  // namespace panelcal::excellon
