// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/spool.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(Spool, PassesFewBytesOn) {
  Spool spool;
  ASSERT_TRUE(spool.write("one"));
  ASSERT_TRUE(spool.write(" two"));
  StringSink target;
  ASSERT_TRUE(spool.pass_to(target));
  EXPECT_EQ(target.text(), "one two");
}

TEST(Spool, PassesOnMoreThanItKeepsInMemory) {
  Spool spool;
  std::string expected;
  for (int i = 0; expected.size() < 3 * Spool::kInMemory; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    ASSERT_TRUE(spool.write(line));
    expected += line;
  }
  StringSink target;
  ASSERT_TRUE(spool.pass_to(target));
  EXPECT_EQ(target.text(), expected);
}

TEST(Spool, DropsWhatIsCleared) {
  Spool spool;
  ASSERT_TRUE(spool.write(std::string(2 * Spool::kInMemory, 'a')));
  spool.clear();
  ASSERT_TRUE(spool.write("b"));
  StringSink target;
  ASSERT_TRUE(spool.pass_to(target));
  EXPECT_EQ(target.text(), "b");
}

}  // namespace
}  // namespace panelcal
