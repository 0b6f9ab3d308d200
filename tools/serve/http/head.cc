// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/http/head.h"

#include <algorithm>

namespace panelcal::serve {
namespace {

/// A sign of a token (RFC 9110, section 5.6.2).
bool is_token_sign(char c) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         kMarks.find(c) != kMarks.npos;
}

bool is_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, is_token_sign);
}

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\t') || byte == 0x7f;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// METHOD SP TARGET SP VERSION, with one blank each.
bool parse_request_line(std::string_view line, Head& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == line.npos || first == last) return false;
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  head.request.method = line.substr(0, first);
  head.request.target = target;
  head.is_http_1_0 = version == "HTTP/1.0";
  return is_token(head.request.method) && !target.empty() &&
         target.find_first_of(" \t") == target.npos && (head.is_http_1_0 || version == "HTTP/1.1");
}

bool parse_header(std::string_view line, Head& head) {
  const std::size_t colon = std::min(line.find(':'), line.size());
  if (colon == line.size() || !is_token(line.substr(0, colon))) return false;
  const std::string_view value = trimmed(line.substr(colon + 1));
  head.request.headers.push_back({std::string(line.substr(0, colon)), std::string(value)});
  return true;
}

}  // namespace

std::optional<Head> parse_head(std::string_view text) {
  constexpr std::string_view kEnd = "\r\n";
  Head head;
  for (bool is_first = true;; is_first = false) {
    const std::size_t end = text.find(kEnd);
    if (end == text.npos) return std::nullopt;
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + kEnd.size());
    if (std::ranges::any_of(line, is_control)) return std::nullopt;
    if (line.empty() && !is_first) break;
    if (!(is_first ? parse_request_line(line, head) : parse_header(line, head))) {
      return std::nullopt;
    }
  }
  if (!text.empty()) return std::nullopt;
  const std::string_view connection = head.request.header("connection");
  head.closes = head.is_http_1_0 ? connection != "keep-alive" && connection != "Keep-Alive"
                                 : connection == "close";
  return head;
}

}  // namespace panelcal::serve
