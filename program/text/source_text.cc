// SPDX-License-Identifier: Apache-2.0
#include "program/text/source_text.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"

namespace panelcal {

namespace {

SourceText without_mark(const std::filesystem::path& path, std::string bytes) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  if (bytes.starts_with(kUtf8Mark)) bytes.erase(0, kUtf8Mark.size());
  return {path.string(), std::move(bytes)};
}

/// The first LF or CR from `at` on, eight characters at a time; `end` if there is none.
const char* find_line_end(const char* at, const char* end) {
  constexpr std::uint64_t kOnes = 0x0101010101010101;
  constexpr std::uint64_t kTops = 0x8080808080808080;
  const auto has_zero_byte = [](std::uint64_t v) { return ((v - kOnes) & ~v & kTops) != 0; };
  while (end - at >= 8) {
    std::uint64_t characters;
    std::memcpy(&characters, at, sizeof characters);
    if (has_zero_byte(characters ^ (kOnes * '\n')) || has_zero_byte(characters ^ (kOnes * '\r'))) {
      break;
    }
    at += 8;
  }
  while (at != end && *at != '\n' && *at != '\r') ++at;
  return at;
}

}  // namespace

Expected<SourceText> read_source(const std::filesystem::path& path) {
  PANELCAL_TRY(std::string bytes, read_file(path));
  return without_mark(path, std::move(bytes));
}

Expected<SourceText> read_source_with_digest(const std::filesystem::path& path) {
  PANELCAL_TRY(std::string bytes, read_file(path));
  std::string digest = sha256(bytes);
  SourceText source = without_mark(path, std::move(bytes));
  source.sha256 = std::move(digest);
  return source;
}

std::size_t count_line_feeds(std::string_view text) {
  constexpr std::uint64_t kOnes = 0x0101010101010101;
  constexpr std::uint64_t kLow = 0x7F7F7F7F7F7F7F7F;
  const char* at = text.data();
  const char* const end = at + text.size();
  std::size_t n = 0;
  for (; end - at >= 8; at += 8) {
    std::uint64_t characters;
    std::memcpy(&characters, at, sizeof characters);
    characters ^= kOnes * '\n';
    // The top bit of every byte that is not zero, that is of all but line feeds.
    const std::uint64_t others = ((characters & kLow) + kLow) | characters;
    n += ((~others >> 7) & kOnes) * kOnes >> 56;
  }
  return n + static_cast<std::size_t>(std::count(at, end, '\n'));
}

SourceLine last_line(std::string_view text) {
  SourceLine last{text, 1, 1};
  for (LineCursor cursor(text); !cursor.at_end();) last = cursor.next();
  return last;
}

SourceLine LineCursor::next() {
  const char* const begin = bytes_.data() + offset_;
  const char* const end = bytes_.data() + bytes_.size();
  const char* stop = find_line_end(begin, end);
  const SourceLine line{{begin, static_cast<std::size_t>(stop - begin)}, number_++, 1};
  if (stop != end) stop += line_end_length(stop, end);
  offset_ = static_cast<std::size_t>(stop - bytes_.data());
  return line;
}

}  // namespace panelcal
