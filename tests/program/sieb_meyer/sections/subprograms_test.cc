// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/subprograms.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

namespace panelcal::sieb_meyer {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

using Folders = std::vector<std::filesystem::path>;

/// A folder that goes away with the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "panelcal-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// `NAME in FILE` for every subprogram that was found, by names.
std::vector<std::string> found(std::string_view program, const Folders& folders) {
  std::vector<std::string> out;
  for (const auto& [name, text] : read_subprograms(program, folders)) {
    EXPECT_TRUE(find_subprogram(text.bytes, name)) << name;
    out.push_back(name + " in " + std::filesystem::path(text.file).filename().string());
  }
  return out;
}

/// The lines of a subprogram and the number of the first, as `3: X1.Y1.`
std::string lines_of(std::string_view bytes, std::string_view name) {
  const auto body = find_subprogram(bytes, name);
  if (!body) return "none";
  return std::to_string(body->begin.number) + ": " +
         std::string(bytes.substr(body->begin.offset, body->end - body->begin.offset));
}

// --- names ---------------------------------------------------------------------------------------

TEST(SubprogramName, IsOfCapitalLettersAndDigits) {
  for (const char* const name :
       {"A", "FINAL", "7", "P001", "EXAMPLE-SUBPROGRAM", "A_B", "A.B", "A+B", "#1", "A&B"}) {
    EXPECT_TRUE(is_subprogram_name(name)) << name;
  }
  EXPECT_TRUE(is_subprogram_name(std::string(128, 'A')));
}

TEST(SubprogramName, IsNoPathAndNothingHidden) {
  for (const char* const name : {"",
                                 ".",
                                 "..",
                                 ".HIDDEN",
                                 "../A",
                                 "A/B",
                                 "/A",
                                 "A\\B",
                                 "C:A",
                                 "A B",
                                 "A,B",
                                 "A(B)",
                                 "@A",
                                 "A*",
                                 "A?",
                                 "A\t",
                                 "\xC4"}) {
    EXPECT_FALSE(is_subprogram_name(name)) << name;
  }
  EXPECT_FALSE(is_subprogram_name(std::string_view("A\0B", 3)));
  EXPECT_FALSE(is_subprogram_name(std::string(129, 'A')));
}

// --- where it stands in its file -----------------------------------------------------------------

TEST(SubprogramText, LiesBehindItsNameUpToTheNextOne) {
  const std::string file = "%%5000\n@RESET\nM49,NOFA\nM49,NORA\n@FINAL\nXYT99\nX1.Y\n";
  EXPECT_EQ(lines_of(file, "RESET"), "3: M49,NOFA\nM49,NORA\n");
  EXPECT_EQ(lines_of(file, "FINAL"), "6: XYT99\nX1.Y\n");
  EXPECT_EQ(lines_of(file, "OTHER"), "none");
  EXPECT_EQ(lines_of("", "A"), "none");
}

TEST(SubprogramText, EndsAtADollar) {
  EXPECT_EQ(lines_of("@A\nX1.Y1.\n$\nT1D1.\n$\n", "A"), "2: X1.Y1.\n");
  EXPECT_EQ(lines_of("@A\nX1.Y1.M97,A$B@C\n", "A"), "2: X1.Y1.M97,A$B@C\n");
}

TEST(SubprogramText, MayBeEmpty) {
  EXPECT_EQ(lines_of("@A\n@B\n", "A"), "2: ");
  EXPECT_EQ(lines_of("@A", "A"), "2: ");
}

TEST(SubprogramText, HasTheWholeName) {
  EXPECT_EQ(lines_of("@AB\nX1.\n@A\nX2.\n", "A"), "4: X2.\n");
  EXPECT_EQ(lines_of("@a\nX1.\n", "A"), "none");
}

TEST(SubprogramText, IsTheFirstOfThatName) {
  EXPECT_EQ(lines_of("@A\nX1.\n@A\nX2.\n", "A"), "2: X1.\n");
}

TEST(SubprogramText, MayHaveBlanksRoundItsName) {
  EXPECT_EQ(lines_of("  @ A \r\nX1.\r\n", "A"), "2: X1.\r\n");
}

// --- which files are read ------------------------------------------------------------------------

/// "The file name and the subprogram name are the same (except for @)."
TEST(ReadSubprograms, AreInFilesOfTheirName) {
  const Folder folder;
  folder.write("A.SS5", "@A\nX1.Y1.\n");
  folder.write("B.ss5", "@B\nX1.Y1.\n");
  folder.write("C", "@C\nX1.Y1.\n");
  EXPECT_THAT(found("XYM99,A\nXYM99,B\nXYM99,C\n", {folder.path()}),
              ElementsAre("A in A.SS5", "B in B.ss5", "C in C"));
}

TEST(ReadSubprograms, TheFileNameWithTheManualsExtensionComesFirst) {
  const Folder folder;
  folder.write("A", "@A\n");
  folder.write("A.ss5", "@A\n");
  EXPECT_THAT(found("M99,A\n", {folder.path()}), ElementsAre("A in A.ss5"));
  folder.write("A.SS5", "@A\n");
  EXPECT_THAT(found("M99,A\n", {folder.path()}), ElementsAre("A in A.SS5"));
}

/// "According to the CNC configuration a subprogram file can include one or several subprograms."
TEST(ReadSubprograms, AreInFilesOfSeveral) {
  const Folder folder;
  folder.write("TOOLING.SS5", "@RESET\nM49,NOFA\n@FINAL\nXYT99\n");
  EXPECT_THAT(found("M99,RESET\nXYM99,FINAL\nM99,RESET\n", {folder.path()}),
              ElementsAre("FINAL in TOOLING.SS5", "RESET in TOOLING.SS5"));
}

TEST(ReadSubprograms, TheFileOfItsNameGoesBeforeOthers) {
  const Folder folder;
  folder.write("AAA.SS5", "@B\n");
  folder.write("B.SS5", "@B\n");
  EXPECT_THAT(found("M99,B\n", {folder.path()}), ElementsAre("B in B.SS5"));
}

TEST(ReadSubprograms, OtherFilesAreSearchedInAlphabeticalOrder) {
  const Folder folder;
  folder.write("Z.SS5", "@B\n");
  folder.write("M.ss5", "@B\n");
  folder.write("A.SS5", "@C\n");
  folder.write("A.TXT", "@B\n");
  EXPECT_THAT(found("M99,B\n", {folder.path()}), ElementsAre("B in M.ss5"));
}

TEST(ReadSubprograms, AFileOfItsNameWithoutItIsPassedOver) {
  const Folder folder;
  folder.write("B.SS5", "X1.Y1.\n");
  folder.write("C.SS5", "@B\n");
  EXPECT_THAT(found("M99,B\n", {folder.path()}), ElementsAre("B in C.SS5"));
}

TEST(ReadSubprograms, AnEarlierFolderGoesBeforeALaterOne) {
  const Folder first;
  const Folder second;
  first.write("ALL.SS5", "@A\n");
  second.write("A.SS5", "@A\n");
  second.write("B.SS5", "@B\n");
  EXPECT_THAT(found("M99,A\nM99,B\n", {first.path(), second.path()}),
              ElementsAre("A in ALL.SS5", "B in B.SS5"));
}

TEST(ReadSubprograms, AreReadWithTheWholeFile) {
  const Folder folder;
  const std::string text = "@RESET\nM49,NOFA\n@A\nX1.Y1.\n";
  folder.write("ALL.SS5", text);
  const auto texts = read_subprograms("M99,A\n", {folder.path()});
  ASSERT_TRUE(texts.contains("A"));
  EXPECT_EQ(texts.find("A")->second.bytes, text);
  EXPECT_EQ(texts.find("A")->second.file, (folder.path() / "ALL.SS5").string());
}

TEST(ReadSubprograms, OnlyCalledOnesAreRead) {
  const Folder folder;
  folder.write("ALL.SS5", "@A\nX1.\n@B\nX2.\n");
  EXPECT_THAT(found("X1.Y1.M99 , A \r\nM97,B\nM9,B\nM99\n", {folder.path()}),
              ElementsAre("A in ALL.SS5"));
  EXPECT_THAT(found("", {folder.path()}), IsEmpty());
}

// --- calls of calls ------------------------------------------------------------------------------

/// "A subprogram may call another subprogram."
TEST(ReadSubprograms, CallsAreFollowed) {
  const Folder folder;
  folder.write("A.SS5", "@A\nX1.Y1.M99,B\n");
  folder.write("B.SS5", "@B\nM99,C\n");
  folder.write("C.SS5", "@C\nX1.Y1.\n");
  EXPECT_THAT(found("M99,A\n", {folder.path()}),
              ElementsAre("A in A.SS5", "B in B.SS5", "C in C.SS5"));
}

/// A subprogram that another one of the same file calls is not asked for.
TEST(ReadSubprograms, CallsOfNeighborsAreNotFollowed) {
  const Folder folder;
  folder.write("ALL.SS5", "@A\nM99,D\n@B\nX1.\n@C\nM99,D\n");
  folder.write("D.SS5", "@D\nX1.\n");
  EXPECT_THAT(found("M99,B\n", {folder.path()}), ElementsAre("B in ALL.SS5"));
}

TEST(ReadSubprograms, CirclesOfCallsEnd) {
  const Folder folder;
  folder.write("ALL.SS5", "@A\nM99,B\n@B\nM99,A\nM99,B\n");
  EXPECT_THAT(found("M99,A\n", {folder.path()}), ElementsAre("A in ALL.SS5", "B in ALL.SS5"));
}

// --- what is not there ---------------------------------------------------------------------------

TEST(FilesReadForSubprograms, AreThoseBeforeTheOneThatHasIt) {
  const Folder folder;
  folder.write("A.SS5", "@A\nX1.Y1.\n");
  folder.write("B.SS5", "@B\nX1.Y1.\n@C\nX1.Y1.\n");
  folder.write("D.SS5", "@D\nX1.Y1.\n");
  folder.write("other.txt", "@C\n");
  EXPECT_THAT(files_read_for_subprograms("X1.Y1.\nM99,C\n", {folder.path()}),
              ElementsAre(folder.path() / "A.SS5", folder.path() / "B.SS5"));
  EXPECT_THAT(files_read_for_subprograms("X1.Y1.\nM99,D\n", {folder.path()}),
              ElementsAre(folder.path() / "D.SS5"));
  EXPECT_THAT(files_read_for_subprograms("X1.Y1.\n", {folder.path()}), IsEmpty());
}

TEST(ReadSubprograms, MissingOnesAreLeftOut) {
  const Folder folder;
  folder.write("A.SS5", "@A\nM99,GONE\n");
  EXPECT_THAT(found("M99,LOST\nM99,A\n", {folder.path()}), ElementsAre("A in A.SS5"));
}

TEST(ReadSubprograms, MissingFoldersHaveNone) {
  const Folder folder;
  folder.write("A.SS5", "@A\n");
  EXPECT_THAT(found("M99,A\n", {folder.path() / "GONE", folder.path()}), ElementsAre("A in A.SS5"));
  EXPECT_THAT(found("M99,A\n", {folder.path() / "A.SS5"}), IsEmpty());
  EXPECT_THAT(found("M99,A\n", {}), IsEmpty());
}

TEST(ReadSubprograms, FoldersAreNoFiles) {
  const Folder folder;
  std::filesystem::create_directory(folder.path() / "A.SS5");
  EXPECT_THAT(found("M99,A\n", {folder.path()}), IsEmpty());
}

/// A name cannot lead out of the folders.
TEST(ReadSubprograms, NamesThatAreNoneAreNotLookedFor) {
  const Folder folder;
  const std::filesystem::path inner = folder.path() / "INNER";
  std::filesystem::create_directory(inner);
  folder.write("A.SS5", "@../A\n@A\n");
  EXPECT_THAT(found("M99,../A\n", {inner}), IsEmpty());
  folder.write("INNER/ALL.SS5", "@../A\n@A B\n");
  EXPECT_THAT(found("M99,../A\nM99,A B\nM99,\n", {inner}), IsEmpty());
}

}  // namespace
}  // namespace panelcal::sieb_meyer
