#include "scenario/bore_file.h"

namespace takt::scenario {
namespace {

using world::Bore;

/// A hole for a screw is one of the size that its name says.
void read_clearance(const table::Field& row, const table::Context& from, Bore& bore) {
  const std::string size = from.reader.text(row.key, "");
  if (!size.empty()) bore.thread = kClearance + size;
}

}  // namespace

const table::Table<Bore>& bore_table() {
  static const auto table = [] {
    table::Field clearance = table::field("clearance_for", table::Field::Type::kName,
                                          "Size of the screw that goes through without touching.");
    clearance.names = table::NameOf::kThread;
    table::Table<Bore> bore;
    bore.pose(&Bore::X_SB, "Middle of the mouth in the frame of the shape, on a flat face.")
        .rule({.kind = table::Rule::Kind::kOneOf,
               .groups = {{"radius_m"}, {"thread"}, {"clearance_for"}},
               .hint = "Give one of 'radius_m', 'thread' and 'clearance_for'"})
        .number("radius_m", "m", &Bore::radius, kPositive, "Radius of the wall.")
        .fallback({})
        .named("thread", table::NameOf::kThread, &Bore::thread,
               "Size of its thread, a name of models/threads.json: M3 to M8 (docs/threads.md).")
        .object(std::move(clearance), read_clearance)
        .number("depth_m", "m", &Bore::depth, kPositive, "Depth to the flat bottom.")
        .fallback("through the shape")
        .number("chamfer_m", "m", &Bore::chamfer, kNotNegative, "Width of the 45 degree chamfer at each mouth.")
        .fallback("0, of a thread a little more than its depth")
        .rule([](Bore& b, const table::Context& from) {
          // Until the size is known.
          if (!from.reader.has("radius_m")) b.radius = 0.001;
          if (!b.thread.empty() && !from.reader.has("chamfer_m")) b.chamfer = -1.0;
        });
    return bore;
  }();
  return table;
}

}  // namespace takt::scenario
