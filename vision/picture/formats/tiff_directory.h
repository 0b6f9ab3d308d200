// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace panelcal::internal {

/// The entries of a TIFF file's first directory that decide what its pixels mean (TIFF 6.0,
/// sections 2, 8, 15, 18 and 19). Defaults are the specification's.
struct TiffDirectory {
  static constexpr std::uint32_t kMinIsWhite = 0;
  static constexpr std::uint32_t kRgb = 2;

  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t tile_width = 0;  ///< 0 if the pixels lie in strips
  std::int64_t tile_height = 0;
  std::uint32_t bits = 1;     ///< per sample
  std::uint32_t samples = 1;  ///< per pixel
  std::uint32_t photometric = 1;
  std::uint32_t sample_format = 1;  ///< 1 unsigned, 2 signed, 3 floating-point
  bool big_endian = false;
  /// Offsets at which the file holds the value of these 16-bit entries.
  std::optional<std::size_t> orientation_at;
  std::optional<std::size_t> first_extra_sample_at;
};

/// Reads the directory without decoding; empty if it is cut off or damaged, or says the
/// same thing twice (readers differ in whom they believe).
std::optional<TiffDirectory> tiff_directory(std::string_view bytes);

/// The file with its orientation and its transparency taken back, if it has either: the decoder
/// would turn the picture by the one and multiply its levels with the other.
std::optional<std::string> without_orientation_and_alpha(std::string_view bytes,
                                                         const TiffDirectory& directory);

}  // namespace panelcal::internal
