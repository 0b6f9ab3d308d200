// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/picture_form.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(PictureForm, TakesTwelveBitsInSixteenForWhatTheyAre) {
  Image file(3, 1, Image::kFullScale16, 100);
  file.at(1, 0) = 4095;
  file.at(2, 0) = 5000;
  const Image image = understood(file, {.bits = 12});
  EXPECT_EQ(image.full_scale(), 4095);
  EXPECT_EQ(image.at(0, 0), 100);
  EXPECT_EQ(image.at(1, 0), 4095);
  EXPECT_EQ(image.at(2, 0), 4095);
}

TEST(PictureForm, LeavesOthersAsTheyAre) {
  const Image deep(2, 2, Image::kFullScale16, 100);
  const Image shallow(2, 2, Image::kFullScale8, 100);
  EXPECT_EQ(understood(deep, {}), deep);
  EXPECT_EQ(understood(shallow, {.bits = 12}), shallow);
}

}  // namespace
}  // namespace panelcal
