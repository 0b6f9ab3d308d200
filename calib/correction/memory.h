// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

namespace panelcal {

/// The stored vision corrections of M50, M51 and M52: per label a list of series in the order they
/// were measured, and one pointer that moves over their points.
///
/// Series are known by the caller's index. Source: CNC-7 manual, Vision Step and Repeat.
class CorrectionMemory {
 public:
  struct Stored {
    std::size_t series = 0;
    int n_points = 0;
  };

  /// M50,label: what is stored from here on belongs to `label`; an earlier content is replaced.
  void start_recording(int label);
  /// M08.
  void stop_recording();
  bool is_recording() const { return recording_.has_value(); }
  /// No effect while nothing records.
  void store(Stored series);

  /// M51,label: false if that label was never recorded.
  bool rewind(int label);
  bool is_rewound() const { return pointer_label_.has_value(); }

  struct Advance {
    std::vector<std::size_t> passed;  ///< series whose last point was passed, in order
    bool beyond_end = false;          ///< fewer points were stored; the pointer did not move
  };
  /// M52,n_points. Precondition: is_rewound().
  Advance advance(int n_points);

  /// True while the pointer stands between two points of one series.
  bool is_inside_series() const { return point_in_series_ > 0; }
  /// Points between the pointer and the end of the stored list.
  int points_left() const;
  bool empty() const { return series_by_label_.empty(); }
  void clear();

 private:
  std::map<int, std::vector<Stored>> series_by_label_;
  std::optional<int> recording_;
  std::optional<int> pointer_label_;
  std::size_t i_series_ = 0;
  int point_in_series_ = 0;
};

}  // namespace panelcal
