// SPDX-License-Identifier: Apache-2.0
#include "tools/page/page.h"

#include <algorithm>
#include <charconv>
#include <cstddef>

#include "calib/base/files/digest.h"
#include "calib/base/json/facts.h"
#include "tools/page/front_end.h"

namespace panelcal {
namespace {

/// JSON that no markup can begin in: a `<` only stands inside of strings.
void append_inert(std::string& out, std::string_view json) {
  for (std::size_t at = 0; at < json.size();) {
    const std::size_t end = std::min(json.find('<', at), json.size());
    out += json.substr(at, end - at);
    if (end < json.size()) out += "\\u003c";
    at = end + 1;
  }
}

/// Text between tags: what could be markup, and control characters, become '?'.
std::string plain_title(std::string_view title) {
  std::string out;
  for (const char c : title) {
    const bool is_markup = c == '<' || c == '>' || c == '&';
    out += is_markup || static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  // Bytes that are no UTF-8 are replaced as in facts; the quotes and escapes go again.
  return facts::Json::parse(
             facts::Json(out).dump(-1, ' ', false, facts::Json::error_handler_t::replace))
      .get<std::string>();
}

/// 'sha256-...', as Content-Security-Policy names the one script or style that may be used.
std::string policy_source(std::string_view text) {
  const std::string digits = sha256(text);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    unsigned byte = 0;
    std::from_chars(digits.data() + i, digits.data() + i + 2, byte, 16);
    bytes += static_cast<char>(byte);
  }
  return "'sha256-" + facts::base64(bytes) + "'";
}

std::string_view media_type(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8")) return "image/jpeg";
  return bytes.starts_with("RIFF") ? "image/webp" : "image/png";
}

}  // namespace

std::string page_html(std::string_view title,
                      std::string_view facts,
                      const PagePictures& pictures) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src " +
      policy_source(kFrontEndScript) + "; style-src " + policy_source(kFrontEndStyle) +
      "; img-src data:; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      plain_title(title) + "</title>\n<style>";
  out += kFrontEndStyle;
  out +=
      "</style>\n</head>\n<body>\n<noscript><p>This page shows its facts by JavaScript. Without "
      "it, read them as JSON: in this file, or as the option --json of the same command writes "
      "them.</p></noscript>\n";
  out += facts::kPageMark;
  append_inert(out, facts);
  out += "</script>\n<script type=\"application/json\" id=\"pictures\">";
  facts::Json uris = facts::Json::object();
  for (const auto& [name, bytes] : pictures) {
    uris[name] = "data:" + std::string(media_type(bytes)) + ";base64," + facts::base64(bytes);
  }
  append_inert(out, facts::text(uris));
  out += "</script>\n<script>";
  out += kFrontEndScript;
  return out + "</script>\n</body>\n</html>\n";
}

}  // namespace panelcal
