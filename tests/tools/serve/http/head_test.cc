// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/http/head.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal::serve {
namespace {

TEST(RequestHead, IsReadAsItWasSent) {
  const auto head = parse_head(
      "POST /api/programs?name=a%20b HTTP/1.1\r\nHost: 127.0.0.1:8330\r\nX-Empty:\r\n"
      "Cookie: \t a=%41; b \t \r\n\r\n");
  ASSERT_TRUE(head);
  EXPECT_EQ(head->request.method, "POST");
  EXPECT_EQ(head->request.target, "/api/programs?name=a%20b");
  ASSERT_EQ(head->request.headers.size(), 3U);
  EXPECT_EQ(head->request.header("HOST"), "127.0.0.1:8330");
  EXPECT_EQ(head->request.n_headers("x-empty"), 1U);
  EXPECT_EQ(head->request.header("x-empty"), "");
  EXPECT_EQ(head->request.header("cookie"), "a=%41; b");
  EXPECT_FALSE(head->closes);
}

TEST(RequestHead, StatesWhetherAnotherRequestFollows) {
  EXPECT_TRUE(parse_head("GET / HTTP/1.1\r\nConnection: close\r\n\r\n")->closes);
  EXPECT_TRUE(parse_head("GET / HTTP/1.0\r\n\r\n")->closes);
  EXPECT_FALSE(parse_head("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n")->closes);
}

// RFC 9112, sections 2.2, 3, 5.1 and 5.2.
TEST(RequestHead, IsRefusedWhereItCouldBeReadInTwoWays) {
  const std::string begin = "GET / HTTP/1.1\r\n";
  for (const std::string& lines : {std::string(),
                                   std::string("\n"),
                                   std::string("Content-Length: 60\n\r\n"),
                                   std::string("Host: a\rOrigin: b\r\n\r\n"),
                                   std::string("Content-Length : 60\r\n\r\n"),
                                   std::string(" Host: a\r\n\r\n"),
                                   std::string("Host: a\r\n b\r\n\r\n"),
                                   std::string(": a\r\n\r\n"),
                                   std::string("no colon\r\n\r\n"),
                                   std::string("H\xc3\xb6st: a\r\n\r\n"),
                                   std::string("Host: a\0b\r\n\r\n", 13),
                                   std::string("Host: a\x7f\r\n\r\n"),
                                   std::string("\r\nGET / HTTP/1.1\r\n\r\n")}) {
    EXPECT_FALSE(parse_head(begin + lines)) << testing::PrintToString(lines);
  }
  for (const std::string& line : {std::string(),
                                  std::string("GET  / HTTP/1.1"),
                                  std::string("GET / HTTP/1.1 "),
                                  std::string(" GET / HTTP/1.1"),
                                  std::string("GET /a b HTTP/1.1"),
                                  std::string("GET /\tb HTTP/1.1"),
                                  std::string("GET HTTP/1.1"),
                                  std::string("GET / HTTP/2.0"),
                                  std::string("GET / http/1.1"),
                                  std::string("G(T / HTTP/1.1"),
                                  std::string("GET /")}) {
    EXPECT_FALSE(parse_head(line + "\r\n\r\n")) << line;
  }
  EXPECT_FALSE(parse_head(""));
  EXPECT_FALSE(parse_head("GET / HTTP/1.1\n\n"));
}

}  // namespace
}  // namespace panelcal::serve
