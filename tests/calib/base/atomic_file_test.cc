// SPDX-License-Identifier: Apache-2.0
#include "calib/base/atomic_file.h"

#include <csignal>
#include <cstdlib>
#include <vector>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

/// An empty folder of its own for every test.
class AtomicFileTest : public testing::Test {
 protected:
  AtomicFileTest() {
    std::string pattern = testing::TempDir() + "atomic_file_test_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
  }
  ~AtomicFileTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path target() const { return folder_ / "out.drl"; }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  std::filesystem::path folder_;
};

using ReadFileTest = AtomicFileTest;

TEST_F(AtomicFileTest, AppearsOnlyOnCommit) {
  Expected<AtomicFile> file = AtomicFile::create(target());
  ASSERT_TRUE(file) << file.error().text();
  ASSERT_TRUE(file->write("M48\n"));
  EXPECT_FALSE(std::filesystem::exists(target()));
  ASSERT_TRUE(file->write("M30\n"));
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(read_file(target()).value(), "M48\nM30\n");
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

TEST_F(AtomicFileTest, WithoutCommitTheOldContentStays) {
  ASSERT_TRUE(write_file(target(), "old"));
  {
    Expected<AtomicFile> file = AtomicFile::create(target());
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(std::string(std::size_t{1} << 20, 'n')));
  }
  EXPECT_EQ(read_file(target()).value(), "old");
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

TEST_F(AtomicFileTest, ReplacesTheOldContent) {
  ASSERT_TRUE(write_file(target(), "old and longer"));
  ASSERT_TRUE(write_file(target(), "new"));
  EXPECT_EQ(read_file(target()).value(), "new");
}

TEST_F(AtomicFileTest, MovedFromFilesDoNothing) {
  Expected<AtomicFile> file = AtomicFile::create(target());
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write("moved"));
  {
    AtomicFile other = *std::move(file);
    ASSERT_TRUE(other.commit());
  }
  EXPECT_EQ(read_file(target()).value(), "moved");
}

TEST_F(AtomicFileTest, WritesMoreThanItsBuffer) {
  std::string text;
  for (int i = 0; i < 200000; ++i) text += std::to_string(i) + '\n';
  Expected<AtomicFile> file = AtomicFile::create(target());
  ASSERT_TRUE(file);
  for (std::size_t at = 0; at < text.size(); at += 1000) {
    ASSERT_TRUE(file->write(std::string_view(text).substr(at, 1000)));
  }
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(read_file(target()).value(), text);
}

TEST_F(AtomicFileTest, HasTheRightsOfAnOrdinaryFile) {
  const mode_t kept = ::umask(027);
  const Expected<void> written = write_file(target(), "x");
  ::umask(kept);
  ASSERT_TRUE(written);
  struct stat status {};
  ASSERT_EQ(::stat(target().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640U);
}

TEST_F(AtomicFileTest, RefusesAMissingFolder) {
  EXPECT_THAT(write_file(folder_ / "none" / "out.drl", "x"),
              FailsWith(Code::DeviceWrite, "No such file"));
}

TEST_F(AtomicFileTest, RefusesAFolderAsTarget) {
  EXPECT_THAT(write_file(folder_, "x"), FailsWith(Code::DeviceWrite, "Is a directory"));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(AtomicFileTest, RefusesATargetThatBecameAFolder) {
  Expected<AtomicFile> file = AtomicFile::create(target());
  ASSERT_TRUE(file);
  std::filesystem::create_directory(target());
  {
    AtomicFile inner = *std::move(file);
    EXPECT_THAT(inner.commit(), FailsWith(Code::DeviceWrite));
  }
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

/// Runs `body` in a child whose files may not grow beyond 64 KiB, as on a disk that runs full.
/// True if the child's body returned true.
bool on_a_full_disk(const std::function<bool()>& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    // Ignored, the signal becomes the error EFBIG of write().
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {65536, 65536};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) std::_Exit(3);
    std::_Exit(body() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(AtomicFileTest, AFullDiskLeavesTheOldFileAndNoTemporary) {
  ASSERT_TRUE(write_file(target(), "old"));
  EXPECT_TRUE(on_a_full_disk([&] {
    const Expected<void> written = write_file(target(), std::string(std::size_t{1} << 20, 'n'));
    return !written && written.error().code == Code::DeviceWrite;
  }));
  EXPECT_EQ(read_file(target()).value(), "old");
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

TEST_F(AtomicFileTest, AFullDiskShowsAtCommitToo) {
  // The second piece waits in the buffer, and the disk has no room for it.
  EXPECT_TRUE(on_a_full_disk([&] {
    Expected<AtomicFile> file = AtomicFile::create(target());
    const std::string piece(60000, 'n');
    return file && file->write(piece) && file->write(piece) && !file->commit() && !file->commit();
  }));
  // The child ended without destructors, as in a crash: only a temporary file may remain.
  EXPECT_FALSE(std::filesystem::exists(target()));
}

TEST_F(ReadFileTest, ReadsAnyBytes) {
  const std::string bytes("\0\r\n\xff text", 9);
  ASSERT_TRUE(write_file(target(), bytes));
  EXPECT_EQ(read_file(target()).value(), bytes);
  ASSERT_TRUE(write_file(target(), ""));
  EXPECT_EQ(read_file(target()).value(), "");
}

TEST_F(ReadFileTest, SaysWhatIsWrong) {
  EXPECT_THAT(read_file(folder_ / "missing"),
              FailsWith(Code::FileUnreadable, "missing: error[file-unreadable]: "));
  EXPECT_THAT(read_file(folder_), FailsWith(Code::FileUnreadable));
}

TEST_F(ReadFileTest, StopsAtItsLimit) {
  ASSERT_TRUE(write_file(target(), "123456"));
  EXPECT_TRUE(read_file(target(), 6));
  EXPECT_THAT(read_file(target(), 5), FailsWith(Code::FileUnreadable, " 5 bytes"));
  EXPECT_THAT(read_file("/dev/zero", 1000), FailsWith(Code::FileUnreadable, " 1000 bytes"));
}

TEST_F(ReadFileTest, ReadsPipes) {
  const std::filesystem::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    FILE* out = std::fopen(pipe.c_str(), "w");
    std::fputs("through a pipe", out);
    std::fclose(out);
    std::_Exit(0);
  }
  EXPECT_EQ(read_file(pipe).value(), "through a pipe");
  ::waitpid(child, nullptr, 0);
}

}  // namespace
}  // namespace panelcal
