// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "calib/base/executor.h"
#include "calib/base/expected.h"
#include "machine/look/picture_locator.h"
#include "machine/look/view_taker.h"
#include "program/model/measurement.h"
#include "vision/picture/picture_form.h"

namespace panelcal::internal {

/// Reads the file of a picture of which the rest is known.
///
/// Fails  what read_image reports
Expected<TakenPicture> read_picture(TakenPicture picture, const PictureForm& form);

/// A picture that will probably be asked for, and the look at it.
struct ForeseenPicture {
  std::size_t i_row = 0;  ///< of images.csv
  MeasurementRequest request;
  Look look;
  TakenPicture picture;  ///< without its image
};

/// Reads pictures and looks for their targets on other threads, a few ahead of a job.
///
/// A job asks for one target after the other, and where it looks for the next may depend on what
/// the last fit said. So this is guesswork: what was guessed right saves time, what was guessed
/// wrong is looked at again (KnownDetection), and the answers are the same either way.
///
/// See    tests/machine/sources/look_ahead_test.cc
class LookAhead {
 public:
  LookAhead(Executor& executor, const PictureLocator& locator, const PictureForm& form);

  /// Begins anew with these pictures, in their order.
  void plan(std::vector<ForeseenPicture> pictures);
  /// True if a request is another than was foreseen, so that a new plan is worth its price. Says so
  /// less often while new plans do not last.
  bool is_outdated(const MeasurementRequest& request);
  /// The picture of a row, with what was found in it; waits for it if it is under way. Empty if the
  /// row was not foreseen.
  std::optional<Expected<TakenPicture>> take(std::size_t i_row);

 private:
  struct UnderWay {
    std::size_t i_row = 0;
    std::future<Expected<TakenPicture>> picture;
  };
  struct Looker;

  void begin();

  Executor& executor_;
  std::shared_ptr<const Looker> looker_;  ///< shared with the tasks, which may outlive this
  std::vector<ForeseenPicture> planned_;
  std::size_t n_begun_ = 0;     ///< of planned_
  std::size_t i_expected_ = 0;  ///< of planned_, where the job is
  std::deque<UnderWay> under_way_;
  std::size_t n_right_ = 0;  ///< requests since the last plan that were foreseen
  std::size_t n_wrong_ = 0;
  std::size_t patience_ = 0;  ///< wrong ones that do not yet make a plan outdated
};

}  // namespace panelcal::internal
