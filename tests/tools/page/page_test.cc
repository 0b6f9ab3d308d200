// SPDX-License-Identifier: Apache-2.0
#include "tools/page/page.h"

#include <cstddef>
#include <string>
#include <string_view>

#include "calib/base/json/facts.h"
#include "tools/page/front_end.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using facts::Json;
using ::testing::HasSubstr;
using ::testing::Not;

/// Text of the script element that has an id.
std::string embedded(const std::string& page, const std::string& id) {
  const std::string begin = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t at = page.find(begin);
  if (at == std::string::npos) return {};
  const std::size_t from = at + begin.size();
  return page.substr(from, page.find("</script>", from) - from);
}

TEST(Page, HoldsItsFactsWhole) {
  const Json document = {{"facts", "job"}, {"name", "a </script><!-- b"}, {"size_mm", 0.125}};
  const std::string page = page_html("a job", facts::text(document));
  EXPECT_EQ(Json::parse(embedded(page, "facts")), document);
  EXPECT_THAT(embedded(page, "facts"), Not(HasSubstr("<")));
}

TEST(Page, HoldsPicturesByTheirNames) {
  const std::string jpeg = "\xff\xd8\xff\xe0";
  const std::string png = "\x89PNG\r\n\x1a\n";
  const std::string page = page_html("", "{}", {{"7 <b>", jpeg}, {"8", png}});
  const Json pictures = Json::parse(embedded(page, "pictures"));
  EXPECT_EQ(pictures["7 <b>"], "data:image/jpeg;base64," + facts::base64(jpeg));
  EXPECT_EQ(pictures["8"], "data:image/png;base64," + facts::base64(png));
}

TEST(Page, LetsNothingBeLoadedOrRunButItsOwn) {
  const std::string page = page_html("", "{}");
  EXPECT_THAT(page, HasSubstr("content=\"default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, HasSubstr("; style-src 'sha256-"));
  for (const char* forbidden : {"http://", "https://", "unsafe-inline", "src=", "href=\"h"}) {
    std::string rest = page;
    // The name space of SVG is no address that is loaded.
    const std::string name_space = "http://www.w3.org/2000/svg";
    for (std::size_t at = 0; (at = rest.find(name_space)) != std::string::npos;) {
      rest.erase(at, name_space.size());
    }
    EXPECT_THAT(rest, Not(HasSubstr(forbidden)));
  }
}

TEST(Page, KeepsMarkupOutOfItsTitle) {
  const std::string page = page_html("</title><script>alert(1)</script>&\xff\n", "{}");
  EXPECT_THAT(page, HasSubstr("<title>?/title??script?alert(1)?/script??\xef\xbf\xbd?</title>"));
}

TEST(FrontEnd, IsOneScriptWithoutImports) {
  EXPECT_TRUE(kFrontEndScript.starts_with("\"use strict\";(() => {\n"));
  EXPECT_TRUE(kFrontEndScript.ends_with("})();\n"));
  EXPECT_EQ(kFrontEndScript.find("\nimport "), std::string_view::npos);
  EXPECT_EQ(kFrontEndScript.find("\nexport "), std::string_view::npos);
  EXPECT_NE(kFrontEndStyle.find("prefers-color-scheme: dark"), std::string_view::npos);
}

}  // namespace
}  // namespace panelcal
