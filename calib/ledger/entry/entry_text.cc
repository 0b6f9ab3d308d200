// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/entry/entry_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/digest.h"
#include "calib/base/json/strict_json.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::StrictObject;

constexpr std::array<std::string_view, 18> kKeys = {"panelcal",
                                                    "id",
                                                    "time",
                                                    "machine",
                                                    "kind",
                                                    "subject",
                                                    "verdict",
                                                    "reason",
                                                    "asked_by",
                                                    "software",
                                                    "inputs",
                                                    "temperature_degC",
                                                    "replaces",
                                                    "restores",
                                                    "result_sha256",
                                                    "result_bytes",
                                                    "parameters",
                                                    "covariance"};

std::string json_of(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// Minus zero would not come back from every reader.
std::string json_of(double number) {
  return fmt::format("{}", number + 0.0);
}

template <class Number>
std::string json_of(const std::optional<Number>& number) {
  return number ? fmt::format("{}", *number + Number{}) : "null";
}

std::string inputs_json(const std::vector<LedgerInput>& inputs) {
  std::string text;
  for (const LedgerInput& input : inputs) {
    text += fmt::format(R"({}{{"name":{},"sha256":{},"bytes":{}}})",
                        text.empty() ? "" : ",",
                        json_of(input.name),
                        json_of(input.sha256),
                        input.bytes);
  }
  return text;
}

std::string parameters_json(const std::vector<LedgerParameter>& parameters) {
  std::string text;
  for (const LedgerParameter& parameter : parameters) {
    text += fmt::format(R"({}{{"name":{},"value":{},"unit":{}}})",
                        text.empty() ? "" : ",",
                        json_of(parameter.name),
                        json_of(parameter.value),
                        json_of(parameter.unit));
  }
  return text;
}

std::string covariance_json(const std::optional<Eigen::MatrixXd>& covariance) {
  if (!covariance) return "null";
  std::string text = "[";
  for (Eigen::Index i = 0; i < covariance->rows(); ++i) {
    text += i == 0 ? "[" : ",[";
    for (Eigen::Index j = 0; j < covariance->cols(); ++j) {
      if (j > 0) text += ',';
      text += json_of((*covariance)(i, j));
    }
    text += ']';
  }
  return text + "]";
}

Diagnostic corrupt(const std::string& file, std::string what) {
  return {Code::LedgerCorrupt, {file, 0, 0}, std::move(what), ""};
}

/// Whole and not above 2^53.
Expected<std::int64_t> count(const StrictObject& object,
                             std::string_view key,
                             const std::string& file) {
  PANELCAL_TRY(const double number, object.number(key));
  if (number >= 0 && number <= 0x1p53 && number == std::floor(number)) {
    return static_cast<std::int64_t>(number);
  }
  return failure(corrupt(file, fmt::format("{} of an entry is {}", quoted(key), number)));
}

Expected<std::optional<std::int64_t>> optional_count(const StrictObject& object,
                                                     std::string_view key,
                                                     const std::string& file) {
  if (object.member(key).is_null()) return std::nullopt;
  PANELCAL_TRY(const std::int64_t number, count(object, key, file));
  return number;
}

template <class Element>
Expected<Element> known_word(const StrictObject& object,
                             std::string_view key,
                             std::optional<Element> (*find)(std::string_view),
                             const std::string& file) {
  PANELCAL_TRY(const std::string text, object.text(key));
  if (const std::optional<Element> element = find(text)) return *element;
  return failure(corrupt(file, fmt::format("{} of an entry is {}", quoted(key), quoted(text))));
}

Expected<const nlohmann::json*> array(const StrictObject& top,
                                      std::string_view key,
                                      const std::string& file) {
  const nlohmann::json& value = top.member(key);
  if (value.is_array()) return &value;
  return failure(corrupt(file, quoted(key) + " of an entry is no array"));
}

Expected<std::vector<LedgerInput>> read_inputs(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 3> kInputKeys = {"name", "sha256", "bytes"};
  PANELCAL_TRY(const nlohmann::json* elements, array(top, "inputs", file));
  std::vector<LedgerInput> inputs;
  for (const nlohmann::json& element : *elements) {
    PANELCAL_TRY(const StrictObject object,
                 StrictObject::make(element, "an input", kInputKeys, Code::LedgerCorrupt, file));
    LedgerInput& input = inputs.emplace_back();
    PANELCAL_TRY(input.name, object.text("name"));
    PANELCAL_TRY(input.sha256, object.text("sha256"));
    PANELCAL_TRY(const std::int64_t bytes, count(object, "bytes", file));
    input.bytes = static_cast<std::uint64_t>(bytes);
  }
  return inputs;
}

Expected<std::vector<LedgerParameter>> read_ledger_parameters(const StrictObject& top,
                                                              const std::string& file) {
  constexpr std::array<std::string_view, 3> kParameterKeys = {"name", "value", "unit"};
  PANELCAL_TRY(const nlohmann::json* elements, array(top, "parameters", file));
  std::vector<LedgerParameter> parameters;
  for (const nlohmann::json& element : *elements) {
    PANELCAL_TRY(
        const StrictObject object,
        StrictObject::make(element, "a parameter", kParameterKeys, Code::LedgerCorrupt, file));
    LedgerParameter& parameter = parameters.emplace_back();
    PANELCAL_TRY(parameter.name, object.text("name"));
    PANELCAL_TRY(parameter.value, object.number("value"));
    PANELCAL_TRY(parameter.unit, object.text("unit"));
  }
  return parameters;
}

Expected<void> read_numbers(const StrictObject& top,
                            const std::string& file,
                            LedgerRecord& record) {
  PANELCAL_TRY(record.parameters, read_ledger_parameters(top, file));
  if (!top.member("temperature_degC").is_null()) {
    PANELCAL_TRY(record.temperature_degC, top.number("temperature_degC"));
  }
  if (top.member("covariance").is_null()) return {};
  const std::size_t n = record.parameters.size();
  PANELCAL_TRY(const std::vector<double> cov, top.matrix("covariance", n, n));
  const auto size = static_cast<Eigen::Index>(n);
  // Rows, where Eigen keeps columns.
  record.covariance = Eigen::Map<const Eigen::MatrixXd>(cov.data(), size, size).transpose();
  return {};
}

Expected<LedgerRecord> read_ledger_record(const StrictObject& top, const std::string& file) {
  LedgerRecord record;
  PANELCAL_TRY(record.key.machine, top.text("machine"));
  PANELCAL_TRY(record.key.kind, known_word(top, "kind", &ledger_kind, file));
  PANELCAL_TRY(record.key.subject, top.text("subject"));
  PANELCAL_TRY(record.verdict, known_word(top, "verdict", &ledger_verdict, file));
  PANELCAL_TRY(record.reason, top.text("reason"));
  PANELCAL_TRY(record.asked_by, top.text("asked_by"));
  PANELCAL_TRY(record.software, top.text("software"));
  PANELCAL_TRY(record.inputs, read_inputs(top, file));
  PANELCAL_CHECK(read_numbers(top, file, record));
  PANELCAL_TRY(record.replaces, optional_count(top, "replaces", file));
  return record;
}

}  // namespace

std::string ledger_entry_json(const LedgerEntry& entry) {
  const LedgerRecord& record = entry.record;
  return fmt::format(
      R"({}{},"time":{},"machine":{},"kind":{},"subject":{},"verdict":{},"reason":{},)"
      R"("asked_by":{},"software":{},"temperature_degC":{},"inputs":[{}],"parameters":[{}],)"
      R"("covariance":{},"replaces":{},"restores":{},"result_sha256":{},"result_bytes":{}}})",
      internal::kEntryMark,
      entry.id,
      json_of(iso_8601(entry.time)),
      json_of(record.key.machine),
      json_of(word(record.key.kind)),
      json_of(record.key.subject),
      json_of(word(record.verdict)),
      json_of(record.reason),
      json_of(record.asked_by),
      json_of(record.software),
      json_of(record.temperature_degC),
      inputs_json(record.inputs),
      parameters_json(record.parameters),
      covariance_json(record.covariance),
      json_of(record.replaces),
      json_of(entry.restores),
      json_of(entry.result_sha256),
      entry.result_bytes);
}

namespace internal {

Expected<LedgerEntry> parse_entry(std::string_view content, const std::string& file) {
  const Expected<nlohmann::json> document = parse_strict_json(content, file);
  if (!document) return failure(corrupt(file, "an entry is no JSON: " + document.error().what));
  PANELCAL_TRY(const StrictObject top,
               StrictObject::make(*document, "an entry", kKeys, Code::LedgerCorrupt, file));
  LedgerEntry entry;
  PANELCAL_CHECK(top.constant("panelcal", "ledger-entry"));
  PANELCAL_TRY(entry.id, count(top, "id", file));
  PANELCAL_TRY(const std::string time, top.text("time"));
  const std::optional<std::chrono::sys_seconds> parsed = from_iso_8601(time);
  if (!parsed) return failure(corrupt(file, "the time of an entry is " + quoted(time)));
  entry.time = *parsed;
  PANELCAL_TRY(entry.record, read_ledger_record(top, file));
  PANELCAL_TRY(entry.restores, optional_count(top, "restores", file));
  PANELCAL_TRY(entry.result_sha256, top.text("result_sha256"));
  PANELCAL_TRY(const std::int64_t bytes, count(top, "result_bytes", file));
  entry.result_bytes = static_cast<std::uint64_t>(bytes);
  return entry;
}

std::string chained_hash(std::string_view previous_hash, std::string_view content) {
  std::string text(previous_hash);
  text += '\n';
  text += content;
  return sha256(text);
}

}  // namespace internal
}  // namespace panelcal
