// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/plain_text.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>

#include "calib/base/diagnostic.h"

namespace panelcal::sieb_meyer {
namespace {

constexpr std::string_view kKnownVariables =
    "one of &D &T &F &E &M &P &S &B &N &R &V, or an & with no letter behind it";

bool is_small_letter(char c) {
  return c >= 'a' && c <= 'z';
}

char capital(char c) {
  return is_small_letter(c) ? static_cast<char>(c - 'a' + 'A') : c;
}

bool is_letter(char c) {
  return capital(c) >= 'A' && capital(c) <= 'Z';
}

std::string repertoire(CharacterSet set) {
  std::string out = "A to Z, 0 to 9, the space";
  for (const char c : signs(set)) out += std::string(" ") + c;
  return out;
}

class Expansion {
 public:
  Expansion(std::string_view text, const TextVariables& variables, int step, CharacterSet set)
      : text_(text), variables_(variables), step_(step), set_(set) {}

  tl::expected<std::vector<TextCell>, TextFault> run() && {
    while (at_ < text_.size()) {
      const std::size_t length = length_of_word();
      if (auto problem = append_word(text_.substr(at_, length))) {
        return tl::unexpected(*std::move(problem));
      }
      at_ += length;
    }
    return std::move(cells_);
  }

 private:
  std::size_t length_of_word() const {
    const bool is_variable =
        text_[at_] == '&' && at_ + 1 < text_.size() && is_letter(text_[at_ + 1]);
    return is_variable ? 2 : 1;
  }

  std::optional<TextFault> append_word(std::string_view word) {
    if (word == "*") return append_value(word, variables_.operator_text);
    if (word == "&P") return append_spindle_row();
    if (word == "&V") return append_run_row();
    if (word.size() == 2) {
      const std::optional<std::string> value = value_of(word[1]);
      if (value) return append_value(word, *value);
      return fault("there is no text variable " + quoted(word), std::string(kKnownVariables));
    }
    if (is_small_letter(word[0])) {
      return fault("a small letter " + quoted(word) + " in a text", "capital letters only");
    }
    return append_value(word, word);
  }

  std::optional<std::string> value_of(char variable) const {
    switch (variable) {
      case 'D':
        return variables_.date;
      case 'T':
        return variables_.time;
      case 'F':
        return variables_.file;
      case 'E':
        return variables_.extension;
      case 'M':
        return variables_.module;
      case 'S':
        return std::to_string(variables_.spindle);
      case 'B':
        return std::to_string(variables_.breakage_counter);
      case 'N':
        return std::to_string(variables_.run);
      case 'R':
        return std::to_string(step_);
      default:
        return std::nullopt;
    }
  }

  std::optional<TextFault> append_value(std::string_view word, std::string_view value) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      const char c = capital(value[i]);
      if (!glyph(set_, c)) {
        std::string what = quoted(value.substr(i, 1));
        if (word != value) what += " of " + quoted(word) + ", which is " + quoted(value) + ",";
        what += " is not in the character set " + std::string(name(set_));
        return fault(std::move(what), repertoire(set_));
      }
      cells_.emplace_back(c);
    }
    return std::nullopt;
  }

  std::optional<TextFault> append_spindle_row() {
    if (variables_.spindle < 1 || variables_.spindle > kMaxSpindle) {
      return fault("\"&P\" with spindle " + std::to_string(variables_.spindle),
                   "a spindle from 1 to " + std::to_string(kMaxSpindle));
    }
    for (int left = variables_.spindle; left > 0; left -= columns(set_)) {
      const int n_holes = std::min(left, columns(set_));
      cells_.emplace_back(HoleRow{static_cast<std::uint8_t>((1U << n_holes) - 1)});
    }
    return std::nullopt;
  }

  std::optional<TextFault> append_run_row() {
    if (variables_.run < 0) {
      return fault("\"&V\" with run " + std::to_string(variables_.run), "a run of 0 or more");
    }
    const auto run = static_cast<unsigned>(variables_.run);
    const int n_columns = columns(set_);
    const int n_bits = std::max(1, static_cast<int>(std::bit_width(run)));
    for (int n_cells = (n_bits + n_columns - 1) / n_columns; n_cells > 0; --n_cells) {
      HoleRow row;
      for (int column = 0; column < n_columns; ++column) {
        const int bit = n_cells * n_columns - 1 - column;
        // Bits beyond those of an unsigned are 0; shifting by that many is undefined.
        const unsigned is_hole = bit < n_bits ? run >> bit & 1U : 0U;
        row.columns = static_cast<std::uint8_t>(row.columns | is_hole << column);
      }
      cells_.emplace_back(row);
    }
    return std::nullopt;
  }

  TextFault fault(std::string what, std::string expected) const {
    return {at_, std::move(what), std::move(expected)};
  }

  std::string_view text_;
  const TextVariables& variables_;
  int step_;
  CharacterSet set_;
  std::size_t at_ = 0;
  std::vector<TextCell> cells_;
};

Glyph holes_of(const TextCell& cell, CharacterSet set) {
  if (const char* const c = std::get_if<char>(&cell)) return glyph(set, *c).value_or(Glyph());
  Glyph out;
  for (int column = 0; column < columns(set); ++column) {
    if ((std::get<HoleRow>(cell).columns >> column & 1) != 0) {
      out.add({static_cast<std::int8_t>(column), 0});
    }
  }
  return out;
}

}  // namespace

tl::expected<std::vector<TextCell>, TextFault> expand_text(std::string_view text,
                                                           const TextVariables& variables,
                                                           int step_number,
                                                           CharacterSet set) {
  return Expansion(text, variables, step_number, set).run();
}

TextLayout::TextLayout(std::vector<TextCell> cells, CharacterSet set)
    : cells_(std::move(cells)), set_(set) {
  n_holes_to_.reserve(cells_.size());
  std::int64_t n = 0;
  for (const TextCell& cell : cells_) {
    n += static_cast<std::int64_t>(holes_of(cell, set_).holes().size());
    n_holes_to_.push_back(n);
  }
}

Eigen::Vector2d TextLayout::operator[](std::int64_t i) const {
  // The first cell that ends behind hole i: cells without holes end where they begin.
  const auto cell =
      static_cast<std::size_t>(std::ranges::upper_bound(n_holes_to_, i) - n_holes_to_.begin());
  const std::int64_t first = cell == 0 ? 0 : n_holes_to_[cell - 1];
  const Glyph holes = holes_of(cells_[cell], set_);
  const GlyphHole hole = holes.holes()[static_cast<std::size_t>(i - first)];
  const auto column = static_cast<double>(cell) * advance_columns(set_);
  return {column + hole.column, hole.row};
}

}  // namespace panelcal::sieb_meyer
