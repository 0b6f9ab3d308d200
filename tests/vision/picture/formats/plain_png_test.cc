// SPDX-License-Identifier: Apache-2.0
// The fast reader beside libpng: whatever it reads, libpng reads as well and the same.
#include "vision/picture/formats/plain_png.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/formats/image_header.h"
#include "vision/picture/formats/png_codec.h"
#include <gtest/gtest.h>
#include <libdeflate.h>

namespace panelcal {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::size_t below(Random& random, std::size_t n) {
  return std::min(n - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(n)));
}

std::string number_of_4(std::size_t n) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(n >> shift & 0xFF);
  return bytes;
}

std::string chunk(const std::string& kind, const std::string& data) {
  const std::string body = kind + data;
  return number_of_4(data.size()) + body +
         number_of_4(libdeflate_crc32(0, body.data(), body.size()));
}

std::string deflated(const Bytes& bytes, int level) {
  libdeflate_compressor* compressor = libdeflate_alloc_compressor(level);
  std::string out(libdeflate_zlib_compress_bound(compressor, bytes.size()), '\0');
  out.resize(
      libdeflate_zlib_compress(compressor, bytes.data(), bytes.size(), out.data(), out.size()));
  libdeflate_free_compressor(compressor);
  return out;
}

/// The form of a picture file.
struct Form {
  int width = 13;
  int height = 9;
  int color = 0;  ///< PNG colour type
  int bits = 8;
  int filter = 0;  ///< of every row; 5: another one for each
  int n_chunks = 1;
  int level = 6;
  int n_filters = 5;  ///< from which a row's is drawn

  std::size_t row_bytes() const {
    constexpr std::size_t kChannels[] = {1, 0, 3, 0, 2, 0, 4};
    return static_cast<std::size_t>(width) * kChannels[color] * static_cast<std::size_t>(bits / 8);
  }
};

/// Any bytes are pixels behind any filter, so that nothing needs to be filtered to write one.
Bytes any_rows(const Form& form, Random& random) {
  Bytes rows;
  for (int y = 0; y < form.height; ++y) {
    rows.push_back(static_cast<std::uint8_t>(
        form.filter < 5 ? form.filter : below(random, static_cast<std::size_t>(form.n_filters))));
    for (std::size_t i = 0; i < form.row_bytes(); ++i) {
      rows.push_back(static_cast<std::uint8_t>(below(random, i % 3 == 0 ? 256 : 8)));
    }
  }
  return rows;
}

std::string file_of(const Form& form, const Bytes& rows) {
  std::string header = number_of_4(static_cast<std::size_t>(form.width)) +
                       number_of_4(static_cast<std::size_t>(form.height));
  header += {static_cast<char>(form.bits), static_cast<char>(form.color), 0, 0, 0};
  std::string file = "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("pHYs", "12341234\1");
  const std::string data = deflated(rows, form.level);
  const auto n = static_cast<std::size_t>(form.n_chunks);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t begin = data.size() * k / n;
    file += chunk("IDAT", data.substr(begin, data.size() * (k + 1) / n - begin));
  }
  return file + chunk("tEXt", std::string("Author\0me", 9)) + chunk("IEND", "");
}

internal::Decoded by_libpng(std::string_view bytes) {
  const auto header = internal::picture_header(bytes, internal::PictureKind::Png);
  if (!header || header->width * header->height > 100'000) return tl::unexpected<std::string>("");
  return internal::decode_by_libpng(bytes, *header);
}

TEST(PlainPng, ReadsEveryFormAsLibpngDoes) {
  Random random(20);
  int n = 0;
  for (const int color : {0, 2, 4, 6}) {
    for (const int bits : {8, 16}) {
      for (int filter = 0; filter <= 5; ++filter) {
        for (const int width : {1, 2, 13, 64}) {
          for (const int n_chunks : {1, 3}) {
            const Form form{width, 1 + width / 2, color, bits, filter, n_chunks};
            const std::string file = file_of(form, any_rows(form, random));
            const auto fast = internal::read_plain_png(file);
            ASSERT_TRUE(fast.has_value()) << color << ' ' << bits << ' ' << filter << ' ' << width;
            const auto slow = by_libpng(file);
            ASSERT_TRUE(slow.has_value()) << slow.error();
            EXPECT_EQ(*fast, *slow) << color << ' ' << bits << ' ' << filter << ' ' << width;
            ++n;
          }
        }
      }
    }
  }
  EXPECT_EQ(n, 384);
}

TEST(PlainPng, ReadsWhatIsWrittenHere) {
  Image image(40, 30, Image::kFullScale16, 300);
  image.at(7, 9) = 65535;
  EXPECT_EQ(internal::read_plain_png(*encode_png(image)), image);
}

/// Puts a right checksum behind every chunk, so that damage gets past it.
void mend_checksums(std::string& file) {
  std::size_t at = 8;
  while (at + 12 <= file.size()) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < 4; ++i) n = n << 8 | static_cast<std::uint8_t>(file[at + i]);
    if (n > file.size() - at - 12) return;
    const std::string right = number_of_4(libdeflate_crc32(0, file.data() + at + 4, n + 4));
    std::copy(right.begin(), right.end(), file.begin() + static_cast<std::ptrdiff_t>(at + 8 + n));
    at += n + 12;
  }
}

/// A byte changed, one left out, the end cut off, or a file that goes on.
std::string damaged(std::string file, Random& random) {
  const std::size_t at = 8 + below(random, file.size() - 8);
  switch (below(random, 4)) {
    case 0:
      file[at] = static_cast<char>(below(random, 256));
      break;
    case 1:
      file.erase(at, 1);
      break;
    case 2:
      file.resize(at);
      break;
    default:
      file.insert(at, 1, static_cast<char>(below(random, 256)));
  }
  if (random.uniform() < 0.7) mend_checksums(file);
  return file;
}

TEST(PlainPng, ReadsNoDamagedFileThatLibpngRefusesOrReadsOtherwise) {
  Random random(21);
  int n_read = 0;
  for (int i = 0; i < 20'000; ++i) {
    constexpr int kColors[] = {0, 2, 4, 6};
    const Form form{.width = 1 + static_cast<int>(below(random, 20)),
                    .height = 1 + static_cast<int>(below(random, 12)),
                    .color = kColors[below(random, 4)],
                    .bits = below(random, 2) == 0 ? 8 : 16,
                    .filter = 5,
                    .n_chunks = 1 + static_cast<int>(below(random, 2)),
                    .level = static_cast<int>(below(random, 10)),
                    .n_filters = below(random, 4) == 0 ? 7 : 5};
    const std::string file = damaged(file_of(form, any_rows(form, random)), random);
    const auto fast = internal::read_plain_png(file);
    if (!fast) continue;
    const auto slow = by_libpng(file);
    ASSERT_TRUE(slow.has_value()) << "file " << i << ": " << slow.error();
    ASSERT_EQ(*fast, *slow) << "file " << i;
    ++n_read;
  }
  EXPECT_GT(n_read, 100);  // damage past the end, or of what says nothing of pixels
}

TEST(PlainPng, LeavesTheOtherKindsToLibpng) {
  Random random(22);
  const Form form;
  const Bytes rows = any_rows(form, random);
  const std::string whole = file_of(form, rows);
  ASSERT_TRUE(internal::read_plain_png(whole).has_value());
  for (const std::size_t at : {std::size_t{24}, std::size_t{25}, std::size_t{28}}) {
    std::string other = whole;  // bits, colour type, interlacing
    other[at] = at == 24 ? 4 : at == 25 ? 3 : 1;
    mend_checksums(other);
    EXPECT_FALSE(internal::read_plain_png(other).has_value()) << at;
  }
  Bytes more = rows;
  more.push_back(0);
  EXPECT_FALSE(internal::read_plain_png(file_of(form, more)).has_value());
  EXPECT_FALSE(internal::read_plain_png("").has_value());
}

}  // namespace
}  // namespace panelcal
