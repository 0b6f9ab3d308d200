// SPDX-License-Identifier: Apache-2.0
#include "machine/files/file_register.h"

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;

using testing::Eq;
using testing::Optional;

/// A folder with a program and two pictures.
class FileRegisterTest : public testing::Test {
 protected:
  FileRegisterTest() {
    std::string pattern = testing::TempDir() + "file_register_test_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
    fs::create_directories(folder_ / "images" / "0");
    for (const char* const name : {"job.exc", "other.exc", "images/0000.png", "images/0/a.png"}) {
      std::ofstream(folder_ / name) << name;
    }
    files_.add(folder_ / "job.exc", "the program");
    files_.add(folder_ / "not-yet.ledger", "the ledger");
    files_.add_folder(folder_ / "images", "the pictures");
  }
  ~FileRegisterTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::optional<std::string> use_of(const std::string& name) const {
    return files_.use_of(folder_ / name);
  }

  fs::path folder_;
  FileRegister files_;
};

TEST_F(FileRegisterTest, KnowsAFileByEverySpelling) {
  for (const char* const name :
       {"job.exc", "./job.exc", "images/../job.exc", "images/0/../../job.exc"}) {
    EXPECT_THAT(use_of(name), Optional(Eq("the program"))) << name;
  }
  EXPECT_EQ(files_.use_of(fs::relative(folder_ / "job.exc")), "the program");
}

TEST_F(FileRegisterTest, KnowsAFileByItsLinks) {
  fs::create_symlink("job.exc", folder_ / "soft");
  fs::create_symlink("soft", folder_ / "soft-of-soft");
  fs::create_hard_link(folder_ / "job.exc", folder_ / "hard");
  fs::create_directory_symlink(".", folder_ / "here");
  for (const char* const name : {"soft", "soft-of-soft", "hard", "here/job.exc"}) {
    EXPECT_THAT(use_of(name), Optional(Eq("the program"))) << name;
  }
}

TEST_F(FileRegisterTest, KnowsWhatIsNotThereYetByItsPlace) {
  EXPECT_THAT(use_of("not-yet.ledger"), Optional(Eq("the ledger")));
  fs::create_symlink("not-yet.ledger", folder_ / "dangling");
  EXPECT_THAT(use_of("images/../not-yet.ledger"), Optional(Eq("the ledger")));
}

TEST_F(FileRegisterTest, HoldsAllOfAFolder) {
  for (const char* const name :
       {"images", "images/", "images/0000.png", "images/new.html", "images/0/a.png"}) {
    EXPECT_THAT(use_of(name), Optional(Eq("in the pictures"))) << name;
  }
}

TEST_F(FileRegisterTest, HoldsOtherNamesOfAFoldersFiles) {
  fs::create_hard_link(folder_ / "images/0/a.png", folder_ / "hard.png");
  fs::create_symlink("../other.exc", folder_ / "images/1.png");
  EXPECT_THAT(use_of("hard.png"), Optional(Eq("in the pictures")));
  EXPECT_THAT(use_of("other.exc"), Optional(Eq("in the pictures")));
}

TEST_F(FileRegisterTest, LeavesOtherNamesFree) {
  for (const char* const name : {"other.exc", "new.exc", "images2/0000.png", "job.exc.bak"}) {
    EXPECT_EQ(use_of(name), std::nullopt) << name;
  }
}

}  // namespace
}  // namespace panelcal
