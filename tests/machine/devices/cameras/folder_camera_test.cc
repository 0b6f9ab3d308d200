// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/folder_camera.h"

#include "calib/base/files/atomic_file.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

TEST(FolderCamera, ShowsPicturesInTheOrderOfTheirNamesUntilTheyEnd) {
  const test::TemporaryFolder folder;
  const Image second(5, 4, Image::kFullScale8, 20);
  const Image first(5, 4, Image::kFullScale16, 1000);
  ASSERT_TRUE(write_png(folder.path() / "b.PNG", second));
  ASSERT_TRUE(write_png(folder.path() / "a.png", first));
  ASSERT_TRUE(write_file(folder.path() / "aa.txt", "no picture"));
  const auto camera = open_folder_camera(folder.path());
  ASSERT_TRUE(camera) << camera.error().text();
  EXPECT_EQ((*camera)->take(), first);
  EXPECT_EQ((*camera)->take(), second);
  EXPECT_THAT((*camera)->take(), FailsWith(Code::DeviceFrame, "2 picture"));
}

TEST(FolderCamera, RefusesWhatIsNoFolderOfPictures) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(open_folder_camera(folder.path()), FailsWith(Code::PictureMissing));
  EXPECT_THAT(open_folder_camera(folder.path() / "x"), FailsWith(Code::FileUnreadable, "folder"));
}

TEST(FolderCamera, ADamagedPictureIsAnErrorAndNotPassedOver) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder.path() / "a.png", "no picture"));
  ASSERT_TRUE(write_png(folder.path() / "b.png", Image(5, 4, 255)));
  const auto camera = open_folder_camera(folder.path());
  ASSERT_TRUE(camera);
  EXPECT_THAT((*camera)->take(), FailsWith(Code::PictureFormat, "a.png"));
}

}  // namespace
}  // namespace panelcal
