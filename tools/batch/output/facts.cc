// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/output/facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include <fmt/format.h>

namespace panelcal::batch {
namespace {

/// Numbers of a factor with more values than that are put together to ranges.
constexpr int kMaxValues = 12;
constexpr int kRanges = 8;
/// As the view error_by_condition, but that numbers are in their order, and many of them in ranges
/// with the same number of different values each.
constexpr std::string_view kConditions = R"sql(
WITH condition AS (
  SELECT job.number AS job, factor.key AS factor, CAST(factor.value AS TEXT) AS value,
    CASE WHEN factor.value NOT GLOB '*[^-+.0-9eE]*' AND json_valid(factor.value)
      THEN CAST(factor.value AS REAL) END AS number
  FROM job, json_each(job.factors) AS factor
), kind AS (
  SELECT factor, count(DISTINCT number) AS n,
    count(DISTINCT number) > {0} AND count(*) = count(number) AS is_range
  FROM condition GROUP BY factor
), placed AS (
  SELECT job, factor, value, number, is_range,
    CASE WHEN is_range
      THEN (dense_rank() OVER (PARTITION BY factor ORDER BY number) - 1) * {1} / n END AS part
  FROM condition JOIN kind USING (factor)
)
SELECT factor,
  CASE WHEN is_range THEN printf('%.6g to %.6g', min(number), max(number)) ELSE value END,
  count(DISTINCT target.job), count(*), avg(target.status = 'found'),
  sqrt(avg(pow(error_x_um, 2) + pow(error_y_um, 2))),
  CASE WHEN count(error_x_um) > 0 THEN sqrt(avg(cov_xx_um2 + cov_yy_um2)) END
FROM placed JOIN target USING (job)
GROUP BY factor, part, CASE WHEN is_range THEN '' ELSE value END
ORDER BY factor, part, number, value LIMIT {2}
)sql";

using facts::Json;

constexpr int kBatchFactsVersion = 1;
constexpr std::size_t kErrorBins = 40;
constexpr std::size_t kExceedanceBins = 20;
constexpr int kMaxWorst = 20;
/// Of longer lists the store has the rest.
constexpr int kMaxRows = 200;
/// Errors over their sigmas are counted from here to its opposite.
constexpr double kNormalizedEnd = 5;
constexpr double kNormalizedStep = 0.25;
constexpr std::size_t kNormalizedBins = 40;

Json json_of(const StoredValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
  if (const auto* number = std::get_if<double>(&value)) return facts::number(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return {};
}

double as_number(const StoredValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  const auto* number = std::get_if<double>(&value);
  return number != nullptr ? *number : 0;
}

/// Rows of a query as objects with these keys.
Expected<Json> objects(Store& store, std::string_view sql, std::span<const char* const> keys) {
  Json out = Json::array();
  PANELCAL_CHECK(store.each(sql, [&](const StoredRow& row) {
    Json one = Json::object();
    for (std::size_t i = 0; i < keys.size(); ++i) one[keys[i]] = json_of(row[i]);
    out.push_back(std::move(one));
  }));
  return out;
}

template <std::size_t N>
Expected<Json> objects(Store& store, std::string_view sql, const char* const (&keys)[N]) {
  return objects(store, sql, std::span<const char* const>(keys));
}

/// The only row.
template <std::size_t N>
Expected<Json> object(Store& store, std::string_view sql, const char* const (&keys)[N]) {
  PANELCAL_TRY(Json rows, objects(store, sql, keys));
  return rows.empty() ? Json() : std::move(rows[0]);
}

/// A step of 1, 2 or 5 times a power of ten that is at least this.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  const std::array<double, 4> steps = {1, 2, 5, 10};
  return power * *std::ranges::find_if(steps, [&](double step) {
           return least <= power * step * (1 + 1e-9) || step == 10;
         });
}

constexpr std::string_view kWithErrors =
    " FROM target WHERE error_x_um IS NOT NULL AND cov_xx_um2 > 0 AND cov_yy_um2 > 0 "
    "AND cov_xx_um2 * cov_yy_um2 > cov_xy_um2 * cov_xy_um2";

/// Errors of targets against truth, and what their covariances predict of them.
class ErrorCounts {
 public:
  explicit ErrorCounts(double step_um) : step_um_(step_um) {}

  void add(double x_um, double y_um, double xx, double xy, double yy) {
    const auto bin = static_cast<std::size_t>(std::hypot(x_um, y_um) / step_um_);
    ++found_[std::min(bin, kErrorBins)];
    // Of two coordinates with the mean of their variances: Rayleigh's distribution.
    const double variance = (xx + yy) / 2;
    double below = 0;
    for (std::size_t i = 0; i <= kErrorBins; ++i) {
      const double end_um = static_cast<double>(i + 1) * step_um_;
      const double upto = i == kErrorBins ? 1 : -std::expm1(-end_um * end_um / (2 * variance));
      predicted_[i] += upto - below;
      below = upto;
    }
    count_normalized(x_um / std::sqrt(xx));
    count_normalized(y_um / std::sqrt(yy));
    chi_square_ +=
        (x_um * x_um * yy - 2 * x_um * y_um * xy + y_um * y_um * xx) / (xx * yy - xy * xy);
  }

  void put(Json& facts) const {
    facts["step_um"] = step_um_;
    facts["counts"] = found_;
    Json predicted = Json::array();
    for (const double n : predicted_) predicted.push_back(std::round(n * 100) / 100);
    facts["predicted"] = std::move(predicted);
    facts["normalized_step"] = kNormalizedStep;
    facts["normalized_from"] = -kNormalizedEnd;
    facts["normalized_counts"] = normalized_;
    facts["normalized_beyond"] = n_beyond_;
    facts["chi_square"] = facts::number(chi_square_);
  }

 private:
  void count_normalized(double ratio) {
    if (!(std::abs(ratio) < kNormalizedEnd)) {
      ++n_beyond_;
      return;
    }
    const auto bin = static_cast<std::size_t>((ratio + kNormalizedEnd) / kNormalizedStep);
    ++normalized_[std::min(bin, kNormalizedBins - 1)];
  }

  double step_um_;
  std::array<std::int64_t, kErrorBins + 1> found_{};  ///< the last: all beyond
  std::array<double, kErrorBins + 1> predicted_{};
  std::array<std::int64_t, kNormalizedBins> normalized_{};
  std::int64_t n_beyond_ = 0;
  double chi_square_ = 0;
};

/// Null where no truth is known.
Expected<Json> error_facts(Store& store) {
  const std::string errors(kWithErrors);
  PANELCAL_TRY(Json facts,
               object(store,
                      "SELECT count(*), sqrt(avg(error_x_um * error_x_um + error_y_um * "
                      "error_y_um)), sqrt(max(error_x_um * error_x_um + error_y_um * error_y_um)), "
                      "avg(error_x_um), avg(error_y_um), sqrt(avg(cov_xx_um2 + cov_yy_um2))" +
                          errors,
                      {"n", "rms_um", "max_um", "mean_x_um", "mean_y_um", "predicted_rms_um"}));
  if (facts["n"] == 0) return Json();
  const double scale_um =
      std::max(facts["rms_um"].get<double>(), facts["predicted_rms_um"].get<double>());
  ErrorCounts counts(round_step(std::max(3.2 * scale_um / kErrorBins, 1e-6)));
  PANELCAL_CHECK(
      store.each("SELECT error_x_um, error_y_um, cov_xx_um2, cov_xy_um2, cov_yy_um2" + errors,
                 [&](const StoredRow& row) {
                   counts.add(as_number(row[0]),
                              as_number(row[1]),
                              as_number(row[2]),
                              as_number(row[3]),
                              as_number(row[4]));
                 }));
  counts.put(facts);
  return facts;
}

/// Chances that a healthy fit has a larger chi square: evenly spread if sigmas are honest.
Expected<Json> fit_facts(Store& store) {
  PANELCAL_TRY(Json facts,
               object(store,
                      "SELECT count(*), coalesce(sum(degrees_of_freedom), 0), "
                      "coalesce(sum(chi_square), 0.0) FROM fit WHERE exceedance IS NOT NULL",
                      {"n", "degrees_of_freedom", "chi_square"}));
  std::array<std::int64_t, kExceedanceBins> counts{};
  PANELCAL_CHECK(store.each("SELECT exceedance FROM fit WHERE exceedance IS NOT NULL",
                            [&](const StoredRow& row) {
                              const double share = std::clamp(as_number(row[0]), 0.0, 1.0);
                              const auto bin = static_cast<std::size_t>(share * kExceedanceBins);
                              ++counts[std::min(bin, kExceedanceBins - 1)];
                            }));
  facts["exceedance_counts"] = counts;
  return facts;
}

Expected<Json> hole_facts(Store& store) {
  return object(store,
                "SELECT count(*), coalesce(sum(n_holes), 0), max(max_shift_um), max(max_sigma_um), "
                "sqrt(sum(n_holes * error_rms_um * error_rms_um) / "
                "sum(CASE WHEN error_rms_um IS NULL THEN 0 ELSE n_holes END)), max(error_max_um), "
                "avg(mean_normalized_square) FROM hole_summary",
                {"n_jobs",
                 "n_holes",
                 "max_shift_um",
                 "max_sigma_um",
                 "error_rms_um",
                 "error_max_um",
                 "mean_normalized_square"});
}

Expected<Json> worst_target_facts(Store& store) {
  return objects(
      store,
      fmt::format(
          "SELECT job.number, job.id, seq, line, image, status, target.state, reason, "
          "sqrt(error_x_um * error_x_um + error_y_um * error_y_um), "
          "sqrt(residual_x_um * residual_x_um + residual_y_um * residual_y_um), "
          "sqrt(cov_xx_um2 + cov_yy_um2) "
          "FROM target JOIN job ON job.number = target.job "
          "ORDER BY coalesce(error_x_um * error_x_um + error_y_um * error_y_um, "
          "residual_x_um * residual_x_um + residual_y_um * residual_y_um) DESC, job.number, seq "
          "LIMIT {}",
          kMaxWorst),
      {"job",
       "id",
       "seq",
       "line",
       "image",
       "status",
       "state",
       "reason",
       "error_um",
       "residual_um",
       "sigma_um"});
}

Expected<Json> target_facts_of(Store& store) {
  PANELCAL_TRY(Json facts,
               object(store,
                      "SELECT count(*), coalesce(sum(status = 'found'), 0) FROM target",
                      {"n", "n_found"}));
  PANELCAL_TRY(facts["by_status"],
               objects(store,
                       "SELECT status, count(*) FROM target GROUP BY status ORDER BY 2 DESC, 1",
                       {"status", "n"}));
  return facts;
}

Expected<Json> picture_quality_facts(Store& store) {
  return object(store,
                "SELECT count(*), avg(blur_px), max(blur_px), min(abs(contrast)), avg(noise), "
                "min(score), avg(sigma_px) FROM picture_quality",
                {"n",
                 "mean_blur_px",
                 "max_blur_px",
                 "min_contrast",
                 "mean_noise",
                 "min_score",
                 "mean_sigma_px"});
}

Expected<Json> job_counts(Store& store, std::int64_t n_jobs) {
  PANELCAL_TRY(Json facts,
               object(store,
                      "SELECT coalesce(sum(state = 'drilled'), 0), coalesce(sum(state = 'held'), "
                      "0), coalesce(sum(state = 'failed'), 0), coalesce(max(exit_code), 0), "
                      "count(*), coalesce(sum(n_pictures), 0) FROM job",
                      {"drilled", "held", "failed", "exit_code", "done", "pictures"}));
  facts["missing"] = n_jobs - facts["done"].get<std::int64_t>();
  return facts;
}

}  // namespace

Expected<Json> batch_facts(Store& store) {
  PANELCAL_TRY(const StoredBatch batch, store.batch());
  Json facts = facts::envelope("batch", kBatchFactsVersion);
  facts["manifest"] = batch.manifest;
  facts["manifest_sha256"] = batch.manifest_sha256;
  facts["clock"] = batch.clock;
  facts["n_jobs"] = batch.n_jobs;
  PANELCAL_TRY(facts["jobs"], job_counts(store, batch.n_jobs));
  PANELCAL_TRY(facts["targets"], target_facts_of(store));
  PANELCAL_TRY(facts["error"], error_facts(store));
  PANELCAL_TRY(facts["fits"], fit_facts(store));
  PANELCAL_TRY(facts["holes"], hole_facts(store));
  PANELCAL_TRY(facts["pictures"], picture_quality_facts(store));
  PANELCAL_TRY(facts["refusals"],
               objects(store,
                       "SELECT refusals.state, refusals.code, n_jobs, job.id, example "
                       "FROM refusals JOIN job ON job.number = first_job",
                       {"state", "code", "n_jobs", "example_id", "example"}));
  PANELCAL_TRY(facts["not_drilled"],
               objects(store,
                       fmt::format("SELECT number, id, state, code, message FROM job WHERE state "
                                   "<> 'drilled' ORDER BY number LIMIT {}",
                                   kMaxRows),
                       {"job", "id", "state", "code", "message"}));
  PANELCAL_TRY(facts["conditions"],
               objects(store,
                       fmt::format(kConditions, kMaxValues, kRanges, kMaxRows),
                       {"factor",
                        "value",
                        "n_jobs",
                        "n_targets",
                        "found_rate",
                        "error_rms_um",
                        "predicted_rms_um"}));
  PANELCAL_TRY(facts["drift"],
               objects(store,
                       fmt::format("SELECT * FROM drift LIMIT {}", kMaxRows),
                       {"machine",
                        "day",
                        "n_fits",
                        "shift_x_mm",
                        "shift_y_mm",
                        "rotation_rad",
                        "stretch_x_ppm",
                        "stretch_y_ppm",
                        "chi_square_ratio"}));
  PANELCAL_TRY(facts["worst"], worst_target_facts(store));
  for (Json& one : facts["worst"]) one["crop"] = nullptr;
  PANELCAL_TRY(facts["sessions"],
               objects(store,
                       "SELECT started, threads, n_jobs, n_pictures, seconds FROM session "
                       "ORDER BY number",
                       {"started", "threads", "n_jobs", "n_pictures", "seconds"}));
  return facts;
}

}  // namespace panelcal::batch
