// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calib/base/json/strict_json.h"
#include "calib/base/statistics/linear_algebra.h"
#include "calib/ledger/entry/entry_text.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Rounding that a covariance may have suffered on its way through other programs.
constexpr double kCovarianceRounding = 1e-9;
constexpr std::uint64_t kMaxExactInteger = std::uint64_t{1} << 53;
constexpr std::size_t kSha256Digits = 64;

Diagnostic invalid_entry(const std::string& file, std::string what, std::string expected) {
  return {Code::LedgerEntryInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

bool is_utf8(const std::string& text) {
  try {
    static_cast<void>(nlohmann::json(text).dump());
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// A text on one line that tells something from other things.
Expected<void> check_name(const std::string& text,
                          std::string_view field,
                          const std::string& file) {
  const bool good = !text.empty() && text.size() <= kMaxLedgerNameBytes &&
                    std::none_of(text.begin(), text.end(), is_control) && is_utf8(text);
  if (good) return {};
  return failure(
      invalid_entry(file,
                    fmt::format("{} is {}", field, quoted(text)),
                    fmt::format("1 to {} bytes of UTF-8 on one line", kMaxLedgerNameBytes)));
}

/// Words for people; a NUL would end them early in other programs.
Expected<void> check_words(const std::string& text,
                           std::string_view field,
                           bool needed,
                           const std::string& file) {
  const bool good = (!needed || !text.empty()) && text.size() <= kMaxLedgerTextBytes &&
                    text.find('\0') == std::string::npos && is_utf8(text);
  if (good) return {};
  return failure(invalid_entry(
      file,
      fmt::format("{} is {}", field, quoted(text)),
      fmt::format("{} to {} bytes of UTF-8 without NUL", needed ? 1 : 0, kMaxLedgerTextBytes)));
}

Expected<void> check_inputs(const std::vector<LedgerInput>& inputs, const std::string& file) {
  if (inputs.size() > kMaxLedgerInputs) {
    return failure(invalid_entry(file,
                                 fmt::format("there are {} inputs", inputs.size()),
                                 fmt::format("at most {}", kMaxLedgerInputs)));
  }
  for (const LedgerInput& input : inputs) {
    PANELCAL_CHECK(check_words(input.name, "an input's name", true, file));
    const bool is_digest = input.sha256.size() == kSha256Digits &&
                           input.sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!is_digest) {
      return failure(invalid_entry(
          file,
          fmt::format("sha256 of the input {} is {}", quoted(input.name), quoted(input.sha256)),
          fmt::format("{} hexadecimal digits in small letters", kSha256Digits)));
    }
    if (input.bytes > kMaxExactInteger) {
      return failure(
          invalid_entry(file, fmt::format("an input has {} bytes", input.bytes), "below 2^53"));
    }
  }
  return {};
}

Expected<void> check_parameters(const std::vector<LedgerParameter>& parameters,
                                const std::string& file) {
  if (parameters.size() > kMaxLedgerParameters) {
    return failure(invalid_entry(
        file,
        fmt::format("there are {} parameters", parameters.size()),
        fmt::format("at most {}; more belong into the result", kMaxLedgerParameters)));
  }
  std::set<std::string_view> names;
  for (const LedgerParameter& parameter : parameters) {
    PANELCAL_CHECK(check_name(parameter.name, "a parameter's name", file));
    PANELCAL_CHECK(check_name(parameter.unit, "the unit of " + quoted(parameter.name), file));
    if (!std::isfinite(parameter.value)) {
      return failure(invalid_entry(
          file, fmt::format("{} is {}", quoted(parameter.name), parameter.value), "finite"));
    }
    if (!names.insert(parameter.name).second) {
      return failure(invalid_entry(
          file, "the parameter " + quoted(parameter.name) + " is there twice", "once"));
    }
  }
  return {};
}

/// Judged on correlations, since variances of different units differ by many orders of magnitude.
bool is_entry_covariance(const Eigen::MatrixXd& cov) {
  if (!cov.allFinite() || (cov.size() > 0 && !(cov.diagonal().minCoeff() >= 0))) return false;
  const Eigen::Index n = cov.rows();
  const Eigen::VectorXd sigma = cov.diagonal().cwiseSqrt();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = sigma(i) * sigma(j);
      if (!(std::abs(cov(i, j) - cov(j, i)) <= kCovarianceRounding * size)) return false;
      if (size == 0 && cov(i, j) != 0) return false;
      if (size > 0) correlation(i, j) = correlation(j, i) = cov(i, j) / size;
    }
  }
  if (!correlation.allFinite()) return false;
  if (n == 0) return true;
  const internal::Eigensystem eigen = internal::eigenvalues(correlation);
  return eigen.has_converged &&
         eigen.values.minCoeff() >= -kCovarianceRounding * static_cast<double>(n);
}

Expected<void> check_covariance(const LedgerRecord& record, const std::string& file) {
  if (!record.covariance) return {};
  const Eigen::MatrixXd& cov = *record.covariance;
  const auto n = static_cast<Eigen::Index>(record.parameters.size());
  if (cov.rows() != n || cov.cols() != n) {
    return failure(invalid_entry(file,
                                 fmt::format("the covariance is {} x {}", cov.rows(), cov.cols()),
                                 fmt::format("{0} x {0}, as there are parameters", n)));
  }
  if (is_entry_covariance(cov)) return {};
  return failure(invalid_entry(file,
                               "the covariance is not positive semidefinite",
                               "finite, symmetric and positive semidefinite"));
}

}  // namespace

Expected<void> check_record(const LedgerRecord& record, const std::string& file) {
  PANELCAL_CHECK(check_name(record.key.machine, "machine", file));
  PANELCAL_CHECK(check_name(record.key.subject, "subject", file));
  PANELCAL_CHECK(check_name(record.asked_by, "asked_by", file));
  PANELCAL_CHECK(check_name(record.software, "software", file));
  const bool needs_reason =
      record.verdict == LedgerVerdict::Refused || record.verdict == LedgerVerdict::RolledBack;
  PANELCAL_CHECK(check_words(record.reason, "reason", needs_reason, file));
  if (record.temperature_degC && !std::isfinite(*record.temperature_degC)) {
    return failure(invalid_entry(
        file, fmt::format("temperature_degC is {}", *record.temperature_degC), "finite or absent"));
  }
  PANELCAL_CHECK(check_inputs(record.inputs, file));
  PANELCAL_CHECK(check_parameters(record.parameters, file));
  return check_covariance(record, file);
}

Expected<void> check_draft(const LedgerDraft& draft, const std::string& file) {
  PANELCAL_CHECK(check_record(draft.record, file));
  if (draft.record.verdict == LedgerVerdict::RolledBack) {
    return failure(
        invalid_entry(file, "the verdict is rolled-back", "roll_back to be called for that"));
  }
  const bool installs = draft.record.verdict == LedgerVerdict::Installed;
  if (draft.record.replaces && !installs) {
    return failure(invalid_entry(file, "replaces is given", "an installed entry to have it"));
  }
  if (draft.result.size() > kMaxLedgerResultBytes) {
    return failure(invalid_entry(file,
                                 fmt::format("the result has {} bytes", draft.result.size()),
                                 fmt::format("at most {}", kMaxLedgerResultBytes)));
  }
  const Expected<nlohmann::json> result = parse_strict_json(draft.result, "result");
  if (!result) {
    return failure(invalid_entry(file, "the result is no JSON: " + result.error().text(), "JSON"));
  }
  return {};
}

}  // namespace panelcal::internal
