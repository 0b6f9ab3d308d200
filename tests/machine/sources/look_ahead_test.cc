// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/look_ahead.h"

#include <vector>

#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>

#include "tests/machine/counted_tasks.h"
#include "tests/machine/small_panel.h"
#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::FailsWith;

class LookAheadTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto locator = PictureLocator::create(config_);
    ASSERT_TRUE(locator) << locator.error().text();
    ahead_.emplace(executor_, *locator, PictureForm{});
    ASSERT_TRUE(write_png(folder_.path() / "grey.png", Image(240, 220, 255)));
  }
  MeasurementRequest request(std::int64_t seq, double x_mm = 1) const {
    MeasurementRequest request;
    request.seq = seq;
    request.command = "G36";
    request.expected = position_mm<frame::Actual>(x_mm, 2);
    return request;
  }
  ForeseenPicture foreseen(std::size_t i_row, const std::string& file = "grey.png") const {
    ForeseenPicture picture;
    picture.i_row = i_row;
    picture.request = request(static_cast<std::int64_t>(i_row));
    picture.look.target = config_.vision_tools.at(1);
    picture.picture.path = (folder_.path() / file).string();
    return picture;
  }
  std::vector<ForeseenPicture> rows(std::size_t n) const {
    std::vector<ForeseenPicture> pictures;
    for (std::size_t i = 0; i < n; ++i) pictures.push_back(foreseen(i));
    return pictures;
  }

  test::TemporaryFolder folder_;
  MachineConfig config_ = test::small_config(folder_.path());
  test::CountedTasks executor_;
  std::optional<LookAhead> ahead_;
};

TEST_F(LookAheadTest, ReadsAFewPicturesAheadAndNotAll) {
  ahead_->plan(rows(20));
  EXPECT_EQ(executor_.n_posted, executor_.lead());
  const auto first = ahead_->take(0);
  ASSERT_TRUE(first);
  ASSERT_TRUE(*first) << first->error().text();
  EXPECT_EQ((*first)->image.width(), 240);
  EXPECT_EQ(executor_.n_posted, executor_.lead() + 1);
}

TEST_F(LookAheadTest, ARowThatWasNotForeseenIsLeftToTheCaller) {
  ahead_->plan(rows(3));
  EXPECT_FALSE(ahead_->take(7));
  EXPECT_TRUE(ahead_->take(1)) << "the others are still there";
  EXPECT_FALSE(ahead_->take(0)) << "the job went past it";
  EXPECT_TRUE(ahead_->take(2));
  EXPECT_FALSE(ahead_->take(2));
}

TEST_F(LookAheadTest, APictureThatCannotBeReadFailsInItsPlace) {
  ahead_->plan({foreseen(0), foreseen(1, "missing.png"), foreseen(2)});
  EXPECT_TRUE(*ahead_->take(0));
  EXPECT_THAT(*ahead_->take(1), FailsWith(Code::FileUnreadable, "missing.png"));
  EXPECT_TRUE(*ahead_->take(2));
}

TEST_F(LookAheadTest, APlanLastsAsLongAsItsGuessesAreRight) {
  ahead_->plan(rows(20));
  EXPECT_FALSE(ahead_->is_outdated(request(0)));
  EXPECT_FALSE(ahead_->is_outdated(request(4))) << "a target was left out";
  EXPECT_TRUE(ahead_->is_outdated(request(5, 1.001)));
  // The plan was of little use, so the next wrong guess alone makes no new one.
  ahead_->plan(rows(20));
  EXPECT_FALSE(ahead_->is_outdated(request(0, 1.001)));
  EXPECT_TRUE(ahead_->is_outdated(request(1, 1.001)));
}

}  // namespace
}  // namespace panelcal::internal
