// Event handlers, ends and trees of commands that break one rule each.
#include "tests/core/command/broken_commands.h"

namespace takt::command {
namespace {

std::vector<BrokenCommand> broken_starts() {
  return {
      {"C1",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_entered(a.completed(), start(b));
         return all_of(a, b);
       },
       "/all/a/handlers/0",
       Code::kConflict,
       {"a"}},
      {"C1",
       [](World& world) -> Command {
         auto a = driver(world, "a"), d = lamp(world, "d");
         TransactionCommand inner("inner");
         inner.add(d).on_entered(inner.started(), start(d));
         TransactionCommand all = all_of(a, inner);
         all.on_entered(a.completed(), start(inner)).on_entered(a.completed(), start(d));
         return all;
       },
       "/all/handlers/1",
       Code::kConflict,
       {"d", "all"}},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         TransactionCommand all("all");
         all.add_started(a).add_started(b).on_entered(a.completed(), start(b));
         return all;
       },
       "/all/handlers/0",
       Code::kInvalidValue,
       {"b", "add_started"}},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         TransactionCommand all = all_of(a, b);
         all.on_entered(all.completed(), start(b));
         return all;
       },
       "/all/handlers/0",
       Code::kInvalidValue,
       {"all", "completed"}},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b"), c = driver(world, "c");
         TransactionCommand all = all_of(c, a);
         all.add(b).on_entered(c.completed() || b.completed(), start(a));
         all.on_entered(a.completed(), start(b));
         return all;
       },
       "/all/a", Code::kInvalidValue},
      {"C9",
       [](World&) -> Command { return TransactionCommand("empty"); },
       "/empty",
       Code::kNeverFires,
       {"empty", "add_started"}},
      {"C9",
       [](World& world) -> Command { return all_of(driver(world, "a"), lamp(world, "b")); },
       "/all/b",
       Code::kNeverFires,
       {"b", "add_started"}},
  };
}

std::vector<BrokenCommand> broken_ends() {
  return {
      {"C2",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         b.on_entered(b.completed(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/b/handlers/0",
       Code::kConflict,
       {"a", "b"}},
      {"C2",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         b.on_entered(b.completed(), stop(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/b/handlers/0",
       Code::kConflict,
       {"a", "b"}},
      {"C4",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         TransactionCommand all("all");
         all.add_started(a).on_cancel_forward_to({a, lamp(world, "elsewhere")});
         return all;
       },
       "/all",
       Code::kInvalidValue,
       {"elsewhere"}},
      {"C10",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), raise(RaisedState("loose")));
         return a;
       },
       "/a/handlers/0",
       Code::kInvalidValue,
       {"loose", "a"}},
      {"C10",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(TransactionCommand("other").raised("foreign").state(), cancel(a));
         return a;
       },
       "/a/handlers/0",
       Code::kInvalidValue,
       {"foreign"}},
      {"C11",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_left(b.completed(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/a/handlers/0", Code::kNeverFires},
      {"C11",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_entered(b.started(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/a/handlers/0",
       Code::kNeverFires,
       {"b", "a"}},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), cancel(a), {.delay = -1.0});
         return a;
       },
       "/a/handlers/0",
       Code::kOutOfRange,
       {"-1", "0"}},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), external(""));
         return a;
       },
       "/a/handlers/0", Code::kMissing},
  };
}

std::vector<BrokenCommand> broken_trees() {
  return {
      {"C6",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         TransactionCommand inner("inner");
         inner.add_started(a);
         return all_of(inner, a);
       },
       "/all/a", Code::kDuplicate},
      {"C6",
       [](World& world) -> Command { return wait_for(lamp(world, "stranger").completed()); },
       "/wait",
       Code::kUnknownName,
       {"stranger", "/wait"}},
      {"C6",
       [](World& world) -> Command { return wait_for(world.arm_actuator().invalid_set_point()); },
       "/wait",
       Code::kUnknownName,
       {"arm"}},
      {"C7",
       [](World& world) -> Command {
         TransactionCommand all("all");
         all.add_started(driver(world, "a")).add_started(driver(world, "b"));
         return all;
       },
       "/all/b",
       Code::kResourceConflict,
       {"driver", "/all/a"}},
      {"", [](World& world) -> Command { return driver(world, ""); }, "/", Code::kMissing},
      {"",
       [](World& world) -> Command { return all_of(driver(world, "a"), lamp(world, "a")); },
       "/all/a",
       Code::kDuplicate,
       {"all"}},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.observe("width", expression::gripper_width(world.cell, "gripper"));
         a.observe("width", expression::gripper_force(world.cell, "gripper"));
         return a;
       },
       "/a/observations/width",
       Code::kDuplicate,
       {"width"}},
      {"", [](World&) -> Command { return WaitCommand("wait", -0.5); }, "/wait", Code::kOutOfRange, {"-0.5", "0"}},
  };
}

}  // namespace

std::vector<BrokenCommand> broken_handlers() {
  std::vector<BrokenCommand> all;
  for (const auto& some : {broken_starts(), broken_ends(), broken_trees()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace takt::command
