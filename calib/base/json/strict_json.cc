// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/strict_json.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using nlohmann::json;

Place place_of(std::string_view text, std::size_t offset, const std::string& file) {
  const std::string_view before = text.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t last_break = before.rfind('\n');
  const std::size_t column =
      last_break == std::string_view::npos ? before.size() + 1 : before.size() - last_break;
  return {file, static_cast<int>(line), static_cast<int>(column)};
}

/// The offset of the bracket that nests too deep. Counted before parsing, since a parser's stack
/// and a document's destructor are not ours to bound.
std::optional<std::size_t> too_deep_at(std::string_view text) {
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth) return i;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return std::nullopt;
}

/// The parser's own words without its prefix, fit for a terminal whatever the file holds.
std::string words_of(const json::exception& error) {
  std::string_view words = error.what();
  if (const std::size_t bracket = words.find("] "); bracket != std::string_view::npos) {
    words.remove_prefix(bracket + 2);
  }
  if (words.starts_with("parse error at ")) {
    if (const std::size_t colon = words.find(": "); colon != std::string_view::npos) {
      words.remove_prefix(colon + 2);
    }
  }
  std::string clean(words.substr(0, 160));
  for (char& c : clean) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return clean;
}

/// Notes the first key that an object has twice; the parser itself would keep the last value.
///
/// Told event by event, not by the parser's callback: with one, the parser looks through all
/// elements of an array at the end of each object in it.
class DuplicateKeys : public nlohmann::json_sax<json> {
 public:
  bool start_object(std::size_t) override {
    open_.emplace_back();
    return true;
  }
  bool key(std::string& key) override {
    if (open_.back().insert(key).second) return true;
    found_ = key;
    return false;
  }
  bool end_object() override {
    open_.pop_back();
    return true;
  }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(json::number_integer_t) override { return true; }
  bool number_unsigned(json::number_unsigned_t) override { return true; }
  bool number_float(json::number_float_t, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(json::binary_t&) override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override {
    return false;
  }

  const std::optional<std::string>& found() const { return found_; }

 private:
  std::vector<std::set<std::string>> open_;
  std::optional<std::string> found_;
};

}  // namespace

Expected<json> parse_strict_json(std::string_view text, const std::string& file) {
  if (const std::optional<std::size_t> offset = too_deep_at(text)) {
    return failure({Code::JsonSyntax,
                    place_of(text, *offset, file),
                    "nested too deep",
                    fmt::format("at most {} levels", kMaxJsonDepth)});
  }
  DuplicateKeys duplicates;
  try {
    json document = json::parse(text.begin(), text.end());
    json::sax_parse(text.begin(), text.end(), &duplicates);
    if (!duplicates.found()) return document;
  } catch (const json::parse_error& error) {
    // The parser counts the bytes it took, of which the last is the one that does not fit.
    const std::size_t offset = std::min(text.size(), error.byte > 0 ? error.byte - 1 : 0);
    return failure({Code::JsonSyntax, place_of(text, offset, file), words_of(error), ""});
  } catch (const json::exception& error) {
    return failure({Code::JsonSyntax, {file, 0, 0}, words_of(error), ""});
  }
  return failure({Code::JsonSyntax,
                  {file, 0, 0},
                  "the key " + quoted(*duplicates.found()) + " appears twice",
                  "each key once"});
}

}  // namespace panelcal::internal
