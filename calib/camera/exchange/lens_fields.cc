// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/exchange/lens_fields.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kLensBlanks = " \t\r\n";
constexpr std::size_t kMaxLensValues = 10'000;

/// Walks over a text and knows where it is.
class LensScanner {
 public:
  LensScanner(std::string_view text, const std::string& file) : text_(text), file_(file) {
    constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
    if (text_.starts_with(kUtf8Mark)) at_ = kUtf8Mark.size();
  }

  bool is_at_end() const { return at_ >= text_.size(); }
  char next() const { return is_at_end() ? '\0' : text_[at_]; }
  std::string_view rest() const { return text_.substr(at_); }
  Place place() const { return {file_, line_, column_}; }
  void advance(std::size_t n = 1) {
    for (; n > 0 && !is_at_end(); --n, ++at_) {
      const bool is_break = text_[at_] == '\n';
      line_ += is_break ? 1 : 0;
      column_ = is_break ? 1 : column_ + 1;
    }
  }
  /// Passes over blanks and comments, to another line too.
  void skip_blanks() {
    while (!is_at_end()) {
      if (next() == '#') {
        advance(std::min(rest().find('\n'), rest().size()));
      } else if (kLensBlanks.find(next()) != std::string_view::npos) {
        advance();
      } else {
        return;
      }
    }
  }
  Diagnostic unexpected(std::string expected) const {
    const std::string_view line = rest().substr(0, rest().find('\n'));
    return {Code::MeasurementFile,
            place(),
            line.empty() ? std::string("there is nothing") : quoted(line),
            std::move(expected)};
  }

 private:
  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 1;
  int column_ = 1;
};

std::string_view trimmed_lens(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(kLensBlanks), text.size());
  return text.substr(begin, text.find_last_not_of(kLensBlanks) + 1 - begin);
}

std::string without_quotes(std::string_view text) {
  const bool is_quoted = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                         text.back() == text.front();
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

/// The text up to one of the ends, which is not passed; quotes and comments within it are.
std::string scalar_until(LensScanner& scanner, std::string_view ends) {
  std::string out;
  while (!scanner.is_at_end() && ends.find(scanner.next()) == std::string_view::npos) {
    const char c = scanner.next();
    const bool is_comment =
        c == '#' && (out.empty() || kLensBlanks.find(out.back()) != std::string_view::npos);
    if (is_comment) {
      scanner.advance(std::min(scanner.rest().find('\n'), scanner.rest().size()));
      continue;
    }
    if (c == '"' || c == '\'') {
      const std::string_view rest = scanner.rest();
      const std::size_t end = std::min(rest.find(c, 1), rest.size() - 1);
      out += rest.substr(0, end + 1);
      scanner.advance(end + 1);
      continue;
    }
    out += c;
    scanner.advance();
  }
  return std::string(trimmed_lens(out));
}

Expected<void> add_field(LensFields& fields, std::string key, LensField field) {
  Place place = field.place;
  if (fields.size() == kMaxLensValues) {
    return failure(
        {Code::MeasurementFile, place, "too many keys", fmt::format("at most {}", kMaxLensValues)});
  }
  const auto [at, is_new] = fields.emplace(std::move(key), std::move(field));
  if (is_new) return {};
  return failure(
      {Code::MeasurementFile, place, fmt::format("{} again", quoted(at->first)), "each key once"});
}

/// [1, 2, 3], over several lines perhaps.
Expected<std::vector<std::string>> bracketed(LensScanner& scanner) {
  std::vector<std::string> out;
  scanner.advance();
  while (true) {
    scanner.skip_blanks();
    if (scanner.next() == ']') break;
    if (scanner.is_at_end() || scanner.next() == '[' || scanner.next() == '{' ||
        out.size() == kMaxLensValues) {
      return failure(scanner.unexpected("a list of numbers with \"]\" behind it"));
    }
    out.push_back(without_quotes(scalar_until(scanner, ",]")));
    scanner.skip_blanks();
    if (scanner.next() == ',') scanner.advance();
  }
  scanner.advance();
  return out;
}

class YamlReader {
 public:
  YamlReader(std::string_view text, const std::string& file) : scanner_(text, file) {}

  Expected<LensFields> read() {
    while (true) {
      scanner_.skip_blanks();
      if (scanner_.is_at_end()) return std::move(fields_);
      const std::string_view rest = scanner_.rest();
      const bool is_mark =
          scanner_.place().column == 1 &&
          (rest.starts_with("---") || rest.starts_with("...") || rest.starts_with('%'));
      if (is_mark) {
        scanner_.advance(std::min(rest.find('\n'), rest.size()));
      } else if (rest.starts_with("- ")) {
        PANELCAL_CHECK(read_dash());
      } else {
        PANELCAL_CHECK(read_key());
      }
    }
  }

 private:
  struct Open {
    int column;
    std::string key;
  };

  std::string path(std::string_view key) const {
    std::string out;
    for (const Open& open : open_) out += open.key + ".";
    return out + std::string(key);
  }

  Expected<void> read_key() {
    const Place place = scanner_.place();
    while (!open_.empty() && open_.back().column >= place.column) open_.pop_back();
    const std::string key = without_quotes(scalar_until(scanner_, ":\n"));
    if (scanner_.next() != ':' || key.empty())
      return failure(scanner_.unexpected("a key and \":\""));
    scanner_.advance();
    skip_tag();
    if (scanner_.next() == '[') {
      PANELCAL_TRY(std::vector<std::string> texts, bracketed(scanner_));
      return add_field(fields_, path(key), {std::move(texts), true, place});
    }
    if (scanner_.next() == '{') return read_braces(path(key));
    if (scanner_.next() == '\n' || scanner_.next() == '\r' || scanner_.is_at_end()) {
      open_.push_back({place.column, key});
      return {};
    }
    return add_field(
        fields_, path(key), {{without_quotes(scalar_until(scanner_, "\n"))}, false, place});
  }

  /// Blanks and `!!opencv-matrix` on the same line.
  void skip_tag() {
    const auto skip = [&] {
      while (scanner_.next() == ' ' || scanner_.next() == '\t') scanner_.advance();
    };
    skip();
    if (scanner_.rest().starts_with("!!")) {
      while (!scanner_.is_at_end() && kLensBlanks.find(scanner_.next()) == std::string_view::npos) {
        scanner_.advance();
      }
      skip();
    }
    if (scanner_.next() == '#')
      scanner_.advance(std::min(scanner_.rest().find('\n'), scanner_.rest().size()));
  }

  Expected<void> read_braces(const std::string& outer) {
    scanner_.advance();
    while (true) {
      scanner_.skip_blanks();
      if (scanner_.next() == '}') break;
      const Place place = scanner_.place();
      const std::string key = without_quotes(scalar_until(scanner_, ":,}"));
      if (scanner_.next() != ':' || key.empty())
        return failure(scanner_.unexpected("a key and \":\""));
      scanner_.advance();
      scanner_.skip_blanks();
      LensField field{{}, scanner_.next() == '[', place};
      if (field.is_list) {
        PANELCAL_TRY(field.texts, bracketed(scanner_));
      } else {
        field.texts = {without_quotes(scalar_until(scanner_, ",}"))};
      }
      PANELCAL_CHECK(add_field(fields_, outer + "." + key, std::move(field)));
      scanner_.skip_blanks();
      if (scanner_.next() == ',') scanner_.advance();
    }
    scanner_.advance();
    return {};
  }

  /// `- 1.5`, an element of the list that the last open key names.
  Expected<void> read_dash() {
    const Place place = scanner_.place();
    while (!open_.empty() && open_.back().column > place.column) open_.pop_back();
    if (open_.empty()) return failure(scanner_.unexpected("a key ahead of a list"));
    scanner_.advance(2);
    std::string key = path("");
    key.pop_back();
    LensField& list = fields_[key];
    if (list.texts.empty()) list = {{}, true, place};
    if (!list.is_list || list.texts.size() == kMaxLensValues) {
      return failure(scanner_.unexpected("a list of numbers"));
    }
    list.texts.push_back(without_quotes(scalar_until(scanner_, "\n")));
    return {};
  }

  LensScanner scanner_;
  LensFields fields_;
  std::vector<Open> open_;
};

}  // namespace

Expected<LensFields> read_yaml_fields(std::string_view text, const std::string& file) {
  return YamlReader(text, file).read();
}

Expected<LensFields> read_mrcal_fields(std::string_view text, const std::string& file) {
  LensScanner scanner(text, file);
  LensFields fields;
  scanner.skip_blanks();
  if (scanner.next() != '{') return failure(scanner.unexpected("\"{\""));
  scanner.advance();
  while (true) {
    scanner.skip_blanks();
    if (scanner.next() == '}') break;
    LensField field{{}, false, scanner.place()};
    const std::string key = without_quotes(scalar_until(scanner, ":,}"));
    if (scanner.next() != ':' || key.empty()) return failure(scanner.unexpected("a key and \":\""));
    scanner.advance();
    scanner.skip_blanks();
    // Of lists in lists, such as a valid_intrinsics_region, nothing is used.
    const std::string_view rest = scanner.rest();
    const std::size_t inner =
        rest.empty() ? 0 : std::min(rest.find_first_not_of(" \t\r\n", 1), rest.size());
    if (rest.starts_with('[') && rest.substr(inner).starts_with('[')) {
      int depth = 0;
      do {
        if (scanner.is_at_end()) return failure(scanner.unexpected("\"]\""));
        depth += scanner.next() == '[' ? 1 : scanner.next() == ']' ? -1 : 0;
        scanner.advance();
      } while (depth > 0);
    } else if (rest.starts_with('[')) {
      field.is_list = true;
      PANELCAL_TRY(field.texts, bracketed(scanner));
    } else {
      field.texts = {without_quotes(scalar_until(scanner, ",}"))};
    }
    PANELCAL_CHECK(add_field(fields, key, std::move(field)));
    scanner.skip_blanks();
    if (scanner.next() == ',') scanner.advance();
  }
  return fields;
}

}  // namespace panelcal::internal
