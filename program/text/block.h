// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "program/text/mark.h"
#include "program/text/word.h"

namespace panelcal {

/// One program line as words, left to right, whatever its language.
template <std::size_t kMost>
struct WordBlock {
  static constexpr std::size_t kMaxWords = kMost;

  int line = 0;
  std::string_view text;  ///< the line without blanks at either end
  int column = 1;         ///< of the first character of text
  std::array<Word, kMost> words;
  std::size_t n_words = 0;
  std::string_view argument;  ///< the text behind a comma
  int argument_column = 0;    ///< 0: there is none

  std::span<const Word> all() const { return {words.data(), n_words}; }
  const Word* find(char letter) const {
    const auto found = std::ranges::find(all(), letter, &Word::letter);
    return found == all().end() ? nullptr : &*found;
  }

  // What diagnostics name: the block, a word, `"X1" in "X1Y2"` (of the first word: first()), what
  // stands behind the comma, or words of one's own that stand for the block.
  operator Mark() const { return with(quoted(text)); }  // NOLINT(google-explicit-constructor)
  Mark of(const Word& word) const { return {line, word.column, quoted(word.text())}; }
  Mark in(const Word& word) const {
    return {line, word.column, quoted(word.text()) + " in " + quoted(text)};
  }
  Mark first() const { return in(words[0]); }
  Mark of_argument() const { return {line, argument_column, quoted(argument)}; }
  Mark with(std::string what) const { return {line, column, std::move(what)}; }
};

}  // namespace panelcal
