// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vision/locate/locate.h"
#include <Eigen/Core>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

/// A method's answer about one picture.
struct Answer {
  bool is_found = false;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  std::optional<Eigen::Matrix2d> cov;  ///< if the method says how sure it is
  double ms = 0;                       ///< processor time of this thread, conversions not counted
  std::string reason;
};

/// Facts that a method may know: all that panelcal is told, and the condition on top, so that peers
/// can be tuned (contrast, noise, blur). `window_px`: middle of a window that holds the mark and
/// little else, for methods that cannot search.
struct Question {
  const Image& image;
  const Mark& mark;
  const Condition& condition;
  Eigen::Vector2d window_px;
};

struct Method {
  std::string name;
  bool searches = true;  ///< false: it must be told the window
  std::function<Answer(const Question&)> find;
};

/// Processor time of this thread, seconds.
double thread_cpu_s();

/// panelcal's own answer.
Answer locate_answer(const Question& question, const LocateOptions& options = {});

/// panelcal first, then what OpenCV offers for the shape, tuned as well as we can.
std::vector<Method> methods_for(Shape shape);

}  // namespace panelcal::bench
