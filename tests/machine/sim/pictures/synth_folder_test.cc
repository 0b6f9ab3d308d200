// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/synth_folder.h"

#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::prepare_synth_folder;
using test::FailsWith;

class SynthFolder : public ::testing::Test {
 protected:
  void put(const std::string& name, std::string_view text = "x") const {
    ASSERT_TRUE(write_file(folder_.path() / name, text));
  }
  std::set<std::string> names() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  std::filesystem::path path() const { return folder_.path(); }

 private:
  test::TemporaryFolder folder_;
};

constexpr std::string_view kSamples =
    R"({"kind":"sample-truth","pictures":[{"file":"0000.png"},{"file":"0001.png"}]})";

TEST_F(SynthFolder, IsMade) {
  EXPECT_TRUE(prepare_synth_folder(path() / "a" / "b"));
  EXPECT_TRUE(std::filesystem::is_directory(path() / "a" / "b"));
}

TEST_F(SynthFolder, OldSamplesGoAndEverythingElseStays) {
  put("truth.json", kSamples);
  put("0000.png");
  put("0001.png");
  put("notes.txt");
  put("board.png");
  put("12.png");
  ASSERT_TRUE(prepare_synth_folder(path()));
  EXPECT_EQ(names(), (std::set<std::string>{"12.png", "board.png", "notes.txt"}));
}

TEST_F(SynthFolder, AnOldRecordingGoesWithItsList) {
  put("truth.json", R"({"kind":"truth","version":1})");
  put("images.csv", "file,x,y\n0000.png,1,2\n0001_view2_3.png,1,2\nmine.png,3,4\n");
  put("0000.png");
  put("0001_view2_3.png");
  put("mine.png");
  ASSERT_TRUE(prepare_synth_folder(path()));
  EXPECT_EQ(names(), std::set<std::string>{"mine.png"});
}

/// Files that would be mixed up with new pictures, of unknown origin.
TEST_F(SynthFolder, ForeignPicturesAreNeitherMixedInNorRemoved) {
  put("truth.json", kSamples);
  put("0000.png");
  put("0002.png");
  const auto before = names();
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0002.png\""));
  EXPECT_EQ(names(), before);
}

/// Only a truth.json tells that a list is not a camera's.
TEST_F(SynthFolder, ARecordingOfACameraStays) {
  put("images.csv", "file,x,y\n0000.png,1,2\n");
  put("0000.png");
  const auto before = names();
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0000.png\""));
  put("truth.json", "[1]");
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0000.png\""));
  put("truth.json", R"({"kind":"photographs"})");
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0000.png\""));
  EXPECT_EQ(names().size(), before.size() + 1);
}

TEST_F(SynthFolder, ListsThatLeaveTheFolderRemoveNothing) {
  std::filesystem::create_directory(path() / "in");
  put("0000.png");
  ASSERT_TRUE(write_file(path() / "in" / "truth.json",
                         R"({"kind":"sample-truth","pictures":[{"file":"../0000.png"}]})"));
  ASSERT_TRUE(prepare_synth_folder(path() / "in"));
  EXPECT_TRUE(names().contains("0000.png"));
}

TEST_F(SynthFolder, AFileInItsPlaceIsAnError) {
  put("taken");
  EXPECT_THAT(prepare_synth_folder(path() / "taken"), FailsWith(Code::DeviceWrite));
}

}  // namespace
}  // namespace panelcal
