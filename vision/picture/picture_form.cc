// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/picture_form.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace panelcal {
namespace {

Image with_white(const Image& image, double white) {
  Image out(image.width(), image.height(), white);
  std::ranges::transform(image.pixels(), out.pixels().begin(), [&](float level) {
    return std::min(level, static_cast<float>(white));
  });
  return out;
}

}  // namespace

Image understood(Image image, const PictureForm& form) {
  const bool is_deep = image.full_scale() > Image::kFullScale8;
  if (form.bits && is_deep) image = with_white(image, (std::int64_t{1} << *form.bits) - 1);
  if (form.bayer) image = from_bayer(image, *form.bayer);
  return image;
}

}  // namespace panelcal
