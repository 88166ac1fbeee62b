#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/record/support.h"

namespace takt::record {
namespace {

// Not a test by itself: mcap_readers.py lets it write the file that other people's readers then have to understand.
TEST(ForeignFile, IsWrittenForOtherReaders) {
  const char* path = std::getenv("TAKT_FOREIGN_FILE");
  if (path == nullptr) GTEST_SKIP() << "mcap_readers.py sets TAKT_FOREIGN_FILE";
  RecorderOptions options;
  options.metadata = {{"scenario", "touch"}};
  options.fingerprint = fingerprint({{"mujoco", "4.0.1"}});
  options.attachments = {{"scenario.json", "application/json", "{\"seed\": 7}"}};
  options.chunk_time = 50 * kMillisecond;
  EXPECT_EQ(record_run(path, 240, options).error, "");
}

}  // namespace
}  // namespace takt::record
