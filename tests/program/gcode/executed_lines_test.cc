// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/executed_lines.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::gcode {
namespace {

using ::testing::HasSubstr;

/// Numbers of the lines in the order of execution, orders left out; or why it ends.
std::string executed(const std::string& text) {
  const SourceText program{"p.ngc", text};
  ExecutedLines lines(program);
  std::string out;
  while (true) {
    const auto next = lines.next();
    if (!next) return out + test::brief(next.error());
    if (!*next) return out;
    if (!(*next)->is_order) out += std::to_string((*next)->line.number) + ' ';
  }
}

TEST(GcodeExecutedLines, AreThoseOfTheFileWithoutOrders) {
  EXPECT_EQ(executed("G0\n\nG1"), "1 2 3 ");
}

TEST(GcodeExecutedLines, AreThoseOfSubprogramsWhereTheyAreCalled) {
  EXPECT_EQ(executed("o1 sub\nX1\no1 endsub\nX2\no1 call\nX3\no1call\n"), "4 2 6 2 ");
  EXPECT_EQ(executed("N5 O<A b> Sub (x)\nX1\nO<ab> endsub\no<ab> call ; y\n"), "2 ");
  EXPECT_EQ(executed("o1 sub\nX1\no1 endsub\no2 sub\no1 call\nX2\no1 call\no2 endsub\no2 call\n"),
            "2 6 2 ");
  EXPECT_EQ(executed("o1 sub\nX1\no1 return\nX2\no1 endsub\no1 call\nX3"), "2 7 ");
}

TEST(GcodeExecutedLines, AreRepeated) {
  EXPECT_EQ(executed("o1 repeat [2]\nX1\no2 repeat[3]\nX2\no2 endrepeat\no1 endrepeat\nX3\n"),
            "2 4 4 4 2 4 4 4 7 ");
  EXPECT_EQ(executed("o1 repeat [0]\nX1\no1 endrepeat\nX2"), "4 ");
  EXPECT_EQ(executed("o1 sub\no2 repeat [5]\nX1\no1 return\no2 endrepeat\no1 endsub\no1 call\nX2"),
            "3 8 ");
}

TEST(GcodeExecutedLines, KnowWhetherTheyAreInASubprogram) {
  const SourceText program{"p.ngc", "o1 sub\nX1\no1 endsub\no1 call\nX2"};
  ExecutedLines lines(program);
  std::string inside;
  while (const auto next = *lines.next()) {
    if (!next->is_order) inside += next->is_inside ? 'i' : 'o';
  }
  EXPECT_EQ(inside, "io");
}

TEST(GcodeExecutedLines, RefuseWhatDependsOnVariables) {
  for (const std::string line : {"o1 call [5]",
                                 "o1 while [#1 lt 5]",
                                 "o1 if [#1]",
                                 "o1 repeat [#1]",
                                 "o1 repeat [2+1]",
                                 "o1 repeat [-1]",
                                 "o#1 call",
                                 "o[1] call",
                                 "o<x> call",
                                 "/o1 call",
                                 "o sub"}) {
    EXPECT_EQ(executed("X0\n  " + line + "\n"), "1 p.ngc:2:3: error[not-supported]") << line;
  }
  // Not known before it stands there, as LinuxCNC has it.
  EXPECT_THAT(executed("o1 call\no1 sub\no1 endsub\n"), HasSubstr("p.ngc:1:1: error[not-supp"));
}

TEST(GcodeExecutedLines, RefuseEndsWithoutABegin) {
  EXPECT_EQ(executed("o1 endsub\n"), "p.ngc:1:1: error[command-unknown]");
  EXPECT_EQ(executed("o1 return\n"), "p.ngc:1:1: error[command-unknown]");
  EXPECT_EQ(executed("o1 endrepeat\n"), "p.ngc:1:1: error[command-unknown]");
  EXPECT_EQ(executed("o1 sub\nX1\n"), "p.ngc:1:1: error[command-unknown]");
  EXPECT_EQ(executed("o1 repeat [2]\nX1\n"), "2 p.ngc:2:1: error[command-unknown]");
  EXPECT_EQ(executed("o1 repeat [2]\no2 repeat [2]\no1 endrepeat\n"),
            "p.ngc:3:1: error[command-unknown]");
}

TEST(GcodeExecutedLines, EndSomeTime) {
  EXPECT_EQ(executed("o1 sub\no1 call\no1 endsub\no1 call\n"),
            "p.ngc:2:1: error[subprogram-recursive]");
  EXPECT_THAT(executed("o1 repeat [999999999]\no1 endrepeat\n"), "p.ngc:2:1: error[not-supported]");
  EXPECT_THAT(executed("o1 repeat [99999999999999999999]\no1 endrepeat\n"),
              "p.ngc:1:1: error[not-supported]");
}

}  // namespace
}  // namespace panelcal::gcode
