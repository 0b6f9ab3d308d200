// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/look_ahead.h"

#include <algorithm>
#include <utility>

#include "vision/picture/files/image_io.h"

namespace panelcal::internal {
namespace {

/// A plan that was right for fewer requests was not worth making.
constexpr std::size_t kWorthwhile = 8;

bool is_same_request(const MeasurementRequest& a, const MeasurementRequest& b) {
  return a.seq == b.seq && a.expected.in_mm() == b.expected.in_mm() &&
         a.work_zero.in_mm() == b.work_zero.in_mm();
}

}  // namespace

Expected<TakenPicture> read_picture(TakenPicture picture, const PictureForm& form) {
  PANELCAL_TRY(picture.image, read_image(picture.path));
  picture.image = understood(std::move(picture.image), form);
  return picture;
}

struct LookAhead::Looker {
  PictureLocator locator;
  PictureForm form;

  Expected<TakenPicture> look_at(const ForeseenPicture& foreseen) const {
    PANELCAL_TRY(TakenPicture picture, read_picture(foreseen.picture, form));
    if (auto known = locator.look_ahead(foreseen.request, foreseen.look, picture)) {
      picture.known = std::make_shared<const KnownDetection>(*std::move(known));
    }
    return picture;
  }
};

LookAhead::LookAhead(Executor& executor, const PictureLocator& locator, const PictureForm& form)
    : executor_(executor), looker_(std::make_shared<const Looker>(Looker{locator, form})) {
}

void LookAhead::plan(std::vector<ForeseenPicture> pictures) {
  planned_ = std::move(pictures);
  n_begun_ = i_expected_ = n_right_ = n_wrong_ = 0;
  under_way_.clear();
  begin();
}

void LookAhead::begin() {
  for (; n_begun_ < planned_.size() && under_way_.size() < executor_.lead(); ++n_begun_) {
    ForeseenPicture& next = planned_[n_begun_];
    under_way_.push_back({next.i_row, submit(executor_, [looker = looker_, next] {
                            return looker->look_at(next);
                          })});
  }
}

bool LookAhead::is_outdated(const MeasurementRequest& request) {
  while (i_expected_ < planned_.size() && planned_[i_expected_].request.seq < request.seq) {
    ++i_expected_;
  }
  const bool is_right =
      i_expected_ < planned_.size() && is_same_request(planned_[i_expected_].request, request);
  (is_right ? n_right_ : n_wrong_)++;
  if (is_right || n_wrong_ <= patience_) return false;
  patience_ = n_right_ >= kWorthwhile ? 0 : std::max<std::size_t>(1, 2 * patience_);
  return true;
}

std::optional<Expected<TakenPicture>> LookAhead::take(std::size_t i_row) {
  const auto found = std::ranges::find(under_way_, i_row, &UnderWay::i_row);
  if (found == under_way_.end()) return std::nullopt;
  auto picture = std::move(found->picture);
  under_way_.erase(under_way_.begin(), found + 1);
  begin();
  return picture.get();
}

}  // namespace panelcal::internal
