// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/atomic_file.h"

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>
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
using testing::UnorderedElementsAre;

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

TEST_F(AtomicFileTest, FilesOfManyThreadsHaveTheRightsOfAnOrdinaryFile) {
  const mode_t kept = ::umask(027);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([this, i] {
      for (int k = 0; k < 1000; ++k) {
        EXPECT_TRUE(AtomicFile::create(folder_ / std::to_string(10000 * i + k)));
      }
    });
  }
  threads.clear();
  // It is the whole process's, so that one moment without it is one too many.
  EXPECT_EQ(::umask(kept), 027U);
}

TEST_F(AtomicFileTest, KeepsTheModeOfTheFileThatItReplaces) {
  ASSERT_TRUE(write_file(target(), "old"));
  for (const mode_t mode : {0600U, 0664U, 0755U}) {
    ASSERT_EQ(::chmod(target().c_str(), mode), 0);
    ASSERT_TRUE(write_file(target(), "new"));
    struct stat status {};
    ASSERT_EQ(::stat(target().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, mode);
  }
}

TEST_F(AtomicFileTest, KeepsTheOwnerOfTheFileThatItReplaces) {
  // Only root may give files away.
  const uid_t owner = ::geteuid() == 0 ? 1234 : ::geteuid();
  const gid_t group = ::geteuid() == 0 ? 5678 : ::getegid();
  ASSERT_TRUE(write_file(target(), "old"));
  ASSERT_EQ(::chown(target().c_str(), owner, group), 0);
  ASSERT_TRUE(write_file(target(), "new"));
  struct stat status {};
  ASSERT_EQ(::stat(target().c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, owner);
  EXPECT_EQ(status.st_gid, group);
}

TEST_F(AtomicFileTest, RefusesADatabase) {
  const std::string database("SQLite format 3\0 and its pages", 31);
  {
    std::ofstream file(target(), std::ios::binary);
    file << database;
  }
  std::filesystem::create_symlink(target(), folder_ / "link.drl");
  std::filesystem::create_hard_link(target(), folder_ / "hard.drl");
  for (const char* const name : {"out.drl", "link.drl", "hard.drl"}) {
    EXPECT_THAT(write_file(folder_ / name, "x"), FailsWith(Code::OutputInUse, name));
  }
  EXPECT_EQ(read_file(target()).value(), database);
  EXPECT_THAT(names(), UnorderedElementsAre("out.drl", "link.drl", "hard.drl"));
}

TEST_F(AtomicFileTest, SweepsWhatDeadProcessesLeft) {
  const std::vector<std::string> leftovers = {"out.drl.part-panelcal-1", "out.drl.part-panelcal-2"};
  for (const std::string& name : leftovers) std::ofstream(folder_ / name) << "cut off";
  ASSERT_TRUE(write_file(target(), "first"));
  ASSERT_TRUE(write_file(target(), "second"));
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

TEST_F(AtomicFileTest, SweepsNoOtherFile) {
  const std::vector<std::string> others = {"out.drl.part-1",
                                           "out.drl.part-backup",
                                           "out.drl.part-panelcal",
                                           "out.drl.part-panelcal-1-kept",
                                           "other.drl.part-panelcal-1"};
  for (const std::string& name : others) std::ofstream(folder_ / name) << "mine";
  std::filesystem::create_directory(folder_ / "out.drl.part-panelcal-1");
  std::filesystem::create_symlink("out.drl.part-1", folder_ / "out.drl.part-panelcal-2");
  ASSERT_TRUE(write_file(target(), "new"));
  EXPECT_EQ(names().size(), others.size() + 3);
  EXPECT_EQ(read_file(folder_ / "out.drl.part-1").value(), "mine");
}

TEST_F(AtomicFileTest, LeavesTheFileOfALivingWriterAlone) {
  Expected<AtomicFile> first = AtomicFile::create(target());
  ASSERT_TRUE(first && first->write("first"));
  EXPECT_THAT(names(), ElementsAre("out.drl.part-panelcal-1"));
  ASSERT_TRUE(write_file(target(), "second"));
  EXPECT_EQ(read_file(target()).value(), "second");
  ASSERT_TRUE(first->commit());
  EXPECT_EQ(read_file(target()).value(), "first");
  EXPECT_THAT(names(), ElementsAre("out.drl"));
}

TEST_F(AtomicFileTest, ManyWritersAtOnceLeaveOneWholeFile) {
  constexpr int kWriters = 8;
  for (int i = 0; i < kWriters; ++i) {
    if (::fork() != 0) continue;
    bool is_good = true;
    const std::string text(1000, static_cast<char>('a' + i));
    for (int k = 0; k < 100; ++k) is_good = is_good && write_file(target(), text);
    std::_Exit(is_good ? 0 : 1);
  }
  for (int i = 0; i < kWriters; ++i) {
    int status = 0;
    ASSERT_GT(::wait(&status), 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  const std::string text = read_file(target()).value();
  EXPECT_EQ(text, std::string(1000, text.front()));
  EXPECT_THAT(names(), ElementsAre("out.drl"));
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
