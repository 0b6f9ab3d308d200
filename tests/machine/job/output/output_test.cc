// SPDX-License-Identifier: Apache-2.0
#include "machine/job/output/output.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// Takes nothing, as a closed pipe does.
class FullSink final : public ByteSink {
 public:
  Expected<void> write(std::string_view) override {
    return failure({Code::DeviceWrite, {"pipe", 0, 0}, "closed", ""});
  }
};

TEST(SpooledOutput, KeepsBytesBackUntilTheyAreCommitted) {
  StringSink target;
  SpooledOutput output(target);
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write("one"));
  ASSERT_TRUE(output.write(" two"));
  EXPECT_EQ(target.text(), "");
  EXPECT_FALSE(output.has_begun_to_commit());
  ASSERT_TRUE(output.commit());
  EXPECT_EQ(target.text(), "one two");
  EXPECT_TRUE(output.has_begun_to_commit());
}

TEST(SpooledOutput, DropsWhatCameBeforeItBeginsAnew) {
  StringSink target;
  SpooledOutput output(target);
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write(std::string(2 * Spool::kInMemory, 'a')));
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write("b"));
  ASSERT_TRUE(output.commit());
  EXPECT_EQ(target.text(), "b");
}

TEST(SpooledOutput, TellsThatTheTargetTakesNothing) {
  FullSink target;
  SpooledOutput output(target);
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write("a"));
  EXPECT_THAT(output.commit(), FailsWith(Code::DeviceWrite, "closed"));
}

TEST(FileOutput, AppearsWholeOrNotAtAll) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "job.drl";
  {
    FileOutput output(file);
    ASSERT_TRUE(output.begin());
    ASSERT_TRUE(output.write("half"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  FileOutput output(file);
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write("dropped"));
  ASSERT_TRUE(output.begin());
  ASSERT_TRUE(output.write("whole"));
  ASSERT_TRUE(output.commit());
  EXPECT_EQ(read_file(file).value(), "whole");
}

}  // namespace
}  // namespace panelcal
