#include "core/base/output_file.h"
#include "tests/support/reports.h"

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace takt {
namespace {

using takt::test::Reports;

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

class OutputFile : public testing::Test {
 protected:
  const TemporaryFolder folder_ = *TemporaryFolder::create();
  const fs::path file_ = folder_.path() / "out.txt";
};

TEST_F(OutputFile, ReplacesAFileAndKeepsItsMode) {
  EXPECT_TRUE(write_file(file_, "first").empty());
  fs::permissions(file_, fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(write_file(file_, "second").empty());
  EXPECT_EQ(content_of(file_), "second");
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(entries(folder_.path()), 1u);
}

TEST_F(OutputFile, ALinkStaysALink) {
  fs::create_symlink(file_, folder_.path() / "link");
  ASSERT_TRUE(write_file(file_, "first").empty());
  EXPECT_TRUE(write_file(folder_.path() / "link", "second").empty());
  EXPECT_TRUE(fs::is_symlink(folder_.path() / "link"));
  EXPECT_EQ(content_of(file_), "second");
}

TEST_F(OutputFile, AFullDiskLeavesWhatWasThereAndNothingElse) {
  ASSERT_TRUE(write_file(file_, "before").empty());
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 1000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const Diagnostics diagnostics = write_file(file_, std::string(5000, 'x'), "--report");
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_TRUE(diagnostics.has_errors());
  EXPECT_THAT(diagnostics, Reports(Code::kFileNotWritable, "--report"));
  EXPECT_EQ(content_of(file_), "before");
  EXPECT_EQ(entries(folder_.path()), 1u);
}

TEST_F(OutputFile, DevicesAreWrittenAndAFifoWithoutReaderIsRefused) {
  EXPECT_TRUE(write_file("/dev/null", "text").empty());
  EXPECT_TRUE(write_file("/dev/full", "text").has_errors());
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  EXPECT_TRUE(write_file(file_, "text").has_errors());
  EXPECT_TRUE(fs::is_fifo(file_));
}

TEST_F(OutputFile, MissingFolderIsNamed) {
  const Diagnostics diagnostics = write_file(folder_.path() / "none" / "a", "text");
  EXPECT_THAT(diagnostics, Reports(Code::kFileNotWritable, ""));
}

TEST_F(OutputFile, WhatIsReadIsNotOverwritten) {
  ASSERT_TRUE(write_file(file_, "input").empty());
  EXPECT_TRUE(check_output(folder_.path() / "new", {file_}).empty());
  EXPECT_TRUE(check_output(folder_.path() / "." / "out.txt", {file_}).has_errors());
  EXPECT_TRUE(check_output(folder_.path(), {}).has_errors());
  EXPECT_TRUE(check_output(file_, {}).empty());
  const fs::path fifo = folder_.path() / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_TRUE(check_output(fifo, {}).has_errors());
}

/// Found before the work whose report it is to be, not after it.
TEST_F(OutputFile, WhatCannotBeWrittenIsRefusedBeforehand) {
  EXPECT_THAT(check_output(folder_.path() / "none" / "a", {}, "--report"), Reports(Code::kFileNotWritable, "--report"));
  EXPECT_TRUE(check_output("a name without a folder", {}).empty());
  EXPECT_TRUE(check_output("/dev/null", {}).empty());
  if (geteuid() == 0) return;  // who may write everywhere
  fs::permissions(folder_.path(), fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_TRUE(check_output(folder_.path() / "a", {}).has_errors());
  fs::permissions(folder_.path(), fs::perms::owner_all);
}

/// What a handler of a signal calls: files and folders with all that is in them, but not those of another process.
TEST_F(OutputFile, WhatIsNotWholeGoesWithTheProcess) {
  const auto file = TemporaryFile::create(".mcap");
  const auto folder = TemporaryFolder::create();
  ASSERT_TRUE(file && folder);
  fs::create_directories(folder->path() / "deep" / "deeper");
  for (int i = 0; i < 300; ++i)
    ASSERT_TRUE(write_file(folder->path() / "deep" / ("file " + std::to_string(i)), "text").empty());
  const pid_t child = fork();
  if (child == 0) {
    remove_unfinished();
    _exit(0);
  }
  ASSERT_GT(child, 0);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(fs::exists(file->path()) && fs::exists(folder->path() / "deep" / "file 7")) << "they are not the child's";
  const fs::path whole = fs::path(testing::TempDir()) / "whole.txt";
  { const Unfinished finished(whole); }
  ASSERT_TRUE(write_file(whole, "whole").empty());
  remove_unfinished();
  EXPECT_FALSE(fs::exists(file->path()));
  EXPECT_FALSE(fs::exists(folder->path()));
  EXPECT_FALSE(fs::exists(folder_.path())) << "of the fixture: the same";
  EXPECT_EQ(content_of(whole), "whole");
  fs::remove(whole);
}

TEST_F(OutputFile, TemporariesHaveNamesOfTheirOwnAndGo) {
  fs::path first, second;
  {
    const auto a = TemporaryFile::create(".mcap"), b = TemporaryFile::create(".mcap");
    ASSERT_TRUE(a && b);
    first = a->path();
    second = b->path();
    EXPECT_NE(first, second);
    EXPECT_TRUE(fs::exists(first));
    EXPECT_EQ(first.extension(), ".mcap");
  }
  EXPECT_FALSE(fs::exists(first) || fs::exists(second));
}

TEST_F(OutputFile, AFolderForTemporariesThatIsNotThereIsNamed) {
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", (folder_.path() / "none").c_str(), 1);
  const auto file = TemporaryFile::create(".mcap");
  const auto folder = TemporaryFolder::create();
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  ASSERT_FALSE(file || folder);
  EXPECT_THAT(file.error(), Reports(Code::kFileNotWritable, "", {"TMPDIR"}));
}

}  // namespace
}  // namespace takt
