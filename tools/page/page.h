// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace panelcal {

/// Pictures of a report by the names that its facts know them by: the bytes of PNG, JPEG or WebP.
using PagePictures = std::map<std::string, std::string>;

/// One HTML file that shows a document of facts: the front end of web/, the facts and the pictures.
/// It needs nothing else, and its Content-Security-Policy lets nothing else be loaded or run.
///
/// In     title: any bytes; the front end replaces it by its own
///        facts: as facts::text() writes them
/// Cost   copies; a megabyte of facts takes milliseconds
/// See    tests/tools/page/page_test.cc, tests/web/modules_test.py
std::string page_html(std::string_view title,
                      std::string_view facts,
                      const PagePictures& pictures = {});

}  // namespace panelcal
