#include "tools/failure_film.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace takt::tools {
namespace {

namespace fs = std::filesystem;
using Way = cell::Interruptions::Way;

/// Frames of a film at 25 a second, as another program counts them.
int frames_of(const fs::path& film) {
  const std::string count =
      "ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of "
      "default=nw=1:nk=1 '" +
      film.string() + "'";
  std::FILE* out = popen(count.c_str(), "r");
  int frames = -1;
  if (out == nullptr || std::fscanf(out, "%d", &frames) != 1) ADD_FAILURE() << count;
  if (out != nullptr) pclose(out);
  return frames;
}

TEST(FailureFilm, OfAnInterruptionShowsItFromThreeSecondsBeforeToASecondAfterTheEnd) {
  const fs::path folder = fs::path(testing::TempDir()) / "failure_film";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "far.json") << R"({"devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "sequence", "steps": [
      {"do": "wait", "seconds": 4}, {"do": "ptp", "to": {"joints_deg": [90, -30, 0, 60, 0, -60, 0]}, "speed": 0.2}]}})";
  Common common;
  common.root = fs::current_path();
  FailureFilmArguments arguments;
  arguments.folder = (folder / "films").string();
  FailureMoment moment;
  moment.interruption = cell::Interruptions::Case{Way::kCancel, 4500, 1, "something is wrong"};
  const auto film = film_failure(folder / "far.json", moment, arguments, common);
  ASSERT_TRUE(film) << film.error().to_string();
  EXPECT_TRUE(film->filename().string().ends_with("far_cancel_4500.mp4")) << *film;
  // From 1.5 s on; the arm brakes within half a second after 4.5 s, and a second follows.
  EXPECT_GE(frames_of(*film), 25 * 4);
  EXPECT_LE(frames_of(*film), 25 * 5);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace takt::tools
