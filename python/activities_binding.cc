// Operations by name, their runs, and compositions of them.
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <nlohmann/json.hpp>

#include "app/interfaces/two_arms.h"
#include "cell/judge/run_report.h"
#include "core/activity/composition.h"
#include "core/activity/dual_entry_motion.h"
#include "core/operations/force/pressing.h"
#include "python/activities.h"
#include "python/bindings.h"
#include "python/errors.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;
using Pair = Owned<std::shared_ptr<app::TwoArms>>;

// -- Goals and values ------------------------------------------------------------------------------------------------

kinematics::JointVector joints_from(const Eigen::VectorXd& q, const char* key) {
  if (q.size() == 0 || q.size() > kinematics::kMaxJoints || !q.allFinite())
    raise_error("UsageError", Code::kWrongSize, pointer_segment(key),
                fmt::format("{} numbers are not joint positions", q.size()),
                fmt::format("Give one finite number per joint, rad or m, {} at most", kinematics::kMaxJoints));
  return kinematics::JointVector(q);
}

Goal goal_pose(const std::string& in, const Eigen::Matrix4d& X, const std::string& key) {
  return {operations::Goal{operations::Goal::Pose{.in = in, .X = pose_from(X, key.c_str())}}};
}
Goal goal_joints(const Eigen::VectorXd& q, const std::string& key) {
  return {operations::Goal{operations::Goal::Joints{joints_from(q, key.c_str())}}};
}
Goal goal_joint(int joint, double q, bool by) {
  return {operations::Goal{operations::Goal::OneJoint{.joint = joint, .q = q, .by = by}}};
}

void bind_values(nb::module_& module) {
  nb::class_<Goal>(module, "Goal");
  module.def("goal_pose", goal_pose);
  module.def("goal_joints", goal_joints);
  module.def("goal_joint", goal_joint);
  nb::class_<Values>(module, "Values")
      .def(nb::init<>())
      .def("state", [](Values& values, const std::string& key,
                       const State& state) { values.states.insert_or_assign(key, state); })
      .def("goals",
           [](Values& values, const std::string& key, const std::vector<Goal>& goals) { values.goals[key] = goals; })
      .def_rw("blend", &Values::blend)
      .def_rw("X_FM", &Values::X_FM);
}

// -- Runs ------------------------------------------------------------------------------------------------------------

/// What became of a motion or of a press, as JSON: kind, and of a touch where and with what force.
std::string outcome_of(const Run& run) {
  run.cell->check_owner();
  Json json;
  const activity::GuardedOutcome guarded = activity::guarded_outcome(*run.value);
  json["kind"] = activity::name_of(guarded.kind);
  if (guarded.X_BT) {
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) json["X_BT"][row].push_back(guarded.X_BT->matrix()(row, column));
    }
  }
  if (guarded.force) json["force"] = {guarded.force->x(), guarded.force->y(), guarded.force->z()};
  json["pressing"] = operations::name_of(operations::press_outcome(*run.value));
  return json.dump();
}

std::string reactions_of(const Run& run) {
  Json list = Json::array();
  for (const activity::Reaction& one : run.value->reactions())
    list.push_back({{"activity", one.activity},
                    {"event", one.event},
                    {"event_cycle", one.event_cycle},
                    {"braking_cycle", one.braking_cycle},
                    {"least", one.least},
                    {"most", one.most}});
  return list.dump();
}

void wait_for(const Run& run) {
  app::Cell& cell = run.cell->get();
  (void)run.cell->unlocked([&] { return activity::wait(cell.runtime(), run.value); });
}

void bind_run(nb::module_& module) {
  using R = const Run&;
  nb::class_<Run>(module, "Run", "One execution of an activity.")
      .def_prop_ro("name", [](R run) { return run.value->name(); })
      .def_prop_ro("state", [](R run) { return std::string(activity::name_of(run.value->state())); })
      .def_prop_ro("started", [](R run) { return run.value->started(); })
      .def_prop_ro("over", [](R run) { return run.value->over(); })
      .def_prop_ro(
          "blended", [](R run) { return run.value->blended(); }, "It has taken over a motion.")
      .def_prop_ro(
          "first_cycle", [](R run) { return run.value->first_cycle(); }, "-1: not yet")
      .def_prop_ro(
          "last_cycle", [](R run) { return run.value->last_cycle(); }, "-1: not yet")
      .def_prop_ro(
          "preparation",
          [](R run) {
            const auto& times = run.value->preparation();
            return std::tuple(times.planning, times.total);
          },
          "CPU time of planning, and of all until it could start, s.")
      .def("_outcome", outcome_of)
      .def("_reactions", reactions_of)
      .def("_diagnostics",
           [](R run) {
             return cell::to_output_text({{"diagnostics", cell::to_json(run.value->diagnostics())}});
           })
      .def("_require", [](R run) { activity::require(run.value); })
      .def("wait", wait_for, "Returns when it has ended. Raises what made it fail.")
      .def(
          "cancel",
          [](R run) {
            (void)run.cell->get();
            run.value->cancel();
          },
          "Asks for an end in order: it brakes on its path.")
      .def("abort", [](R run) {
        (void)run.cell->get();
        run.value->abort();
      });
}

// -- Activities ------------------------------------------------------------------------------------------------------

Activity activity_of(const CellPtr& cell, const std::string& json, const Values& values) {
  app::Cell& open = cell->get();
  return {cell, app::operation_by_name(open.runtime(), json_from(json), values.in_program())};
}

std::optional<Run> execute(const CellPtr& cell, const std::string& json, const Values& values) {
  app::Cell& open = cell->get();
  const activity::RunPtr run =
      cell->unlocked([&] { return app::execute_by_name(open.runtime(), json_from(json), values.in_program()); });
  return run == nullptr ? std::nullopt : std::optional(Run{cell, run});
}

template <class Begin>
Run begun(const Activity& activity, Begin begin) {
  (void)activity.cell->get();
  return {activity.cell, activity.cell->unlocked([&] { return begin(activity.value); })};
}

std::vector<activity::Activity> parts_of(const std::vector<Activity>& parts) {
  std::vector<activity::Activity> plain;
  for (const Activity& one : parts) plain.push_back(one.value);
  return plain;
}

const CellPtr& cell_of(const std::vector<Activity>& parts) {
  if (parts.empty())
    raise_error("UsageError", Code::kMissing, "", "a composition without parts", "Give at least one activity");
  (void)parts.front().cell->get();
  return parts.front().cell;
}

/// @param subtasks  each with the share of the path, or the state, at which it begins
Activity with_subtasks(const Activity& main,
                       const std::vector<std::tuple<Activity, std::optional<double>, std::optional<State>>>& subtasks) {
  (void)main.cell->get();
  std::vector<activity::Subtask> list;
  for (const auto& [part, share, state] : subtasks)
    list.push_back(
        {.activity = part.value, .at_share = share, .when = state ? std::optional(state->value) : std::nullopt});
  return {main.cell, activity::with_subtasks(main.value, list)};
}

void bind_activity(nb::module_& module) {
  using A = const Activity&;
  nb::class_<Activity>(module, "Activity", "An operation that can be asked for as often as wanted.")
      .def(
          "execute", [](A a) { return begun(a, [](const auto& one) { return one.execute(); }); },
          "Returns when it has ended. Raises what made it fail.")
      .def(
          "begin", [](A a) { return begun(a, [](const auto& one) { return one.begin_execute(); }); },
          "Returns when it has started, in motion if what runs may be left.")
      .def(
          "schedule", [](A a) { return begun(a, [](const auto& one) { return one.schedule(); }); },
          "Returns at once; it takes its turn behind what has its devices already.");
  module.def("activity", activity_of);
  module.def("execute", execute);
  module.def("sequence", [](const std::vector<Activity>& parts) {
    return Activity{cell_of(parts), activity::sequence(parts_of(parts))};
  });
  module.def("parallel", [](const std::vector<Activity>& parts) {
    return Activity{cell_of(parts), activity::parallel(parts_of(parts))};
  });
  module.def("conditional", [](const State& condition, A then, A otherwise) {
    (void)then.cell->get();
    return Activity{then.cell, activity::conditional(condition.value, then.value, otherwise.value)};
  });
  module.def("abort_if", [](A a, const State& state) {
    (void)a.cell->get();
    return Activity{a.cell, activity::abort_if(a.value, state.value)};
  });
  module.def("with_subtasks", with_subtasks);
}

// -- Two arms as one -------------------------------------------------------------------------------------------------

Pair two_arms(const CellPtr& cell, const std::string& leader, const std::string& follower, const Eigen::Matrix4d& X) {
  app::Cell& open = cell->get();
  const Eigen::Isometry3d X_WC = pose_from(X, "X_WC");
  return {cell, std::make_shared<app::TwoArms>(open.arm(leader), open.arm(follower), X_WC)};
}

operations::MotionParameters parameters_of(const Pair& pair, const std::string& json, const Values& values) {
  return app::motion_by_name(pair.cell->get().model(), json_from(json), values.in_program());
}

void bind_two_arms(nb::module_& module) {
  nb::class_<Pair>(module, "TwoArms")
      .def("_lin",
           [](const Pair& pair, const Eigen::Matrix4d& X, const std::string& json, const Values& values) {
             return Activity{pair.cell, pair.value->lin(pose_from(X, "to"), parameters_of(pair, json, values))};
           })
      .def("_lin_by",
           [](const Pair& pair, const Triple& by, const std::string& json, const Values& values) {
             return Activity{pair.cell, pair.value->lin_by(vector_from(by), parameters_of(pair, json, values))};
           })
      .def_prop_ro("centre",
                   [](const Pair& pair) -> Eigen::Matrix4d {
                     (void)pair.cell->get();
                     return pair.value->centre().matrix();
                   })
      .def_prop_ro("centre_by_follower", [](const Pair& pair) -> Eigen::Matrix4d {
        (void)pair.cell->get();
        return pair.value->centre_by_follower().matrix();
      });
  module.def("two_arms", two_arms);
}

}  // namespace

app::ProgramValues Values::in_program() const {
  app::ProgramValues program;
  for (const auto& [key, state] : states) {
    (void)state.cell->get();
    program.states.insert_or_assign(key, state.value);
  }
  for (const auto& [key, list] : goals) {
    for (const Goal& one : list) program.goals[key].push_back(one.goal);
  }
  program.blend_time_share = blend;
  if (X_FM) program.X_FM = pose_from(*X_FM, "X_FM");
  return program;
}

Json json_from(const std::string& text) { return Json::parse(text); }

void bind_activities(nb::module_& module) {
  bind_values(module);
  bind_run(module);
  bind_activity(module);
  bind_two_arms(module);
}

}  // namespace takt::python
