// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_files.h"

#include "calib/base/files/atomic_file.h"
#include <gmock/gmock.h>

#include "tests/machine/nightly/picture_night.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(NightFiles, SaysWhereReportsGoWhateverElseIsWrong) {
  const test::TemporaryFolder folder;
  const auto toml = folder.path() / "machine.toml";
  ASSERT_TRUE(
      write_file(toml,
                 "nonsense = 1\n[machine]\nname = \"drill 1\"\n[ledger]\nfile = \"a.ledger\"\n"
                 "[nightly]\nreports = \"reports\"\nnoon_utc_h = 4\ncalibrate = 7\n"));
  const auto files = find_night_files(toml);
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_EQ(files->machine, "drill 1");
  EXPECT_EQ(files->ledger, folder.path() / "a.ledger");
  EXPECT_EQ(files->reports, folder.path() / "reports");
  EXPECT_EQ(files->noon_utc_h, 4);
  EXPECT_TRUE(files->camera.empty());
  ASSERT_TRUE(write_file(toml, "[nightly]\nreports = 3\nnoon_utc_h = 99\n"));
  const auto odd = find_night_files(toml);
  ASSERT_TRUE(odd) << odd.error().text();
  EXPECT_TRUE(odd->reports.empty());
  EXPECT_EQ(odd->noon_utc_h, 12);
  ASSERT_TRUE(write_file(toml, "[nightly\n"));
  EXPECT_THAT(find_night_files(toml), test::FailsWith(Code::TomlSyntax));
}

TEST(NightFiles, ADamagedCalibrationComesBackFromTheLedgerAndAReadableOneStays) {
  const test::PictureNights nights;
  const auto config = nights.config();
  ASSERT_TRUE(config) << config.error().text();
  const auto files = find_night_files(config->file);
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_THAT(restore_damaged_files(*files).value(), IsEmpty()) << "there is no ledger yet";
  ASSERT_TRUE(nights.run(5, {}));
  const auto spindle = config->spindle_setting.file;
  const std::string good = read_file(spindle).value_or("");
  ASSERT_THAT(good, HasSubstr("offset_mm"));
  EXPECT_THAT(restore_damaged_files(*files).value(), IsEmpty());
  ASSERT_TRUE(write_file(spindle, "{\"kind\": "));
  EXPECT_FALSE(nights.config());
  EXPECT_THAT(restore_damaged_files(*files).value(), ElementsAre(HasSubstr("from the ledger")));
  EXPECT_EQ(read_file(spindle).value_or(""), good);
  EXPECT_TRUE(nights.config());
  // The ledger knows no camera of this machine.
  ASSERT_TRUE(write_file(nights.camera_file(), "{"));
  EXPECT_THAT(restore_damaged_files(*files).value(), IsEmpty());
}

}  // namespace
}  // namespace panelcal
