// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace panelcal::internal {

/// The size to which pictures are padded so that lags up to max_lag do not run around the corner.
inline cv::Size padded_size(const cv::Mat& mat, int max_lag) {
  return {cv::getOptimalDFTSize(mat.cols + max_lag), cv::getOptimalDFTSize(mat.rows + max_lag)};
}

/// The spectrum of a float picture padded with zeros.
inline cv::Mat spectrum_of(const cv::Mat& mat, const cv::Size& padded) {
  cv::Mat big = cv::Mat::zeros(padded, CV_32F);
  mat.copyTo(big(cv::Rect(0, 0, mat.cols, mat.rows)));
  cv::Mat spectrum;
  cv::dft(big, spectrum, 0, mat.rows);
  return spectrum;
}

/// Sum over u of a(u) b(u + lag); lag is taken around the corner, see at_lag.
inline cv::Mat correlation_of(const cv::Mat& a_spectrum, const cv::Mat& b_spectrum) {
  cv::Mat product;
  cv::mulSpectrums(b_spectrum, a_spectrum, product, 0, true);
  cv::Mat correlation;
  cv::dft(product, correlation, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return correlation;
}

inline float at_lag(const cv::Mat& correlation, int dx, int dy) {
  return correlation.at<float>((dy + correlation.rows) % correlation.rows,
                               (dx + correlation.cols) % correlation.cols);
}

}  // namespace panelcal::internal
