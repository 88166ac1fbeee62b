// Contact forces as commands of a transaction.
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/expression/moving_frames.h"
#include "core/operations/command_request.h"
#include "core/operations/press_command.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

class ForceCommand final : public CommandRequest {
 public:
  ForceRequest request;

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::Action action = action_of(making);
    PressingCommand pressing = pressing_command(request, name, action, making.cell, making.biases, key);
    MadeCommand made{.command = pressing.command,
                     .action = action,
                     .actuator = command::arm(making.cell, request.arm),
                     .handler_places = std::move(pressing.handler_places)};
    if (request.compliance) made.places = places_of(*request.compliance);
    return made;
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.touched[request.arm] = true;
    rehearsal.duration += request.hold.value_or(0.0);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool cancelled, Context& context,
              Diagnostics& diagnostics) const override {
    const auto kept = [&ended](const std::string& what) { return ended.value<net::Frame>(what); };
    diagnostics.append(end_pressing(request, kept, key, cancelled, context), pointer);
  }

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& making) const {
    if (!request.needs_place() && !moves(making.cell.frames, request.in, request.arm)) {
      const auto prepared = prepare_press(request, making.cell, place_now(making.cell));
      if (prepared) return press_action(request, *prepared, making.cell, making.biases);
    }
    return press_from_anywhere(request, making.cell, making.biases);
  }
  /// Only springs that it does not bring along make a difference: how fast its law is.
  [[nodiscard]] kinematics::JointVector place_now(const command::Cell& cell) const {
    const command::MountedArm& mounted = cell.arms.find(request.arm)->second;
    const kinematics::JointVector& q = mounted.device->set_point().q;
    return q.size() > 0 ? q : mounted.start;
  }
};

}  // namespace

std::unique_ptr<CommandRequest> read_press_command(const Json& json, const std::string& pointer,
                                                   const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<ForceCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_press(reader, cell, std::nullopt);
  return command;
}

std::unique_ptr<CommandRequest> read_search_command(const Json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<ForceCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_search(reader, cell);
  return command;
}

}  // namespace takt::activity
