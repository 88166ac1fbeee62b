// The operation "blink": a digital output is true for a while and false for a while, so many times. One net: what
// comes after what is decided in the cycle, and the last thing that is sent is false.
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/command/actions/device_action.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"
#include "core/plugin/plugin.h"

TAKT_PLUGIN("blink", "1.0.0");

namespace blink {
namespace {

using namespace takt;
using operations::OperationCommand;
using operations::ParameterTable;
using operations::ReadContext;

struct BlinkParameters {
  std::string output = {};              ///< a digital one; empty: the only output
  std::int64_t times = 1;               ///< how often
  double on = 0.5, off = 0.5;           ///< how long, s
  std::string name = {}, pointer = {};  ///< for people; in its file
};

void check_output(const BlinkParameters& blink, const ReadContext& from) {
  if (blink.output.empty() || from.cell.digital_outputs.contains(blink.output)) return;
  from.reader.diagnostics().error(Code::kWrongType, from.reader.at("output"),
                                  fmt::format("'{}' is an analog output", blink.output), "a digital output");
}

const ParameterTable<BlinkParameters>& blink_parameters() {
  static const auto table =
      ParameterTable<BlinkParameters>()
          .name("output", operations::NameOf::kOutput, &BlinkParameters::output, "Digital output that blinks.")
          .integer("times", &BlinkParameters::times, {.low = 1, .high = 20}, "How often.")
          .number("on_s", "s", &BlinkParameters::on, {.low = 0.0, .high = 60.0}, "How long it is true each time.")
          .number("off_s", "s", &BlinkParameters::off, {.low = 0.0, .high = 60.0}, "How long it is false after that.")
          .rule(check_output);
  return table;
}

class BlinkCommand final : public OperationCommand {
 public:
  explicit BlinkCommand(BlinkParameters parameters) : blink_(std::move(parameters)) {}

  [[nodiscard]] operations::MadeCommand make(const operations::BuildContext& context,
                                             const std::string&) const override {
    const command::Actuator output = command::output(context.cell, blink_.output);
    command::TransactionCommand blinks(name);
    std::optional<command::Command> before;
    const auto then = [&](command::Command next) {
      if (before) {
        blinks.add(next);
        blinks.on_entered(before->completed(), start(next));
      } else {
        blinks.add_started(next);
      }
      before = next;
    };
    for (std::int64_t i = 0; i < blink_.times; ++i) {
      then(command::RuntimeCommand(fmt::format("on {}", i), output, command::set_value(true)));
      then(command::WaitCommand(fmt::format("lit {}", i), blink_.on));
      then(command::RuntimeCommand(fmt::format("off {}", i), output, command::set_value(false)));
      then(command::WaitCommand(fmt::format("dark {}", i), blink_.off));
    }
    return {.command = blinks, .actuator = output};
  }

  void rehearse(operations::Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.duration += static_cast<double>(blink_.times) * (blink_.on + blink_.off);
  }

 private:
  BlinkParameters blink_;
};

operations::Operation blink_operation() {
  return {.name = "blink",
          .doc = "Lets a digital output blink.",
          .parameters = operations::rows_of<blink_parameters>,
          .read_step = operations::step_of_command,
          .read_command = operations::read_command<BlinkCommand, blink_parameters>};
}

TAKT_OPERATION(blink_operation);

}  // namespace
}  // namespace blink
