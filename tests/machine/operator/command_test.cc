// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/command.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

using internal::Choice;
using internal::Command;
using internal::Order;
using internal::parse_command;

void expect_refused(std::string_view json, Code code = Code::Usage) {
  const auto command = parse_command(json, "Anna");
  ASSERT_FALSE(command) << json;
  EXPECT_EQ(command.error().code, code) << command.error().text();
}

TEST(OperatorCommand, ReadsWhatEachOrderHas) {
  const auto open = parse_command(R"({"do":"open","program":"panel.exc"})", "Anna");
  ASSERT_TRUE(open) << open.error().text();
  EXPECT_EQ(open->order, Order::Open);
  EXPECT_EQ(open->name, "panel.exc");
  EXPECT_EQ(open->who, "Anna");

  const auto jog = parse_command(R"({"do":"jog","by_mm":[0.5,-1]})", "Anna");
  ASSERT_TRUE(jog);
  EXPECT_EQ(jog->by_mm, Eigen::Vector2d(0.5, -1));

  const auto back = parse_command(
      R"({"do":"roll_back","kind":"camera","to":"17","reason":"the lens was hit"})", "Anna");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->to, 17);
  EXPECT_EQ(back->reason, "the lens was hit");
}

TEST(OperatorCommand, ReadsWhatEachChoiceHas) {
  const auto hand =
      parse_command(R"({"do":"answer","question":3,"choice":"hand","at_px":[12.5,7]})", "Ben");
  ASSERT_TRUE(hand) << hand.error().text();
  EXPECT_EQ(hand->answer.question, 3);
  EXPECT_EQ(hand->answer.choice, Choice::Hand);
  EXPECT_EQ(*hand->answer.at_px, Eigen::Vector2d(12.5, 7));
  EXPECT_EQ(hand->answer.who, "Ben");

  const auto candidate =
      parse_command(R"({"do":"answer","question":3,"choice":"candidate","index":2})", "Ben");
  ASSERT_TRUE(candidate);
  EXPECT_EQ(*candidate->answer.index, 2U);

  const auto again =
      parse_command(R"({"do":"answer","question":3,"choice":"again","lamp":40})", "Ben");
  ASSERT_TRUE(again);
  EXPECT_EQ(*again->answer.lamp, 40);
}

TEST(OperatorCommand, RefusesWhatIsNoCommand) {
  expect_refused("", Code::JsonSyntax);
  expect_refused(R"({"do":"stop","do":"stop"})", Code::JsonSyntax);
  expect_refused("[]");
  expect_refused("{}");
  expect_refused(R"({"do":"drill"})");
  expect_refused(R"({"do":"stop","now":true})");
  expect_refused(R"({"do":"open"})");
  expect_refused(R"({"do":"open","program":7})");
  expect_refused(R"({"do":"jog","by_mm":[1]})");
  expect_refused(R"({"do":"jog","by_mm":[1,1e9]})");
  expect_refused(R"({"do":"answer","question":1,"choice":"guess"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"hand"})");
  expect_refused(R"({"do":"answer","question":-1,"choice":"skip"})");
  expect_refused(R"({"do":"answer","question":1,"choice":"skip","at_px":[1,1]})");
  expect_refused(R"({"do":"answer","question":1,"choice":"again","exposure":"long"})");
  expect_refused(R"({"do":"roll_back","kind":"camera","to":"17a","reason":"x"})");
  expect_refused("{\"do\":\"stop\",\"x\":\"" + std::string(70'000, 'x') + "\"}");
}

TEST(OperatorCommand, TakesNoNameThatCouldBecomeALineOfAProgram) {
  const std::string longest(100, 'x');
  for (const std::string& who : {std::string("J\xC3\xB6rg O'Neil"), longest}) {
    EXPECT_TRUE(parse_command(R"({"do":"stop"})", who)) << who;
  }
  for (const std::string& who :
       {std::string(), std::string("Anna\nX0Y0"), std::string("Anna\r"), longest + "x"}) {
    EXPECT_FALSE(parse_command(R"({"do":"stop"})", who)) << who;
  }
  expect_refused(R"({"do":"roll_back","kind":"camera","to":1,"reason":"a\nb"})");
}

}  // namespace
}  // namespace panelcal
