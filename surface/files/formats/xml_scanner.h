// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "surface/files/text_fields.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// `<name a="1">` or `<name a="1"/>`.
struct XmlTag {
  TextField name;
  std::vector<std::pair<TextField, TextField>> attributes;  ///< names and values
  bool is_empty = false;

  /// Fails  measurement-file: there is no such attribute
  Expected<TextField> attribute(const std::string& file, std::string_view key) const;
};

/// Walks over XML of elements, attributes and texts that need no entities. Prolog and comments are
/// passed over; a declaration of a document type is not, nor is anything else that could expand.
///
/// Each step fails with measurement-file at the first byte that does not fit.
class XmlScanner {
 public:
  XmlScanner(std::string_view text, std::string file);

  /// True if `</` comes next, behind blanks and comments.
  Expected<bool> at_end_tag();
  Expected<XmlTag> start_tag();
  Expected<void> end_tag(std::string_view name);
  /// The text up to the next tag, without the blanks around it.
  Expected<TextField> text();
  /// That nothing but blanks and comments is left.
  Expected<void> end();

  const std::string& file() const { return file_; }

 private:
  TextField here(std::size_t n_bytes) const;
  Diagnostic unexpected(std::string expected) const;
  void advance(std::size_t n_bytes);
  void skip_blanks();
  /// Blanks, comments and, at the beginning, `<?xml ... ?>`.
  Expected<void> skip_misc();
  Expected<void> skip_to(std::string_view end);
  Expected<TextField> name();
  Expected<TextField> quoted_value();

  std::string_view rest_;
  std::string file_;
  int line_ = 1;
  int column_ = 1;
};

}  // namespace panelcal::internal
