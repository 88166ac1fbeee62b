// write_sample_file PATH: writes a recording with all that a recording may hold, for mcap_readers.py to read back with
// other people's readers.
#include <cstdio>

#include "foxglove/SceneUpdate.pb.h"
#include "record/schemas.h"
#include "tests/record/support.h"

namespace {

/// A triangle on a frame.
std::string scene() {
  foxglove::SceneUpdate scene;
  foxglove::SceneEntity& entity = *scene.add_entities();
  entity.set_id("arm/link");
  entity.set_frame_id("tool");
  entity.set_frame_locked(true);
  foxglove::TriangleListPrimitive& triangle = *entity.add_triangles();
  triangle.mutable_color()->set_g(0.5);
  for (const double x : {0.0, 1.0, 2.0}) triangle.add_points()->set_x(x);
  for (const std::uint32_t index : {0U, 1U, 2U}) triangle.add_indices(index);
  return scene.SerializeAsString();
}

}  // namespace

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
  auto recorder = record::Recorder::open(arguments[1], options).value();
  recorder->add_constant("/scene", record::kSceneUpdateSchema, scene());
  record::SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < 240; ++k) run.cycle(k);
  const std::string error = recorder->close().error;
  if (!error.empty()) std::fprintf(stderr, "%s\n", error.c_str());
  return error.empty() ? 0 : 1;
}
