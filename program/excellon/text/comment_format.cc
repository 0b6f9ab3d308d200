// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/comment_format.h"

#include <algorithm>
#include <string>

#include "program/text/gaps.h"

namespace panelcal::excellon {
namespace {

/// Digits before and behind the mark between them: `3:3`.
std::optional<std::pair<int, int>> digit_pair(std::string_view text, char mark) {
  const auto at = text.find(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const auto before = parse_count(text.substr(0, at));
  const auto behind = parse_count(text.substr(at + 1));
  if (!before || !behind || *before > 6 || *behind > 6 || *before + *behind == 0) {
    return std::nullopt;
  }
  return std::pair{*before, *behind};
}

std::optional<CommentFormat> read_file_format(std::string_view comment) {
  constexpr std::string_view kWord = "FILE_FORMAT";
  const auto at = comment.find(kWord);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view rest = trimmed(comment.substr(at + kWord.size()));
  if (!rest.starts_with('=')) return CommentFormat();
  return CommentFormat{.digits = digit_pair(trimmed(rest.substr(1)), ':')};
}

std::optional<CommentFormat> read_braces(std::string_view comment) {
  constexpr std::string_view kWord = "FORMAT={";
  const auto at = comment.find(kWord);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view body = comment.substr(at + kWord.size());
  body = body.substr(0, body.find('}'));
  const auto says = [&](std::string_view words) { return body.find(words) != body.npos; };
  CommentFormat out{.digits = digit_pair(trimmed(body.substr(0, body.find('/'))), ':')};
  if (says("inch") != says("metric")) {
    out.unit = says("inch") ? LengthUnit::Inch : LengthUnit::Millimeter;
  }
  if (says("suppress leading") != says("suppress trailing")) {
    out.zeros = says("suppress leading") ? Zeros::TrailingKept : Zeros::LeadingKept;
  }
  if (says("absolute") != says("incremental")) out.is_incremental = says("incremental");
  return out;
}

/// Mentor's, in four parts.
std::optional<CommentFormat> read_parts(std::string_view comment) {
  std::string capitals(comment);
  std::ranges::transform(capitals, capitals.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  });
  std::string_view rest = trimmed(capitals);
  while (rest.starts_with(';')) rest = trimmed(rest.substr(1));
  constexpr std::string_view kWord = "FORMAT";
  if (!rest.starts_with(kWord)) return std::nullopt;
  rest = trimmed(rest.substr(kWord.size()));
  if (!rest.starts_with(':')) return std::nullopt;
  rest.remove_prefix(1);
  CommentFormat out;
  std::string unknown;
  while (true) {
    const auto slash = rest.find('/');
    const std::string_view part = trimmed(rest.substr(0, slash));
    const auto says = [&](std::string_view word) { return part.find(word) != part.npos; };
    if (const auto digits = digit_pair(part, '.')) {
      out.digits = digits;
    } else if (part == "MM" || part == "METRIC") {
      out.unit = LengthUnit::Millimeter;
    } else if (part == "INCH" || part == "INCHES" || part == "ENGLISH") {
      out.unit = LengthUnit::Inch;
    } else if (says("LEADING") != says("TRAILING")) {
      out.zeros = says("LEADING") ? Zeros::TrailingKept : Zeros::LeadingKept;
    } else if (part == "ABSOLUTE" || part == "INCREMENTAL") {
      out.is_incremental = part == "INCREMENTAL";
    } else if (part != "NONE") {
      unknown = part;
    }
    if (slash == std::string_view::npos) break;
    rest.remove_prefix(slash + 1);
  }
  // Any other comment may begin so.
  if (!out.digits) return CommentFormat();
  out.unknown = unknown;
  return out;
}

}  // namespace

CommentFormat read_comment_format(std::string_view comment) {
  for (auto* const read : {read_file_format, read_braces, read_parts}) {
    if (const auto format = read(comment)) return *format;
  }
  return {};
}

}  // namespace panelcal::excellon
