// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/methods.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <time.h>

namespace panelcal::bench {
namespace {

constexpr double kPi = std::numbers::pi;
/// As panelcal's default: seen sizes off by more are other targets.
constexpr double kSizeTolerance = 0.04;

/// The picture in 8 bit; dark marks turned bright, as some methods know only these.
cv::Mat bright_8bit(const Question& q) {
  cv::Mat mat(q.image.height(), q.image.width(), CV_8U);
  for (int y = 0; y < q.image.height(); ++y) {
    for (int x = 0; x < q.image.width(); ++x) {
      const auto v = static_cast<unsigned char>(q.image.at(x, y));
      mat.at<unsigned char>(y, x) =
          q.mark.polarity == Polarity::Bright ? v : static_cast<unsigned char>(255 - v);
    }
  }
  return mat;
}

/// Sigmas of smoothing that were best of 0, 1, 1.5, 2, 3, 4 px for the method, by noise: these
/// methods have no model of it.
struct Smoothing {
  double clean_px = 0;    ///< noise below 3 % of the contrast
  double typical_px = 0;  ///< below 10 %
  double hard_px = 2;

  double at(const Condition& condition) const {
    const double ratio = condition.noise / condition.contrast;
    if (ratio < 0.03) return clean_px;
    return ratio < 0.1 ? typical_px : hard_px;
  }
};
constexpr Smoothing kForLevels{0, 0, 2};
constexpr Smoothing kForEdges{1.5, 1, 2};
constexpr Smoothing kForCircles{1, 1, 2};

cv::Mat smoothed(const cv::Mat& mat, double sigma) {
  if (sigma == 0) return mat;
  cv::Mat out;
  cv::GaussianBlur(mat, out, cv::Size(), sigma);
  return out;
}

/// The strongest answer of a Sobel filter to the mark's edge.
double edge_strength(const Condition& condition, const Smoothing& smoothing) {
  const double s = std::hypot(condition.blur_px, std::sqrt(1.0 / 12), smoothing.at(condition));
  return 4 * condition.contrast * std::erf(1 / (s * std::numbers::sqrt2));
}

Answer found_at(double x, double y) {
  Answer answer;
  answer.is_found = true;
  answer.center_px = {x, y};
  return answer;
}

Answer simple_blob(const cv::Mat& mat, const Question& q, double smoothing_px) {
  const double r = q.mark.radius_px;
  cv::SimpleBlobDetector::Params p;
  p.filterByColor = true;
  p.blobColor = 255;
  p.filterByArea = true;
  p.minArea = static_cast<float>(kPi * r * r * 0.8);
  p.maxArea = static_cast<float>(kPi * r * r * 1.2);
  p.filterByCircularity = true;
  p.minCircularity = 0.75F;
  p.filterByInertia = true;
  p.minInertiaRatio = 0.8F;
  p.filterByConvexity = true;
  p.minConvexity = 0.9F;
  // The levels between which the rim lies are known: no thresholds are wasted on others.
  p.minThreshold = static_cast<float>(127.5 - 0.4 * q.condition.contrast);
  p.maxThreshold = static_cast<float>(127.5 + 0.4 * q.condition.contrast);
  p.thresholdStep = static_cast<float>(std::max(2.0, 0.8 * q.condition.contrast / 11));
  p.minRepeatability = 2;
  p.minDistBetweenBlobs = static_cast<float>(r);
  std::vector<cv::KeyPoint> points;
  cv::SimpleBlobDetector::create(p)->detect(smoothed(mat, smoothing_px), points);
  const cv::KeyPoint* best = nullptr;
  const auto off = [&](const cv::KeyPoint& k) { return std::abs(0.5 * k.size / r - 1); };
  for (const cv::KeyPoint& k : points) {
    if (off(k) <= kSizeTolerance && (!best || off(k) < off(*best))) best = &k;
  }
  return best ? found_at(best->pt.x, best->pt.y) : Answer{};
}

Answer best_blob(const cv::Mat& mat, const Question& q) {
  return simple_blob(mat, q, kForLevels.at(q.condition));
}

/// Less accurate on noise, but much faster: there are fewer contours.
Answer smoothed_blob(const cv::Mat& mat, const Question& q) {
  return simple_blob(mat, q, kForCircles.at(q.condition));
}

Answer hough(const cv::Mat& mat, const Question& q) {
  const double r = q.mark.radius_px;
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(smoothed(mat, kForCircles.at(q.condition)),
                   circles,
                   cv::HOUGH_GRADIENT,
                   1,
                   r,
                   0.5 * edge_strength(q.condition, kForCircles),
                   0.4 * r,
                   static_cast<int>(std::floor(r * (1 - kSizeTolerance))),
                   static_cast<int>(std::ceil(r * (1 + kSizeTolerance))));
  // Strongest first.
  return circles.empty() ? Answer{} : found_at(circles[0][0], circles[0][1]);
}

/// Part of the rim below which a contour's ellipse is not to be trusted; pixels of a contour are up
/// to sqrt(2) apart.
constexpr double kLeastRim = 0.48;

/// The contour whose ellipse is nearest to the mark's size and round; nothing if none is near.
Answer best_ellipse(const std::vector<std::vector<cv::Point>>& contours, double radius_px) {
  double best_off = kSizeTolerance;
  Answer answer;
  for (const auto& contour : contours) {
    if (static_cast<double>(contour.size()) < kLeastRim * 2 * kPi * radius_px) continue;
    const cv::RotatedRect e = cv::fitEllipse(contour);
    const double off = std::abs(std::sqrt(e.size.width * e.size.height) / (2 * radius_px) - 1);
    const double ratio =
        std::min(e.size.width, e.size.height) / std::max(e.size.width, e.size.height);
    if (off > best_off || ratio < 1 - 2 * kSizeTolerance) continue;
    best_off = off;
    answer = found_at(e.center.x, e.center.y);
  }
  return answer;
}

Answer otsu_ellipse(const cv::Mat& mat, const Question& q) {
  cv::Mat binary;
  cv::threshold(smoothed(mat, kForLevels.at(q.condition)),
                binary,
                0,
                255,
                cv::THRESH_BINARY | cv::THRESH_OTSU);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(binary, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  return best_ellipse(contours, q.mark.radius_px);
}

double area_of(const Mark& mark) {
  const double side_px = 2 * mark.radius_px;
  if (mark.shape != Shape::Cross) return side_px * side_px;
  return (2 * side_px - mark.bar_width_px) * mark.bar_width_px;
}

/// For squares, diamonds and crosses: centroid of the outline whose area is nearest to the mark's.
Answer otsu_moments(const cv::Mat& mat, const Question& q) {
  cv::Mat binary;
  cv::threshold(smoothed(mat, kForLevels.at(q.condition)),
                binary,
                0,
                255,
                cv::THRESH_BINARY | cv::THRESH_OTSU);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(binary, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  Answer answer;
  double best_off = 2 * kSizeTolerance;
  for (const auto& contour : contours) {
    const cv::Moments m = cv::moments(contour);
    // A contour runs through the middles of the outermost pixels: half a pixel inside.
    const double area = m.m00 + 0.5 * static_cast<double>(contour.size());
    const double off = std::abs(area / area_of(q.mark) - 1);
    if (off > best_off) continue;
    best_off = off;
    answer = found_at(m.m10 / m.m00, m.m01 / m.m00);
  }
  return answer;
}

Answer canny_ellipse(const cv::Mat& mat, const Question& q) {
  cv::Mat edges;
  const double high = 0.5 * edge_strength(q.condition, kForEdges);
  cv::Canny(smoothed(mat, kForEdges.at(q.condition)), edges, 0.5 * high, high, 3, true);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(edges, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  return best_ellipse(contours, q.mark.radius_px);
}

double parabola_peak(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
}

/// The mark with a margin, without noise, its centre on the middle pixel.
cv::Mat ideal_mark(const Question& q) {
  constexpr int kMarginPx = 8;
  const bool has_corners = q.mark.shape == Shape::Square || q.mark.shape == Shape::Diamond;
  const double reach_px = q.mark.radius_px * (has_corners ? std::numbers::sqrt2 : 1.0);
  const int half = static_cast<int>(std::ceil(reach_px)) + kMarginPx;
  const int side = 2 * half + 1;
  const Camera camera = make_camera(side, side, q.condition.blur_px, 0);
  Scene scene;
  scene.background = background_level(q.condition, Polarity::Bright);
  scene.features =
      features_of(q.mark, camera, {half, half}, mark_level(q.condition, Polarity::Bright));
  Random unused(1);
  const Image image = render(scene, camera, unused);
  return bright_8bit({image, make_mark(Shape::Disc, 1), q.condition, {}});
}

class TemplateMatcher {
 public:
  /// Drawing the template is preparation; it is kept as long as the question stays the same.
  void prepare(const Question& q) {
    const bool is_same = q.mark.shape == shape_ && q.mark.radius_px == radius_px_ &&
                         q.mark.angle_deg == angle_deg_ && q.condition.name == condition_;
    if (is_same) return;
    template_ = ideal_mark(q);
    shape_ = q.mark.shape;
    radius_px_ = q.mark.radius_px;
    angle_deg_ = q.mark.angle_deg;
    condition_ = q.condition.name;
  }

  Answer find(const cv::Mat& mat) const {
    constexpr double kMinCorrelation = 0.7;
    if (mat.cols < template_.cols || mat.rows < template_.rows) return {};
    cv::Mat score;
    cv::matchTemplate(mat, template_, score, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
    const bool is_inside = at.x > 0 && at.y > 0 && at.x + 1 < score.cols && at.y + 1 < score.rows;
    if (best < kMinCorrelation || !is_inside) return {};
    const auto s = [&](int dx, int dy) -> double { return score.at<float>(at.y + dy, at.x + dx); };
    const int half = template_.cols / 2;
    return found_at(at.x + half + parabola_peak(s(-1, 0), s(0, 0), s(1, 0)),
                    at.y + half + parabola_peak(s(0, -1), s(0, 0), s(0, 1)));
  }

 private:
  cv::Mat template_;
  Shape shape_ = Shape::Disc;
  double radius_px_ = 0;
  double angle_deg_ = 0;
  std::string condition_;
};

/// Centroid of what is brighter than the background by a quarter of the contrast, in a window told.
Answer grey_centroid(const cv::Mat& mat, const Question& q) {
  const int half = static_cast<int>(std::lround(q.mark.radius_px)) + 8;
  const cv::Rect box(static_cast<int>(std::lround(q.window_px.x())) - half,
                     static_cast<int>(std::lround(q.window_px.y())) - half,
                     2 * half + 1,
                     2 * half + 1);
  const cv::Rect inside = box & cv::Rect(0, 0, mat.cols, mat.rows);
  if (inside.area() == 0) return {};
  cv::Mat weights;
  smoothed(mat(inside), kForCircles.at(q.condition)).convertTo(weights, CV_32F);
  const double background = 127.5 - 0.5 * q.condition.contrast;
  weights -= background;
  cv::threshold(weights, weights, 0.25 * q.condition.contrast, 0, cv::THRESH_TOZERO);
  const cv::Moments m = cv::moments(weights);
  if (m.m00 < 0.5 * q.condition.contrast * kPi * q.mark.radius_px * q.mark.radius_px) return {};
  return found_at(inside.x + m.m10 / m.m00, inside.y + m.m01 / m.m00);
}

/// A method on OpenCV's own picture: handing it over is not timed.
Method on_mat(std::string name, bool searches, Answer (*work)(const cv::Mat&, const Question&)) {
  return {std::move(name), searches, [work](const Question& q) {
            const cv::Mat mat = bright_8bit(q);
            const double start_s = thread_cpu_s();
            Answer answer = work(mat, q);
            answer.ms = 1e3 * (thread_cpu_s() - start_s);
            return answer;
          }};
}

Method template_method() {
  return {
      "matchTemplate + parabola", true, [matcher = TemplateMatcher()](const Question& q) mutable {
        const cv::Mat mat = bright_8bit(q);
        matcher.prepare(q);
        const double start_s = thread_cpu_s();
        Answer answer = matcher.find(mat);
        answer.ms = 1e3 * (thread_cpu_s() - start_s);
        return answer;
      }};
}

}  // namespace

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

Answer locate_answer(const Question& q, const LocateOptions& options) {
  const Target target = target_of(q.mark);
  const double start_s = thread_cpu_s();
  const Detection detection = locate(q.image, target, nullptr, options);
  Answer answer;
  answer.ms = 1e3 * (thread_cpu_s() - start_s);
  answer.is_found = detection.status == DetectionStatus::Found;
  answer.reason = std::string(name(detection.status)) + ": " + detection.reason;
  if (!answer.is_found) return answer;
  answer.center_px = detection.best->center.position.in_px();
  answer.cov = detection.best->center.cov;
  return answer;
}

std::vector<Method> methods_for(Shape shape) {
  std::vector<Method> methods = {
      {"panelcal locate", true, [](const Question& q) { return locate_answer(q); }}};
  const bool is_round = shape == Shape::Disc || shape == Shape::Hole || shape == Shape::Ring;
  if (is_round) {
    if (shape != Shape::Ring) {
      methods.push_back(on_mat("SimpleBlobDetector", true, best_blob));
      methods.push_back(on_mat("SimpleBlobDetector, smoothed", true, smoothed_blob));
    }
    methods.push_back(on_mat("HoughCircles", true, hough));
    methods.push_back(on_mat("Otsu + fitEllipse", true, otsu_ellipse));
    methods.push_back(on_mat("Canny + fitEllipse", true, canny_ellipse));
  }
  if (!is_round) methods.push_back(on_mat("Otsu + contour moments", true, otsu_moments));
  methods.push_back(template_method());
  methods.push_back(on_mat("grey centroid (window known)", false, grey_centroid));
  return methods;
}

}  // namespace panelcal::bench
