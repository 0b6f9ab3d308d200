// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "calib/base/amount.h"
#include "machine/align/pad_readers.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// X2 attributes in a comment, for readers of X1 (Gerber Layer Format Specification, 5.1.1).
constexpr std::string_view kCommentAttribute = "G04 #@! ";
constexpr std::string_view kFunctionAttribute = "TA.AperFunction,";
/// Diameters that differ by less are one.
constexpr double kSameDiameter = 0.01;
constexpr int kFirstAperture = 10;

/// The kinds of fiducials: the first of which there are any are those of the whole panel.
constexpr std::array<std::string_view, 3> kFunctions = {
    "FiducialPad,Panel", "FiducialPad,Global", "FiducialPad,Local"};

struct Aperture {
  std::optional<Length> diameter;  ///< of a round one
  std::string function;            ///< .AperFunction; empty: none
};

struct Flash {
  Position<frame::Nominal> place;
  int line = 0;
  Aperture aperture;
};

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The digits at the beginning of a text, with a sign; they are taken off it.
std::string_view take_digits(std::string_view& text) {
  std::size_t n = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  while (n < text.size() && is_digit(text[n])) ++n;
  const std::string_view digits = text.substr(0, n);
  text.remove_prefix(n);
  return digits;
}

class GerberReader {
 public:
  GerberReader(std::string_view bytes, const std::string& file) : left_(bytes), file_(file) {}

  Expected<std::vector<Flash>> flashes() {
    while (!has_ended_) {
      PANELCAL_TRY(const std::string word, next_word());
      PANELCAL_CHECK(is_extended_ ? take_extended(word) : take_plain(word));
    }
    return std::move(flashes_);
  }

 private:
  tl::unexpected<Diagnostic> refuse(Code code, std::string_view word, std::string expected) const {
    return failure({code, {file_, line_, 0}, quoted(word), std::move(expected)});
  }

  /// The next word without its `*`; line ends count nothing.
  Expected<std::string> next_word() {
    std::string word;
    for (; !left_.empty(); left_.remove_prefix(1)) {
      const char c = left_.front();
      if (c == '\n') ++next_line_;
      if (c == '\n' || c == '\r') continue;
      if (c == '%' && word.empty()) {
        is_extended_ = !is_extended_;
        continue;
      }
      if (c == '%') break;
      if (c == '*') {
        left_.remove_prefix(1);
        return word;
      }
      if (word.empty()) line_ = next_line_;
      word += c;
    }
    line_ = next_line_;
    if (left_.empty()) {
      return failure(
          {Code::EndMissing, {file_, line_, 0}, "no M02", "M02* at the end of a Gerber file"});
    }
    return refuse(Code::ArgumentInvalid, word, "* at its end");
  }

  Expected<void> take_extended(const std::string& word) {
    const std::string_view text = word;
    const std::string_view code = text.substr(0, 2);
    if (code == "TA" || code == "TD") {
      take_attribute(text);
    } else if (code == "FS") {
      return take_format(text);
    } else if (code == "MO") {
      if (text != "MOMM" && text != "MOIN")
        return refuse(Code::ArgumentInvalid, text, "MOMM or MOIN");
      unit_ = text == "MOMM" ? mm(1) : inch(1);
    } else if (code == "AD") {
      return take_aperture(text);
    } else if (code == "AM") {
      return skip_macro();
    } else if (code == "LP") {
      is_dark_ = text == "LPD";
    } else if (moves_flashes(text)) {
      return refuse(Code::NotSupported, text, "a file whose flashes stand where they are written");
    }
    return {};
  }

  /// Step and repeat, block apertures, and what older files do to the whole image.
  static bool moves_flashes(std::string_view text) {
    constexpr std::array<std::string_view, 11> kHarmless = {"SR",
                                                            "SRX1Y1",
                                                            "SRX1Y1I0J0",
                                                            "SRX1Y1I0.0J0.0",
                                                            "ASAXBY",
                                                            "MIA0B0",
                                                            "OFA0B0",
                                                            "SFA1B1",
                                                            "IR0",
                                                            "LS1",
                                                            "LS1.0"};
    constexpr std::array<std::string_view, 7> kMoving = {"SR", "AB", "AS", "MI", "OF", "SF", "IR"};
    const std::string_view code = text.substr(0, 2);
    const bool is_scale = code == "LS";
    return (is_scale || std::ranges::find(kMoving, code) != kMoving.end()) &&
           std::ranges::find(kHarmless, text) == kHarmless.end();
  }

  /// The words of an aperture macro reach to the next `%`.
  Expected<void> skip_macro() {
    while (!left_.empty() && left_.front() != '%') {
      if (left_.front() == '\n') ++next_line_;
      left_.remove_prefix(1);
    }
    return {};
  }

  void take_attribute(std::string_view text) {
    if (text.starts_with(kFunctionAttribute)) {
      function_ = text.substr(kFunctionAttribute.size());
    } else if (text == "TD" || text == "TD.AperFunction") {
      function_.clear();
    }
  }

  Expected<void> take_format(std::string_view text) {
    const bool has_form = text.size() == 10 && text.starts_with("FSLAX") && text[7] == 'Y' &&
                          is_digit(text[5]) && is_digit(text[6]) &&
                          text.substr(5, 2) == text.substr(8);
    if (!has_form) {
      return refuse(Code::NotSupported, text, "FSLAX46Y46: absolute, leading zeros left out");
    }
    n_decimals_ = text[6] - '0';
    return {};
  }

  Expected<void> take_aperture(std::string_view text) {
    std::string_view rest = text.substr(2);
    const bool has_d = rest.starts_with('D');
    if (has_d) rest.remove_prefix(1);
    const auto number = decimal_of(take_digits(rest));
    if (!has_d || !number || *number < kFirstAperture || rest.empty()) {
      return refuse(Code::ArgumentInvalid, text, "ADD10C,1.0: a number from 10 and a shape");
    }
    if (!unit_) return refuse(Code::ArgumentInvalid, text, "MOMM or MOIN before it");
    Aperture aperture{std::nullopt, function_};
    if (rest.starts_with("C,")) {
      rest.remove_prefix(2);
      const auto diameter = decimal_of(rest.substr(0, rest.find('X')));
      if (!diameter || *diameter < 0) return refuse(Code::NumberMalformed, text, "a diameter");
      aperture.diameter = *diameter * *unit_;
    }
    apertures_.insert_or_assign(static_cast<int>(*number), std::move(aperture));
    return {};
  }

  Expected<void> take_plain(const std::string& word) {
    std::string_view text = word;
    if (text.starts_with(kCommentAttribute)) {
      take_attribute(text.substr(kCommentAttribute.size()));
      return {};
    }
    if (text.starts_with("G04") || text.starts_with("G4 ")) return {};
    if (text == "M02" || text == "M00" || text == "M2") {
      has_ended_ = true;
      return {};
    }
    if (text == "G91") return refuse(Code::NotSupported, text, "absolute coordinates (G90)");
    if (text == "G70" || text == "G71") unit_ = text == "G71" ? mm(1) : inch(1);
    while (!text.empty() && text.front() == 'G') {
      text.remove_prefix(1);
      if (take_digits(text).empty()) return refuse(Code::ArgumentInvalid, word, "G with a number");
    }
    return take_operation(text, word);
  }

  /// X#Y#I#J#D#, each if it is there.
  Expected<void> take_operation(std::string_view text, std::string_view word) {
    std::optional<int> d;
    while (!text.empty()) {
      const char letter = text.front();
      text.remove_prefix(1);
      const std::string_view digits = take_digits(text);
      const auto number = decimal_of(digits);
      const bool is_known = std::string_view("XYIJDM").find(letter) != std::string_view::npos;
      if (!is_known || !number) {
        return refuse(Code::NumberMalformed, word, "X, Y, I, J and D with whole numbers");
      }
      if (letter == 'X' || letter == 'Y') {
        if (!n_decimals_ || !unit_) {
          return refuse(
              Code::ArgumentInvalid, word, "FSLAX..Y.. and MOMM or MOIN before coordinates");
        }
        at_mm_[letter == 'X' ? 0 : 1] = *number * std::pow(10.0, -*n_decimals_) * unit_->in_mm();
      } else if (letter == 'D') {
        d = static_cast<int>(*number);
      }
    }
    if (d && *d >= kFirstAperture) return take_current(*d, word);
    if (d == 3) flash();
    return {};
  }

  Expected<void> take_current(int number, std::string_view word) {
    const auto found = apertures_.find(number);
    if (found == apertures_.end()) {
      return refuse(Code::ArgumentInvalid, word, "an aperture that ADD has defined");
    }
    current_ = found->second;
    return {};
  }

  void flash() {
    if (!current_ || !is_dark_) return;
    flashes_.push_back({position_mm<frame::Nominal>(at_mm_.x(), at_mm_.y()), line_, *current_});
  }

  std::string_view left_;
  const std::string& file_;
  int line_ = 1;
  int next_line_ = 1;
  bool is_extended_ = false;
  bool has_ended_ = false;
  bool is_dark_ = true;
  std::optional<int> n_decimals_;
  std::optional<Length> unit_;
  std::string function_;
  std::map<int, Aperture> apertures_;
  std::optional<Aperture> current_;
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();
  std::vector<Flash> flashes_;
};

/// "1.000 mm (4), 1.700 mm (56)": the round flashes, by diameter.
std::string diameters_text(const std::vector<Flash>& flashes) {
  std::map<double, int> count;
  for (const Flash& flash : flashes) {
    if (flash.aperture.diameter) ++count[flash.aperture.diameter->in_mm()];
  }
  std::vector<std::string> parts;
  for (const auto& [diameter_mm, n] : count)
    parts.push_back(fmt::format("{:g} mm ({})", diameter_mm, n));
  return parts.empty() ? "no round flash"
                       : fmt::format("round flashes of {}", fmt::join(parts, ", "));
}

template <class Counts>
FoundPads pads_that(const std::vector<Flash>& flashes, std::string words, Counts counts) {
  FoundPads found{{}, std::move(words)};
  for (const Flash& flash : flashes) {
    if (!counts(flash.aperture)) continue;
    found.pads.push_back({{.nominal = flash.place, .line = flash.line}, flash.aperture.diameter});
  }
  return found;
}

}  // namespace

bool is_gerber(std::string_view bytes) {
  constexpr std::size_t kHead = 1 << 16;
  return bytes.substr(0, kHead).find("%FS") != std::string_view::npos;
}

Expected<FoundPads> pads_of_gerber(std::string_view bytes,
                                   const std::string& file,
                                   const std::optional<Length>& diameter) {
  PANELCAL_TRY(const std::vector<Flash> flashes, GerberReader(bytes, file).flashes());
  if (diameter) {
    FoundPads found =
        pads_that(flashes,
                  fmt::format("round flashes of {:g} mm", diameter->in_mm()),
                  [&](const Aperture& a) {
                    return a.diameter && std::abs(*a.diameter / *diameter - 1) <= kSameDiameter;
                  });
    if (!found.pads.empty()) return found;
  } else {
    for (const std::string_view function : kFunctions) {
      FoundPads found = pads_that(flashes,
                                  "flashes " + std::string(function),
                                  [&](const Aperture& a) { return a.function == function; });
      if (!found.pads.empty()) return found;
    }
  }
  return failure({Code::Usage,
                  {file, 0, 0},
                  (diameter ? fmt::format("no round flash of {:g} mm; ", diameter->in_mm())
                            : "no flash has the attribute FiducialPad; ") +
                      diameters_text(flashes),
                  "--diameter with that of the fiducials, or their places as a list \"X,Y;X,Y\""});
}

}  // namespace panelcal::internal
