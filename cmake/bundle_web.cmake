# SPDX-License-Identifier: Apache-2.0
# cmake -D WEB=folder -D MODULES=a.js,b.js -D STYLES=a.css,b.css [-D PAGE=a.html] -D NAME=kFrontEnd
#       -D HEADER=file.h -D OUTPUT=file.cc -P bundle_web.cmake
#
# Joins the modules of a front end to one script: the lines `import ... from` and the words `export`
# go, since all top-level names are unique (tests/web/modules_test.py). Writes it, the style sheets and
# the page as the constants that the header declares: kFrontEndScript, kFrontEndStyle, kFrontEndPage.
# Needs nothing but CMake.

# Raw string literals of at most this many characters, which every compiler takes.
set(PIECE 12000)

function(append_constant name text)
  file(APPEND "${OUTPUT}.new" "const std::string_view ${NAME}${name} =\n")
  string(LENGTH "${text}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} ${PIECE} piece)
    # Between lines, so that no character is cut in two.
    string(FIND "${piece}" "\n" end REVERSE)
    math(EXPR end "${end} + 1")
    string(SUBSTRING "${piece}" 0 ${end} piece)
    file(APPEND "${OUTPUT}.new" "R\"panelcal(${piece})panelcal\"\n")
    math(EXPR at "${at} + ${end}")
  endwhile()
  file(APPEND "${OUTPUT}.new" ";\n\n")
endfunction()

string(REPLACE "," ";" MODULES "${MODULES}")
set(script "\"use strict\";(() => {\n")
foreach(module IN LISTS MODULES)
  file(READ "${WEB}/${module}" text)
  string(REGEX REPLACE "(^|\n)import [^;]*from \"[^\"]*\";" "\\1" text "${text}")
  string(REGEX REPLACE "(^|\n)export " "\\1" text "${text}")
  # Each report carries the script: without comments it is a fifth shorter.
  string(REGEX REPLACE "/\\*\\*([^*]|\\*[^/])*\\*/ ?" "" text "${text}")
  string(REGEX REPLACE "\n *//[^\n]*" "" text "${text}")
  string(REGEX REPLACE "\n\n+" "\n" text "${text}")
  string(APPEND script "${text}")
endforeach()
string(APPEND script "})();\n")
string(REPLACE "," ";" STYLES "${STYLES}")
foreach(sheet IN LISTS STYLES)
  file(READ "${WEB}/${sheet}" text)
  string(APPEND style "${text}")
endforeach()
# Markup that would end the script or the style sheet inside the page.
if("${script}${style}" MATCHES "</script|</style|<!--|\\)panelcal\"")
  message(FATAL_ERROR "web/: \"${CMAKE_MATCH_0}\" cannot stand in a page; write it in two pieces")
endif()

file(WRITE "${OUTPUT}.new"
     "// Made by cmake/bundle_web.cmake.\n#include \"${HEADER}\"\n\n"
     # The standard asks for no more than 65536 characters; every compiler that we use takes more.
     "#pragma GCC diagnostic ignored \"-Woverlength-strings\"\n\nnamespace panelcal {\n\n")
append_constant(Script "${script}")
append_constant(Style "${style}")
if(PAGE)
  file(READ "${WEB}/${PAGE}" page)
  append_constant(Page "${page}")
endif()
file(APPEND "${OUTPUT}.new" "}  // namespace panelcal\n")
file(RENAME "${OUTPUT}.new" "${OUTPUT}")
