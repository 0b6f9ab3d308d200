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

using internal::finish_synth_folder;
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

TEST_F(SynthFolder, IsMade) {
  EXPECT_TRUE(prepare_synth_folder(path() / "a" / "b"));
  EXPECT_TRUE(std::filesystem::is_directory(path() / "a" / "b"));
}

TEST_F(SynthFolder, WhatSynthWroteGoesAndEverythingElseStays) {
  put("truth.json");
  put("images.csv", "file,x,y\n");
  put("0000.png");
  put("0001_view2_3.png");
  ASSERT_TRUE(
      finish_synth_folder(path(), {"truth.json", "images.csv", "0001_view2_3.png", "0000.png"}));
  put("notes.txt");
  put("board.png");
  put("12.png");
  ASSERT_TRUE(prepare_synth_folder(path()));
  EXPECT_EQ(names(), (std::set<std::string>{"12.png", "board.png", "notes.txt"}));
}

/// As `sha256sum` prints it.
TEST_F(SynthFolder, TheManifestHasADigestForEveryFile) {
  put("0000.png", "abc");
  put("truth.json", "");
  ASSERT_TRUE(finish_synth_folder(path(), {"truth.json", "0000.png"}));
  EXPECT_EQ(read_file(path() / "synth.sha256", 1000),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  0000.png\n"
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  truth.json\n");
  EXPECT_THAT(finish_synth_folder(path(), {"0001.png"}),
              FailsWith(Code::FileUnreadable, "0001.png"));
}

/// Files that would be mixed up with new pictures, of unknown origin.
TEST_F(SynthFolder, ForeignPicturesAreNeitherMixedInNorRemoved) {
  put("truth.json");
  put("0000.png");
  ASSERT_TRUE(finish_synth_folder(path(), {"truth.json", "0000.png"}));
  put("0002.png");
  const auto before = names();
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0002.png\""));
  EXPECT_EQ(names(), before);
}

/// A camera's pictures under the names of synth's, beside the lists that synth left.
TEST_F(SynthFolder, PicturesThatWerePutInThePlaceOfSynthsStay) {
  for (const char* const name : {"0000.png", "images.csv", "truth.json"}) {
    put("truth.json");
    put("images.csv", "file,x,y\n");
    put("0000.png");
    ASSERT_TRUE(finish_synth_folder(path(), {"truth.json", "images.csv", "0000.png"}));
    put(name, "of a camera");
    const auto before = names();
    EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, name));
    EXPECT_EQ(names(), before);
  }
}

/// Only the manifest tells what synth wrote.
TEST_F(SynthFolder, AFolderWithoutTheDigestsStays) {
  put("truth.json", R"({"kind":"sample-truth","pictures":[{"file":"0000.png"}]})");
  put("0000.png");
  const auto before = names();
  EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0000.png\""));
  EXPECT_EQ(names(), before);
  for (const char* const text : {"", "0000.png\n", "2d711642  0000.png", "\n\n"}) {
    put("synth.sha256", text);
    EXPECT_THAT(prepare_synth_folder(path()), FailsWith(Code::Usage, "\"0000.png\""));
  }
}

TEST_F(SynthFolder, AManifestThatLeavesTheFolderRemovesNothing) {
  std::filesystem::create_directory(path() / "in");
  put("0000.png");
  put("notes.txt");
  ASSERT_TRUE(finish_synth_folder(path() / "in", {"../0000.png", "../notes.txt"}));
  ASSERT_TRUE(prepare_synth_folder(path() / "in"));
  EXPECT_TRUE(names().contains("0000.png"));
  EXPECT_TRUE(names().contains("notes.txt"));
}

TEST_F(SynthFolder, AFileInItsPlaceIsAnError) {
  put("taken");
  EXPECT_THAT(prepare_synth_folder(path() / "taken"), FailsWith(Code::DeviceWrite));
}

}  // namespace
}  // namespace panelcal
