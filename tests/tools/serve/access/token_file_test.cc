// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/token_file.h"

#include <cstdlib>
#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace panelcal::serve {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class TokenFile : public ::testing::Test {
 protected:
  TokenFile() {
    std::string name = testing::TempDir() + "token_file_test_XXXXXX";
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ / "token";
  }
  ~TokenFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  std::filesystem::path path_;
};

TEST_F(TokenFile, IsMadeOnceAndKeepsNoToken) {
  const auto made = open_token_file(path_);
  ASSERT_TRUE(made) << made.error().text();
  ASSERT_FALSE(made->made.empty());
  EXPECT_TRUE(made->token.is(made->made));
  EXPECT_THAT(*read_file(path_), Not(HasSubstr(made->made)));
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);

  const auto again = open_token_file(path_);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_TRUE(again->made.empty());
  EXPECT_TRUE(again->token.is(made->made));
  EXPECT_FALSE(again->token.is(made->made + "x"));
  EXPECT_FALSE(again->token.is(""));
}

TEST_F(TokenFile, IsRefusedWhereOthersMayReadIt) {
  ASSERT_TRUE(open_token_file(path_));
  ::chmod(path_.c_str(), 0640);
  const auto refused = open_token_file(path_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::FileUnreadable);
  EXPECT_THAT(refused.error().what, HasSubstr("mode 640"));
}

TEST_F(TokenFile, IsRefusedIfItIsAnotherFile) {
  for (const char* const text : {"",
                                 "password\n",
                                 "panelcal-token-1 short hash\n",
                                 "panelcal-token-2 0123456789abcdef 00\n"}) {
    ASSERT_TRUE(write_file(path_, text));
    ::chmod(path_.c_str(), 0600);
    const auto refused = open_token_file(path_);
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().code, Code::FileUnreadable);
    EXPECT_EQ(*read_file(path_), text) << "replaced";
  }
}

TEST_F(TokenFile, NeedsItsFolder) {
  const auto refused = open_token_file(folder_ / "missing" / "token");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::DeviceWrite);
}

}  // namespace
}  // namespace panelcal::serve
