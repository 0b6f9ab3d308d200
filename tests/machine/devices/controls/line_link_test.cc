// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/line_link.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// A serial line whose other end is the test.
class SerialLine : public ::testing::Test {
 protected:
  void SetUp() override {
    int control = -1;
    int device = -1;
    ASSERT_EQ(openpty(&control, &device, name_.data(), nullptr, nullptr), 0);
    control_ = internal::FileDescriptor(control);
    kept_ = internal::FileDescriptor(device);
    name_ = name_.c_str();
    auto link = LineLink::serial(name_, 115200);
    ASSERT_TRUE(link) << link.error().text();
    link_ = *std::move(link);
  }
  void say(std::string_view text) {
    ASSERT_EQ(write(control_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }

  std::string name_ = std::string(128, '\0');
  internal::FileDescriptor control_, kept_;
  std::unique_ptr<LineLink> link_;
};

TEST_F(SerialLine, GivesLinesWithoutTheirEnds) {
  say("ok\r\n\r\n<Idle");
  EXPECT_EQ(*link_->line(seconds(5)), "ok");
  EXPECT_EQ(*link_->line(seconds(5)), "");
  EXPECT_EQ(*link_->line(seconds(0)), std::nullopt);
  say("|MPos>\n");
  EXPECT_EQ(*link_->line(seconds(5)), "<Idle|MPos>");
}

TEST_F(SerialLine, PassesEveryByteOn) {
  ASSERT_TRUE(link_->send(std::string_view("?\x85\x18\x00\r\n", 6)));
  std::string bytes(6, ' ');
  for (std::size_t n = 0; n < 6;) {
    n += static_cast<std::size_t>(read(control_.get(), bytes.data() + n, 6 - n));
  }
  EXPECT_EQ(bytes, std::string("?\x85\x18\x00\r\n", 6));
}

TEST_F(SerialLine, APlugThatIsPulledIsALostConnection) {
  say("ok\n");
  EXPECT_EQ(*link_->line(seconds(5)), "ok");
  control_.close();
  EXPECT_THAT(link_->line(seconds(5)), FailsWith(Code::DeviceStage, "lost connection"));
  EXPECT_THAT(link_->send("?"), FailsWith(Code::DeviceStage, "lost connection"));
}

TEST_F(SerialLine, IsNotShared) {
  EXPECT_THAT(LineLink::serial(name_, 115200), FailsWith(Code::DeviceStage, "in use"));
}

TEST(LineLink, NamesWhatCannotBeOpened) {
  EXPECT_THAT(LineLink::serial("/nowhere/tty", 115200), FailsWith(Code::DeviceStage, "/nowhere"));
  EXPECT_THAT(LineLink::serial("/dev/null", 115200),
              FailsWith(Code::DeviceStage, "cannot be opened"));
  EXPECT_THAT(LineLink::serial("/dev/null", 12345), FailsWith(Code::DeviceStage, "12345 baud"));
  // Nothing listens on the port that only the system itself may open.
  EXPECT_THAT(LineLink::tcp("127.0.0.1", 1, seconds(5)),
              FailsWith(Code::DeviceStage, "no connection"));
  EXPECT_THAT(LineLink::tcp("no host", 23, seconds(5)), FailsWith(Code::DeviceStage, "no host"));
}

}  // namespace
}  // namespace panelcal
