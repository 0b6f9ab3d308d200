// SPDX-License-Identifier: Apache-2.0
#include "surface/files/formats/xml_scanner.h"

#include <algorithm>
#include <utility>

namespace panelcal::internal {
namespace {

constexpr std::string_view kXmlBlanks = " \t\r\n";
/// More attributes than any element of a height map has.
constexpr std::size_t kMaxAttributes = 32;
/// Number of characters of a text that a message shows at most.
constexpr std::size_t kShown = 20;

bool is_name_byte(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

}  // namespace

Expected<TextField> XmlTag::attribute(const std::string& file, std::string_view key) const {
  for (const auto& [attribute_name, value] : attributes) {
    if (attribute_name.text == key) return value;
  }
  return failure({Code::MeasurementFile,
                  {file, name.line, name.column},
                  "<" + quoted(name.text) + ">: missing attribute " + std::string(key),
                  ""});
}

XmlScanner::XmlScanner(std::string_view text, std::string file)
    : rest_(text), file_(std::move(file)) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  if (rest_.starts_with(kUtf8Mark)) rest_.remove_prefix(kUtf8Mark.size());
}

TextField XmlScanner::here(std::size_t n_bytes) const {
  return {rest_.substr(0, n_bytes), line_, column_};
}

Diagnostic XmlScanner::unexpected(std::string expected) const {
  return unexpected_field(file_, here(kShown), std::move(expected));
}

void XmlScanner::advance(std::size_t n_bytes) {
  for (const char c : rest_.substr(0, n_bytes)) {
    column_ = c == '\n' ? 1 : column_ + 1;
    if (c == '\n') ++line_;
  }
  rest_.remove_prefix(std::min(n_bytes, rest_.size()));
}

void XmlScanner::skip_blanks() {
  advance(std::min(rest_.find_first_not_of(kXmlBlanks), rest_.size()));
}

Expected<void> XmlScanner::skip_to(std::string_view end) {
  const std::size_t at = rest_.find(end);
  if (at == std::string_view::npos) {
    return failure(unexpected("\"" + std::string(end) + "\" at its end"));
  }
  advance(at + end.size());
  return {};
}

Expected<void> XmlScanner::skip_misc() {
  if (rest_.starts_with("<?xml ")) PANELCAL_CHECK(skip_to("?>"));
  skip_blanks();
  while (rest_.starts_with("<!--")) {
    PANELCAL_CHECK(skip_to("-->"));
    skip_blanks();
  }
  return {};
}

Expected<TextField> XmlScanner::name() {
  const auto end = std::ranges::find_if_not(rest_, is_name_byte);
  const TextField out = here(static_cast<std::size_t>(end - rest_.begin()));
  if (out.text.empty()) return failure(unexpected("a name"));
  advance(out.text.size());
  return out;
}

Expected<TextField> XmlScanner::quoted_value() {
  if (!rest_.starts_with('"') && !rest_.starts_with('\'')) {
    return failure(unexpected("a value in quotes"));
  }
  const char quote = rest_.front();
  advance(1);
  const std::size_t end = rest_.find_first_of(std::string{quote, '<', '&'});
  if (end == std::string_view::npos || rest_[end] != quote) {
    return failure(unexpected("a value that ends with its quote"));
  }
  const TextField out = here(end);
  advance(end + 1);
  return out;
}

Expected<bool> XmlScanner::at_end_tag() {
  PANELCAL_CHECK(skip_misc());
  return rest_.starts_with("</");
}

Expected<XmlTag> XmlScanner::start_tag() {
  PANELCAL_CHECK(skip_misc());
  if (!rest_.starts_with('<')) return failure(unexpected("\"<\" of an element"));
  advance(1);
  XmlTag out;
  PANELCAL_TRY(out.name, name());
  while (true) {
    skip_blanks();
    if (rest_.starts_with("/>") || rest_.starts_with('>')) break;
    if (out.attributes.size() == kMaxAttributes) return failure(unexpected("fewer attributes"));
    PANELCAL_TRY(const TextField key, name());
    for (const auto& [other, ignored] : out.attributes) {
      if (other.text != key.text) continue;
      return failure(unexpected_field(file_, key, "each attribute once"));
    }
    skip_blanks();
    if (!rest_.starts_with('=')) return failure(unexpected("\"=\""));
    advance(1);
    skip_blanks();
    PANELCAL_TRY(const TextField value, quoted_value());
    out.attributes.emplace_back(key, value);
  }
  out.is_empty = rest_.starts_with('/');
  advance(out.is_empty ? 2 : 1);
  return out;
}

Expected<void> XmlScanner::end_tag(std::string_view name_expected) {
  PANELCAL_CHECK(skip_misc());
  const std::string expected = "\"</" + std::string(name_expected) + ">\"";
  const TextField at = here(kShown);
  if (!rest_.starts_with("</")) return failure(unexpected(expected));
  advance(2);
  PANELCAL_TRY(const TextField found, name());
  skip_blanks();
  if (found.text != name_expected || !rest_.starts_with('>')) {
    return failure(unexpected_field(file_, at, expected));
  }
  advance(1);
  return {};
}

Expected<TextField> XmlScanner::text() {
  skip_blanks();
  const std::size_t end = std::min(rest_.find_first_of("<&"), rest_.size());
  TextField out = here(end);
  advance(end);
  const std::size_t last = out.text.find_last_not_of(kXmlBlanks);
  out.text = out.text.substr(0, last == std::string_view::npos ? 0 : last + 1);
  return out;
}

Expected<void> XmlScanner::end() {
  PANELCAL_CHECK(skip_misc());
  if (rest_.empty()) return {};
  return failure(unexpected("the end of the file"));
}

}  // namespace panelcal::internal
