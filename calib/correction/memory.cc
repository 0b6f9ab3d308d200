// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/memory.h"

namespace panelcal {

void CorrectionMemory::start_recording(int label) {
  series_by_label_[label].clear();
  recording_ = label;
  // A pointer into the content just replaced points at nothing.
  if (pointer_label_ != label) return;
  pointer_label_.reset();
  i_series_ = 0;
  point_in_series_ = 0;
}

void CorrectionMemory::stop_recording() {
  recording_.reset();
}

void CorrectionMemory::store(Stored series) {
  if (!recording_ || series.n_points <= 0) return;
  series_by_label_[*recording_].push_back(series);
}

bool CorrectionMemory::rewind(int label) {
  if (!series_by_label_.contains(label)) return false;
  pointer_label_ = label;
  i_series_ = 0;
  point_in_series_ = 0;
  return true;
}

CorrectionMemory::Advance CorrectionMemory::advance(int n_points) {
  Advance out;
  if (!pointer_label_ || n_points > points_left()) {
    out.beyond_end = true;
    return out;
  }
  const std::vector<Stored>& series = series_by_label_.at(*pointer_label_);
  while (n_points > 0) {
    const int left_in_series = series[i_series_].n_points - point_in_series_;
    if (n_points < left_in_series) {
      point_in_series_ += n_points;
      break;
    }
    n_points -= left_in_series;
    out.passed.push_back(series[i_series_].series);
    ++i_series_;
    point_in_series_ = 0;
  }
  return out;
}

int CorrectionMemory::points_left() const {
  if (!pointer_label_) return 0;
  const std::vector<Stored>& series = series_by_label_.at(*pointer_label_);
  int left = -point_in_series_;
  for (std::size_t i = i_series_; i < series.size(); ++i) left += series[i].n_points;
  return left;
}

void CorrectionMemory::clear() {
  *this = CorrectionMemory();
}

}  // namespace panelcal
