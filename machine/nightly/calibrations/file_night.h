// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "machine/nightly/record/night_calibration.h"

namespace panelcal::internal {

/// A calibration whose file is its entry's result, byte for byte.
class FileNight : public NightCalibration {
 public:
  Expected<bool> is_installed(const Ledger& ledger) const override;
  Expected<std::string> by_hand(const Ledger& ledger) const override;
  Expected<bool> install(const Ledger& ledger) override;

 protected:
  /// The calibration that a person may have put there by hand, in words: "a table".
  virtual std::string_view thing() const = 0;
  /// The date of a file's bytes; empty for a damaged one.
  virtual std::optional<std::chrono::sys_seconds> date_of(const std::string& bytes) const = 0;
  /// The file as it should be; empty where nothing is in force.
  Expected<std::optional<std::string>> text_in_force(const Ledger& ledger) const;

 private:
  bool file_has(const std::string& text) const;
};

/// The date of bytes that such a reader of calibration files takes.
///
/// In     parse: of the bytes, and the file's name in messages
template <class Parse>
std::optional<std::chrono::sys_seconds> date_by(const Parse& parse, const std::string& bytes) {
  const auto calibration = parse(bytes, "");
  if (!calibration) return std::nullopt;
  return calibration->date;
}

}  // namespace panelcal::internal
