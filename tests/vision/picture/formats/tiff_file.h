// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace panelcal::test {

/// One entry of a TIFF directory: SHORT (3) or LONG (4), one value.
struct TiffEntry {
  std::uint32_t tag = 0;
  std::uint32_t type = 3;
  std::uint32_t value = 0;
};

/// A TIFF file of one strip or tile, written by hand so that any entry can be said.
class TiffFile {
 public:
  explicit TiffFile(std::string pixels) : pixels_(std::move(pixels)) {}

  /// Sorted by tag, as the specification asks for; the last word on a tag counts.
  TiffFile& with(TiffEntry entry) {
    const auto at = std::lower_bound(
        entries_.begin(), entries_.end(), entry.tag, [](const TiffEntry& a, std::uint32_t tag) {
          return a.tag < tag;
        });
    if (at != entries_.end() && at->tag == entry.tag) {
      *at = entry;
    } else {
      entries_.insert(at, entry);
    }
    return *this;
  }

  std::string bytes() const {
    std::string out("II*\0", 4);
    put(out, 8, 4);
    put(out, static_cast<std::uint32_t>(entries_.size()), 2);
    for (const TiffEntry& entry : entries_) {
      put(out, entry.tag, 2);
      put(out, entry.type, 2);
      put(out, 1, 4);
      const bool is_offset = entry.tag == 273 || entry.tag == 324;
      put(out, is_offset ? data_at() : entry.value, 4);
    }
    put(out, 0, 4);
    return out + pixels_;
  }

 private:
  static void put(std::string& out, std::uint32_t value, int n_bytes) {
    for (int i = 0; i < n_bytes; ++i) out += static_cast<char>(value >> (8 * i));
  }
  std::uint32_t data_at() const {
    return static_cast<std::uint32_t>(8 + 2 + 12 * entries_.size() + 4);
  }

  std::string pixels_;
  std::vector<TiffEntry> entries_;
};

/// A grey strip of 4 x 3 pixels.
inline TiffFile small_tiff(std::uint32_t bits, std::string pixels) {
  const auto n_bytes = static_cast<std::uint32_t>(pixels.size());
  return TiffFile(std::move(pixels))
      .with({256, 3, 4})
      .with({257, 3, 3})
      .with({258, 3, bits})
      .with({259, 3, 1})
      .with({262, 3, 1})
      .with({273, 4, 0})
      .with({277, 3, 1})
      .with({278, 3, 3})
      .with({279, 4, n_bytes});
}

inline constexpr std::string_view kSmall8("\x0A\x14\x1E\x28\x32\x3C\x46\x50\x5A\x64\x6E\xFF", 12);

/// The same numbers twice as wide: 0x0A0A and so on.
inline std::string small_16() {
  std::string pixels;
  for (const char c : kSmall8) pixels += {c, c};
  return pixels;
}

}  // namespace panelcal::test
