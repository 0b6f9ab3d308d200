// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/json_line.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMaxMembers = 64;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

void append_utf8(std::string& out, unsigned code) {
  const auto put = [&](unsigned byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | (code >> 6));
    put(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    put(0xE0 | (code >> 12));
    put(0x80 | ((code >> 6) & 0x3F));
    put(0x80 | (code & 0x3F));
  } else {
    put(0xF0 | (code >> 18));
    put(0x80 | ((code >> 12) & 0x3F));
    put(0x80 | ((code >> 6) & 0x3F));
    put(0x80 | (code & 0x3F));
  }
}

/// Recursive descent that does not need to recurse.
class Scanner {
 public:
  Scanner(std::string_view text, const Place& line) : text_(text), line_(line) {}

  int column() const { return static_cast<int>(at_) + 1; }
  std::size_t offset() const { return at_; }
  std::string_view since(std::size_t begin) const { return text_.substr(begin, at_ - begin); }
  bool at_end() const { return at_ >= text_.size(); }
  char peek() const { return at_end() ? '\0' : text_[at_]; }

  void skip_space() {
    while (peek() == ' ' || peek() == '\t' || peek() == '\r') ++at_;
  }
  bool take(char c) {
    if (at_end() || peek() != c) return false;
    ++at_;
    return true;
  }
  bool take_word(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  tl::unexpected<Diagnostic> unexpected(std::string expected) const {
    return failure({Code::JsonSyntax,
                    {line_.file, line_.line, column()},
                    at_end() ? "the line ends here" : quoted(text_.substr(at_, 20)),
                    std::move(expected)});
  }

  Expected<std::string> string() {
    if (!take('"')) return unexpected("a text in double quotes");
    std::string out;
    while (!take('"')) {
      if (at_end() || static_cast<unsigned char>(peek()) < 0x20) return unexpected("a closing \"");
      if (!take('\\')) {
        out += text_[at_++];
        continue;
      }
      PANELCAL_CHECK(escape(out));
    }
    return out;
  }

  Expected<JsonNumber> number() {
    const std::size_t begin = at_;
    take('-');
    if (!take('0') && !digits()) return unexpected("a number");
    if (take('.') && !digits()) return unexpected("a digit");
    if (peek() == 'e' || peek() == 'E') {
      ++at_;
      if (peek() == '+' || peek() == '-') ++at_;
      if (!digits()) return unexpected("a digit");
    }
    return JsonNumber{since(begin)};
  }

  Expected<std::vector<JsonNumber>> numbers() {
    std::vector<JsonNumber> out;
    take('[');
    skip_space();
    if (take(']')) return out;
    while (true) {
      PANELCAL_TRY(const JsonNumber element, number());
      out.push_back(element);
      skip_space();
      if (take(']')) return out;
      if (!take(',')) return unexpected("',' or ']'");
      skip_space();
    }
  }

 private:
  bool digits() {
    const std::size_t begin = at_;
    while (is_digit(peek())) ++at_;
    return at_ > begin;
  }

  Expected<unsigned> hex4() {
    unsigned code = 0;
    const std::string_view word = text_.substr(at_, 4);
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), code, 16);
    if (error != std::errc() || stop != word.data() + 4) return unexpected("four hex digits");
    at_ += 4;
    return code;
  }

  Expected<void> escape(std::string& out) {
    constexpr std::string_view kLetters = "\"\\/bfnrt";
    constexpr std::string_view kMeanings = "\"\\/\b\f\n\r\t";
    if (const auto i = kLetters.find(peek()); !at_end() && i != std::string_view::npos) {
      out += kMeanings[i];
      ++at_;
      return {};
    }
    if (!take('u')) return unexpected("an escape such as \\n or \\u00e4");
    PANELCAL_TRY(unsigned code, hex4());
    if (code >= 0xD800 && code < 0xDC00) {
      if (!take_word("\\u")) return unexpected("the second half of a surrogate pair");
      PANELCAL_TRY(const unsigned low, hex4());
      if (low < 0xDC00 || low > 0xDFFF) return unexpected("the second half of a surrogate pair");
      code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
    } else if (code >= 0xDC00 && code <= 0xDFFF) {
      return unexpected("the first half of a surrogate pair before the second");
    }
    append_utf8(out, code);
    return {};
  }

  std::string_view text_;
  const Place& line_;
  std::size_t at_ = 0;
};

Expected<void> scan_value(Scanner& scanner, JsonMember& member) {
  const char first = scanner.peek();
  if (first == '"') {
    PANELCAL_TRY(member.value, scanner.string());
  } else if (first == '[') {
    PANELCAL_TRY(member.value, scanner.numbers());
  } else if (first == '-' || is_digit(first)) {
    PANELCAL_TRY(member.value, scanner.number());
  } else if (scanner.take_word("true")) {
    member.value = true;
  } else if (scanner.take_word("false")) {
    member.value = false;
  } else if (scanner.take_word("null")) {
    member.value = std::monostate();
  } else {
    return scanner.unexpected("a number, a text, true, false, null or an array of numbers");
  }
  return {};
}

Expected<JsonMember> scan_member(Scanner& scanner) {
  JsonMember member;
  scanner.skip_space();
  member.column = scanner.column();
  PANELCAL_TRY(member.key, scanner.string());
  scanner.skip_space();
  if (!scanner.take(':')) return scanner.unexpected("':'");
  scanner.skip_space();
  member.value_column = scanner.column();
  const std::size_t begin = scanner.offset();
  PANELCAL_CHECK(scan_value(scanner, member));
  member.raw = scanner.since(begin);
  return member;
}

}  // namespace

Expected<JsonLine> JsonLine::parse(std::string_view text, Place line) {
  JsonLine parsed(std::move(line));
  Scanner scanner(text, parsed.line_);
  scanner.skip_space();
  if (!scanner.take('{')) return scanner.unexpected("'{'");
  scanner.skip_space();
  if (!scanner.take('}')) {
    while (true) {
      PANELCAL_TRY(JsonMember member, scan_member(scanner));
      if (parsed.is_taken(member.key) || parsed.members_.size() == kMaxMembers) {
        return failure({Code::JsonSyntax,
                        {parsed.line_.file, parsed.line_.line, member.column},
                        "the key " + quoted(member.key) +
                            (parsed.is_taken(member.key) ? " appears twice" : " is one too many"),
                        fmt::format("each key once, and at most {}", kMaxMembers)});
      }
      parsed.members_.push_back(std::move(member));
      scanner.skip_space();
      if (scanner.take('}')) break;
      if (!scanner.take(',')) return scanner.unexpected("',' or '}'");
    }
  }
  scanner.skip_space();
  if (!scanner.at_end()) return scanner.unexpected("the end of the line");
  return parsed;
}

Expected<void> JsonLine::check_keys(std::span<const std::string_view> known, Code code) const {
  for (const JsonMember& member : members_) {
    if (std::ranges::find(known, member.key) != known.end()) continue;
    const std::string_view nearest = nearest_word(member.key, known);
    return failure({code,
                    {line_.file, line_.line, member.column},
                    "unknown key " + quoted(member.key),
                    nearest.empty() ? fmt::format("one of {}", fmt::join(known, ", "))
                                    : "did you mean " + quoted(nearest) + "?"});
  }
  return {};
}

bool JsonLine::is_taken(std::string_view key) const {
  return std::ranges::find(members_, key, &JsonMember::key) != members_.end();
}

const JsonMember* JsonLine::find(std::string_view key) const {
  const auto found = std::ranges::find(members_, key, &JsonMember::key);
  if (found == members_.end() || std::holds_alternative<std::monostate>(found->value)) {
    return nullptr;
  }
  return &*found;
}

Diagnostic JsonLine::missing(std::string_view key, Code code) const {
  return {code, {line_.file, line_.line, 1}, "missing key " + quoted(key), ""};
}

Diagnostic JsonLine::problem(std::string_view key, Code code, std::string expected) const {
  const JsonMember& member = *find(key);
  // Without quotes of our own: "3" and 3 are different things in JSON.
  const std::string value = quoted(member.raw);
  return {code,
          {line_.file, line_.line, member.value_column},
          fmt::format("{} is {}", quoted(key), value.substr(1, value.size() - 2)),
          std::move(expected)};
}

}  // namespace panelcal::internal
