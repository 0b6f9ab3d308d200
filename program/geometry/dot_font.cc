// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/dot_font.h"

#include <algorithm>
#include <string_view>

namespace panelcal {
namespace {

struct Picture {
  char c;
  std::string_view rows;  // from the top, with a blank between two
};

constexpr std::array k3x5 = {
    Picture{'A', ".#. #.# ### #.# #.#"}, Picture{'B', "##. #.# ##. #.# ##."},
    Picture{'C', ".## #.. #.. #.. .##"}, Picture{'D', "##. #.# #.# #.# ##."},
    Picture{'E', "### #.. ##. #.. ###"}, Picture{'F', "### #.. ##. #.. #.."},
    Picture{'G', ".## #.. #.# #.# .##"}, Picture{'H', "#.# #.# ### #.# #.#"},
    Picture{'I', "### .#. .#. .#. ###"}, Picture{'J', "..# ..# ..# #.# .#."},
    Picture{'K', "#.# ##. #.. ##. #.#"}, Picture{'L', "#.. #.. #.. #.. ###"},
    Picture{'M', "#.# ### #.# #.# #.#"}, Picture{'N', "##. #.# #.# #.# #.#"},
    Picture{'O', ".#. #.# #.# #.# .#."}, Picture{'P', "##. #.# ##. #.. #.."},
    Picture{'Q', ".#. #.# #.# ##. .##"}, Picture{'R', "##. #.# ##. #.# #.#"},
    Picture{'S', ".## #.. .#. ..# ##."}, Picture{'T', "### .#. .#. .#. .#."},
    Picture{'U', "#.# #.# #.# #.# .##"}, Picture{'V', "#.# #.# #.# .#. .#."},
    Picture{'W', "#.# #.# #.# ### #.#"}, Picture{'X', "#.# #.# .#. #.# #.#"},
    Picture{'Y', "#.# #.# .#. .#. .#."}, Picture{'Z', "### ..# .#. #.. ###"},
    Picture{'0', "### #.# #.# #.# ###"}, Picture{'1', ".#. ##. .#. .#. ###"},
    Picture{'2', ".#. #.# ..# .#. ###"}, Picture{'3', "##. ..# .#. ..# ##."},
    Picture{'4', "#.# #.# ### ..# ..#"}, Picture{'5', "### #.. ##. ..# ##."},
    Picture{'6', ".## #.. ##. #.# .#."}, Picture{'7', "### ..# ..# .#. .#."},
    Picture{'8', ".#. #.# .#. #.# .#."}, Picture{'9', ".#. #.# .## ..# ##."},
};

constexpr std::array k4x6 = {
    Picture{'A', ".##. #..# #..# #### #..# #..#"}, Picture{'B', "###. #..# ###. #..# #..# ###."},
    Picture{'C', ".##. #..# #... #... #..# .##."}, Picture{'D', "##.. #.#. #..# #..# #.#. ##.."},
    Picture{'E', "#### #... ###. #... #... ####"}, Picture{'F', "#### #... ###. #... #... #..."},
    Picture{'G', ".### #... #... #.## #..# .###"}, Picture{'H', "#..# #..# #### #..# #..# #..#"},
    Picture{'I', "###. .#.. .#.. .#.. .#.. ###."}, Picture{'J', "...# ...# ...# ...# #..# .##."},
    Picture{'K', "#..# #.#. ##.. ##.. #.#. #..#"}, Picture{'L', "#... #... #... #... #... ####"},
    Picture{'M', "#..# #### #### #..# #..# #..#"}, Picture{'N', "#..# ##.# ##.# #.## #.## #..#"},
    Picture{'O', ".##. #..# #..# #..# #..# .##."}, Picture{'P', "###. #..# #..# ###. #... #..."},
    Picture{'Q', ".##. #..# #..# #..# #.#. .#.#"}, Picture{'R', "###. #..# #..# ###. #.#. #..#"},
    Picture{'S', ".### #... .##. ...# ...# ###."}, Picture{'T', "###. .#.. .#.. .#.. .#.. .#.."},
    Picture{'U', "#..# #..# #..# #..# #..# .##."}, Picture{'V', "#.#. #.#. #.#. #.#. #.#. .#.."},
    Picture{'W', "#..# #..# #..# #### #### #..#"}, Picture{'X', "#..# #..# .##. .##. #..# #..#"},
    Picture{'Y', "#.#. #.#. #.#. .#.. .#.. .#.."}, Picture{'Z', "#### ...# ..#. .#.. #... ####"},
    Picture{'0', ".##. #.## #.## ##.# ##.# .##."}, Picture{'1', ".#.. ##.. .#.. .#.. .#.. ###."},
    Picture{'2', ".##. #..# ...# ..#. .#.. ####"}, Picture{'3', "#### ...# .##. ...# #..# .##."},
    Picture{'4', "..#. .##. #.#. #### ..#. ..#."}, Picture{'5', "#### #... ###. ...# #..# .##."},
    Picture{'6', "..#. .#.. #... ###. #..# .##."}, Picture{'7', "#### ...# ..#. ..#. .#.. .#.."},
    Picture{'8', ".##. #..# .##. #..# #..# .##."}, Picture{'9', ".##. #..# .### ...# ..#. .#.."},
    Picture{'+', ".... .#.. ###. .#.. .... ...."}, Picture{'-', ".... .... ###. .... .... ...."},
    Picture{'/', "...# ...# ..#. .#.. #... #..."}, Picture{'.', ".... .... .... .... ##.. ##.."},
    Picture{',', ".... .... .... ##.. .#.. #..."}, Picture{'!', ".#.. .#.. .#.. .#.. .... .#.."},
    Picture{'?', ".##. #..# ..#. .#.. .... .#.."}, Picture{':', ".... ##.. ##.. .... ##.. ##.."},
    Picture{'(', "..#. .#.. .#.. .#.. .#.. ..#."}, Picture{')', ".#.. ..#. ..#. ..#. ..#. .#.."},
    Picture{'"', "#.#. #.#. .... .... .... ...."},
};

constexpr std::array k5x7 = {
    Picture{'A', ".###. #...# #...# ##### #...# #...# #...#"},
    Picture{'B', "####. #...# #...# ####. #...# #...# ####."},
    Picture{'C', ".###. #...# #.... #.... #.... #...# .###."},
    Picture{'D', "###.. #..#. #...# #...# #...# #..#. ###.."},
    Picture{'E', "##### #.... #.... ####. #.... #.... #####"},
    Picture{'F', "##### #.... #.... ####. #.... #.... #...."},
    Picture{'G', ".###. #...# #.... #.### #...# #...# .###."},
    Picture{'H', "#...# #...# #...# ##### #...# #...# #...#"},
    Picture{'I', ".###. ..#.. ..#.. ..#.. ..#.. ..#.. .###."},
    Picture{'J', "..### ...#. ...#. ...#. ...#. #..#. .##.."},
    Picture{'K', "#...# #..#. #.#.. ##... #.#.. #..#. #...#"},
    Picture{'L', "#.... #.... #.... #.... #.... #.... #####"},
    Picture{'M', "#...# ##.## #.#.# #.#.# #...# #...# #...#"},
    Picture{'N', "#...# #...# ##..# #.#.# #..## #...# #...#"},
    Picture{'O', ".###. #...# #...# #...# #...# #...# .###."},
    Picture{'P', "####. #...# #...# ####. #.... #.... #...."},
    Picture{'Q', ".###. #...# #...# #...# #.#.# #..#. .##.#"},
    Picture{'R', "####. #...# #...# ####. #.#.. #..#. #...#"},
    Picture{'S', ".#### #.... #.... .###. ....# ....# ####."},
    Picture{'T', "##### ..#.. ..#.. ..#.. ..#.. ..#.. ..#.."},
    Picture{'U', "#...# #...# #...# #...# #...# #...# .###."},
    Picture{'V', "#...# #...# #...# #...# #...# .#.#. ..#.."},
    Picture{'W', "#...# #...# #...# #.#.# #.#.# ##.## #...#"},
    Picture{'X', "#...# #...# .#.#. ..#.. .#.#. #...# #...#"},
    Picture{'Y', "#...# #...# .#.#. ..#.. ..#.. ..#.. ..#.."},
    Picture{'Z', "##### ....# ...#. ..#.. .#... #.... #####"},
    Picture{'0', ".###. #...# #..## #.#.# ##..# #...# .###."},
    Picture{'1', "..#.. .##.. ..#.. ..#.. ..#.. ..#.. .###."},
    Picture{'2', ".###. #...# ....# ...#. ..#.. .#... #####"},
    Picture{'3', "##### ...#. ..#.. ...#. ....# #...# .###."},
    Picture{'4', "...#. ..##. .#.#. #..#. ##### ...#. ...#."},
    Picture{'5', "##### #.... ####. ....# ....# #...# .###."},
    Picture{'6', "..##. .#... #.... ####. #...# #...# .###."},
    Picture{'7', "##### ....# ...#. ..#.. .#... .#... .#..."},
    Picture{'8', ".###. #...# #...# .###. #...# #...# .###."},
    Picture{'9', ".###. #...# #...# .#### ....# ...#. .##.."},
    Picture{'+', "..... ..#.. ..#.. ##### ..#.. ..#.. ....."},
    Picture{'-', "..... ..... ..... ##### ..... ..... ....."},
    Picture{'/', "....# ....# ...#. ..#.. .#... #.... #...."},
    Picture{'.', "..... ..... ..... ..... ..... .##.. .##.."},
    Picture{',', "..... ..... ..... ..... .##.. ..#.. .#..."},
    Picture{'!', "..#.. ..#.. ..#.. ..#.. ..#.. ..... ..#.."},
    Picture{'?', ".###. #...# ....# ...#. ..#.. ..... ..#.."},
    Picture{':', "..... .##.. .##.. ..... .##.. .##.. ....."},
    Picture{'(', "...#. ..#.. .#... .#... .#... ..#.. ...#."},
    Picture{')', ".#... ..#.. ...#. ...#. ...#. ..#.. .#..."},
    Picture{'"', ".#.#. .#.#. .#.#. ..... ..... ..... ....."},
    Picture{'#', ".#.#. .#.#. ##### .#.#. ##### .#.#. .#.#."},
    Picture{'$', "..#.. .#### #.#.. .###. ..#.# ####. ..#.."},
    Picture{'%', "##... ##..# ...#. ..#.. .#... #..## ...##"},
    Picture{'&', ".##.. #..#. #.#.. .#... #.#.# #..#. .##.#"},
    Picture{'\'', "..#.. ..#.. .#... ..... ..... ..... ....."},
    Picture{'*', "..... ..#.. #.#.# .###. #.#.# ..#.. ....."},
    Picture{';', "..... .##.. .##.. ..... .##.. ..#.. .#..."},
    Picture{'<', "....# ...#. ..#.. .#... ..#.. ...#. ....#"},
    Picture{'=', "..... ..... ##### ..... ##### ..... ....."},
    Picture{'>', "#.... .#... ..#.. ...#. ..#.. .#... #...."},
    Picture{'@', ".###. #...# #.### #.#.# #.### #.... .####"},
    Picture{'[', ".###. .#... .#... .#... .#... .#... .###."},
    Picture{'\\', "#.... #.... .#... ..#.. ...#. ....# ....#"},
    Picture{']', ".###. ...#. ...#. ...#. ...#. ...#. .###."},
    Picture{'^', "..#.. .#.#. #...# ..... ..... ..... ....."},
    Picture{'_', "..... ..... ..... ..... ..... ..... #####"},
};

constexpr std::array k4x7 = {
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
};

struct Font {
  CharacterSet set;
  std::string_view name;
  std::size_t columns;
  std::size_t rows;
  std::string_view signs;
  std::span<const Picture> pictures;  // of all its characters at least
};

// The last row of the manual's table, which only 5x7 has, is printed as "I_" for M97 and as "_" for
// M98. The upright stroke is no bar: without it the set is just that of six-bit ASCII.
constexpr std::array kFonts = {
    Font{CharacterSet::Dots3x5, "3x5", 3, 5, "", k3x5},
    Font{CharacterSet::Dots4x6, "4x6", 4, 6, "+-/.,!?:()\"", k4x6},
    Font{CharacterSet::Dots5x7, "5x7", 5, 7, "+-/.,!?:()\"#$%&'*;<=>@[\\]^_", k5x7},
    Font{CharacterSet::Excellon4x7, "excellon", 4, 7, "+-/", k4x7},
    Font{CharacterSet::Hitachi, "hitachi", 5, 7, "-", k5x7},
};

constexpr const Font& font(CharacterSet set) {
  return kFonts[static_cast<std::size_t>(set)];
}

constexpr bool has(const Font& font, char c) {
  return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         font.signs.find(c) != std::string_view::npos;
}

constexpr const Picture* picture_of(const Font& font, char c) {
  const auto found = std::ranges::find(font.pictures, c, &Picture::c);
  return has(font, c) && found != font.pictures.end() ? &*found : nullptr;
}

constexpr bool fits(const Picture& picture, const Font& font) {
  const std::size_t line = font.columns + 1;
  if (picture.rows.size() != line * font.rows - 1) return false;
  for (std::size_t i = 0; i < picture.rows.size(); ++i) {
    const char c = picture.rows[i];
    if (i % line == font.columns ? c != ' ' : c != '#' && c != '.') return false;
  }
  return font.columns * font.rows <= Glyph::kMaxHoles;
}

// A picture with a row too long would shear the rest of the character.
static_assert(std::ranges::all_of(kFonts, [](const Font& font) {
  return std::ranges::all_of(font.pictures, [&](const Picture& p) { return fits(p, font); });
}));
static_assert(std::ranges::all_of(kFonts, [](const Font& f) { return &f == &font(f.set); }));

}  // namespace

std::string_view name(CharacterSet set) {
  return font(set).name;
}

std::optional<CharacterSet> character_set_from_name(std::string_view name) {
  const auto* const found = std::ranges::find(kFonts, name, &Font::name);
  if (found == kFonts.end()) return std::nullopt;
  return found->set;
}

int columns(CharacterSet set) {
  return static_cast<int>(font(set).columns);
}

int rows(CharacterSet set) {
  return static_cast<int>(font(set).rows);
}

std::string_view signs(CharacterSet set) {
  return font(set).signs;
}

std::optional<Glyph> glyph(CharacterSet set, char c) {
  if (c == ' ') return Glyph();
  const Font& in = font(set);
  const Picture* const picture = picture_of(in, c);
  if (!picture) return std::nullopt;
  Glyph out;
  for (std::size_t column = 0; column < in.columns; ++column) {
    for (std::size_t i = 0; i < in.rows; ++i) {
      const std::size_t row = column % 2 == 0 ? i : in.rows - 1 - i;
      const std::size_t line = in.rows - 1 - row;
      if (picture->rows[line * (in.columns + 1) + column] == '#') {
        out.add({static_cast<std::int8_t>(column), static_cast<std::int8_t>(row)});
      }
    }
  }
  return out;
}

}  // namespace panelcal
