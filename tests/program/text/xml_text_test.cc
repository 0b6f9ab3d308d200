// SPDX-License-Identifier: Apache-2.0
#include "program/text/xml_text.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::string xml(std::string_view text) {
  std::string out;
  append_xml_text(out, text);
  return out;
}

TEST(XmlText, EscapesMarkup) {
  EXPECT_EQ(xml("<a href=\"b\">&'"), "&lt;a href=&quot;b&quot;&gt;&amp;&#39;");
}

TEST(XmlText, KeepsUtf8) {
  EXPECT_EQ(xml("\xC3\xBC \xE2\x82\xAC \xF0\x9F\x9B\xA0"),
            "\xC3\xBC \xE2\x82\xAC \xF0\x9F\x9B\xA0");
}

TEST(XmlText, ReplacesWhatXmlCannotHold) {
  EXPECT_EQ(xml(std::string_view("a\0b\x1F\x7F", 5)), "a?b??");
  EXPECT_EQ(xml("\xFF\xC3(\xED\xA0\x80"),
            "?"
            "?(???");
  EXPECT_EQ(xml("\xEF\xBF\xBF\xEF\xBF\xBD"), "?\xEF\xBF\xBD");
  EXPECT_EQ(xml("a\tb\n"), "a\tb\n");
}

}  // namespace
}  // namespace panelcal
