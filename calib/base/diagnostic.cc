// SPDX-License-Identifier: Apache-2.0
#include "calib/base/diagnostic.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <utility>

namespace panelcal {
namespace {

constexpr std::array kCatalogue = {
#define PANELCAL_DIAGNOSTIC(name, slug, severity, fault, summary, advice) \
  CodeInfo{Code::name, slug, Severity::severity, Fault::fault, summary, advice},
#include "calib/base/diagnostic_codes.def"
};

/// Number of letters that are replaced, inserted, left out or swapped with their neighbour (the
/// "optimal string alignment" of Damerau, Communications of the ACM 7 (1964) 171).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
  std::iota(above.begin(), above.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replace = above[j] + (a[i] == b[j] ? 0 : 1);
      row[j + 1] = std::min({replace, row[j] + 1, above[j + 1] + 1});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) {
        row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
      }
    }
    before = std::exchange(above, row);
  }
  return above.back();
}

void append_hex(std::string& out, unsigned char byte) {
  constexpr std::string_view kHex = "0123456789abcdef";
  out += "\\x";
  out += kHex[byte >> 4];
  out += kHex[byte & 15];
}

}  // namespace

std::span<const CodeInfo> diagnostic_catalogue() {
  return kCatalogue;
}

const CodeInfo& info(Code code) {
  return kCatalogue[static_cast<std::size_t>(code)];
}

std::string Diagnostic::text() const {
  std::string text = escaped_controls(place.file);
  if (place.line > 0) {
    text += ':' + std::to_string(place.line);
    if (place.column > 0) text += ':' + std::to_string(place.column);
  }
  if (!text.empty()) text += ": ";
  text += severity() == Severity::Error ? "error[" : "warning[";
  text += info(code).slug;
  text += "]: " + message();
  if (!expected.empty()) text += (expected.ends_with('?') ? "; " : "; expected ") + expected;
  return text;
}

std::string Diagnostic::message() const {
  std::string message(info(code).summary);
  if (!what.empty()) message += ": " + what;
  return message;
}

void DiagnosticLog::add(Diagnostic diagnostic) {
  std::size_t& n = diagnostic.severity() == Severity::Error ? n_errors_ : n_warnings_;
  if (n++ < kKept) kept_.push_back(std::move(diagnostic));
}

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known) {
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string escaped_controls(std::string_view text, std::string_view kept) {
  constexpr unsigned char kLeadOfC1 = 0xc2;
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    if (byte == kLeadOfC1 && next >= 0x80 && next < 0xa0) {
      append_hex(out, byte);
      append_hex(out, next);
      ++i;
    } else if ((byte < 0x20 || byte == 0x7f) && kept.find(text[i]) == kept.npos) {
      append_hex(out, byte);
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string quoted(std::string_view text, std::size_t max_length) {
  std::string out = "\"";
  for (const char c : text.substr(0, max_length)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7f) {
      out += c;
    } else {
      append_hex(out, byte);
    }
  }
  if (text.size() > max_length) out += "...";
  return out + '"';
}

}  // namespace panelcal
