// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/gige_vision/gige_pixels.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "vision/picture/files/raw_pixels.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

struct Row {
  PixelFormat format;
  ArvPixelFormat code;
};

constexpr std::array<Row, 14> kFormats = {{
    {PixelFormat::Mono8, ARV_PIXEL_FORMAT_MONO_8},
    {PixelFormat::Mono10, ARV_PIXEL_FORMAT_MONO_10},
    {PixelFormat::Mono12, ARV_PIXEL_FORMAT_MONO_12},
    {PixelFormat::Mono16, ARV_PIXEL_FORMAT_MONO_16},
    {PixelFormat::BayerRG8, ARV_PIXEL_FORMAT_BAYER_RG_8},
    {PixelFormat::BayerGR8, ARV_PIXEL_FORMAT_BAYER_GR_8},
    {PixelFormat::BayerGB8, ARV_PIXEL_FORMAT_BAYER_GB_8},
    {PixelFormat::BayerBG8, ARV_PIXEL_FORMAT_BAYER_BG_8},
    {PixelFormat::BayerRG16, ARV_PIXEL_FORMAT_BAYER_RG_16},
    {PixelFormat::BayerGR16, ARV_PIXEL_FORMAT_BAYER_GR_16},
    {PixelFormat::BayerGB16, ARV_PIXEL_FORMAT_BAYER_GB_16},
    {PixelFormat::BayerBG16, ARV_PIXEL_FORMAT_BAYER_BG_16},
    {PixelFormat::RGB8, ARV_PIXEL_FORMAT_RGB_8_PACKED},
    {PixelFormat::BGR8, ARV_PIXEL_FORMAT_BGR_8_PACKED},
}};

std::string lower(std::string_view word) {
  std::string text(word);
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

std::optional<std::string_view> genicam_format(std::string_view word) {
  for (const Row& row : kFormats) {
    if (lower(panelcal::name(row.format)) == lower(word)) return panelcal::name(row.format);
  }
  return std::nullopt;
}

std::string address_format(std::string_view genicam) {
  return lower(genicam);
}

const char* status_text(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "missing packets";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "packets out of order";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "another size than announced";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "packets that never came";
    case ARV_BUFFER_STATUS_ABORTED:
      return "a stream that was broken off";
    default:
      return "a payload that is no picture";
  }
}

Expected<Image> image_of(ArvBuffer& buffer, const std::string& camera) {
  const Place place{camera, 0, 0};
  const ArvPixelFormat code = arv_buffer_get_image_pixel_format(&buffer);
  const auto row = std::ranges::find(kFormats, code, &Row::code);
  if (row == kFormats.end()) {
    return failure({Code::DeviceFrame,
                    place,
                    fmt::format("a frame of pixel format {:#010x} came", code),
                    "the format that was set"});
  }
  gint right_bytes = 0;
  gint below_bytes = 0;  // behind the last row, where it does no harm
  arv_buffer_get_image_padding(&buffer, &right_bytes, &below_bytes);
  if (right_bytes != 0) {
    return failure({Code::DeviceFrame,
                    place,
                    fmt::format("{} bytes behind each row of a frame", right_bytes),
                    "rows without gaps: another width of the camera's region"});
  }
  std::size_t n_bytes = 0;
  const auto* const bytes =
      static_cast<const std::byte*>(arv_buffer_get_image_data(&buffer, &n_bytes));
  Expected<Image> image = from_raw_pixels({bytes, n_bytes},
                                          arv_buffer_get_image_width(&buffer),
                                          arv_buffer_get_image_height(&buffer),
                                          row->format);
  if (image) return image;
  return failure({Code::DeviceFrame, place, image.error().what, image.error().expected});
}

}  // namespace panelcal::internal
