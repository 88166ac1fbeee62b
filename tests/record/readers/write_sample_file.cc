// write_sample_file PATH: writes a recording with all that a recording may hold, for mcap_readers.py to read back with
// other people's readers.
#include <cstdio>

#include "tests/record/support.h"

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: write_sample_file PATH\n", stderr);
    return 2;
  }
  using namespace takt;
  record::RecorderOptions options;
  options.metadata = {{"scenario", "touch"}};
  options.fingerprint = record::fingerprint({{"mujoco", "4.0.1"}});
  options.attachments = {{"scenario.json", "application/json", "{\"seed\": 7}"}};
  options.chunk_time = 50 * kMillisecond;
  const std::string error = record::record_run(arguments[1], 240, options).error;
  if (!error.empty()) std::fprintf(stderr, "%s\n", error.c_str());
  return error.empty() ? 0 : 1;
}
