// What of a model in MuJoCo's format a robot does not have.
#include "tools/import/mjcf_notes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

namespace takt::tools {
namespace {

bool drives(const mjModel& model, int actuator, int joint) {
  const int type = model.actuator_trntype[actuator];
  return (type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT) && model.actuator_trnid[2 * actuator] == joint;
}

double larger_end(const double* range) { return std::max(std::abs(range[0]), std::abs(range[1])); }

bool is_motor(const mjModel& model, int actuator) {
  return model.actuator_gaintype[actuator] == mjGAIN_FIXED && model.actuator_biastype[actuator] == mjBIAS_NONE;
}

/// What it can push with, before the gear; 0: not limited.
double force_of(const mjModel& model, int actuator) {
  if (model.actuator_forcelimited[actuator] != 0) return larger_end(model.actuator_forcerange + 2 * actuator);
  const int control = model.actuator_ctrladr[actuator];
  if (!is_motor(model, actuator) || model.actuator_ctrlnum[actuator] != 1 || model.actuator_ctrllimited[control] == 0)
    return 0.0;
  return std::abs(model.actuator_gainprm[mjNGAIN * actuator]) * larger_end(model.actuator_ctrlrange + 2 * control);
}

/// The speed that a velocity servo is told at most, at the joint; 0: it is none.
double speed_of(const mjModel& model, int actuator) {
  const double* bias = model.actuator_biasprm + mjNBIAS * actuator;
  const double gain = model.actuator_gainprm[mjNGAIN * actuator];
  const int control = model.actuator_ctrladr[actuator];
  const bool servo = model.actuator_gaintype[actuator] == mjGAIN_FIXED && gain > 0.0 && bias[1] == 0.0 &&
                     bias[2] == -gain && model.actuator_biastype[actuator] == mjBIAS_AFFINE;
  const double gear = std::abs(model.actuator_gear[6 * model.actuator_outadr[actuator]]);
  if (!servo || gear == 0.0 || model.actuator_ctrllimited[control] == 0) return 0.0;
  return larger_end(model.actuator_ctrlrange + 2 * control) / gear;
}

std::string placed(const std::string& what, const std::string& name, const std::string& place) {
  const std::string at = place.empty() ? std::string() : fmt::format(" ({})", place);
  return name.empty() ? what + at : fmt::format("{} '{}'{}", what, name, at);
}

/// The place of an element: by its name, or by what MuJoCo knows of the first file.
std::string place_of(const MjcfSource& source, const std::vector<std::string>& kinds, const std::string& name,
                     const mjString* info) {
  for (const std::string& kind : kinds)
    if (std::string place = name.empty() ? std::string() : source.place(kind, name); !place.empty()) return place;
  const std::string known = info != nullptr ? mjs_getString(info) : "";
  return known.starts_with("line ") && known != "line 0" ? known : std::string();
}

std::string name_of(mjsElement* element) {
  const char* name = mjs_getString(mjs_getName(element));
  return name != nullptr ? name : "";
}

void note_equalities(mjSpec& spec, const MjcfSource& source, Draft& draft) {
  static const std::vector<std::string> kKinds = {"joint", "connect",  "weld",      "tendon",
                                                  "flex",  "flexvert", "flexstrain"};
  for (mjsElement* at = mjs_firstElement(&spec, mjOBJ_EQUALITY); at != nullptr; at = mjs_nextElement(&spec, at)) {
    const mjsEquality& one = *mjs_asEquality(at);
    const std::string name = name_of(at);
    // A joint may have the name, too: the line that MuJoCo knows comes first here.
    std::string place = place_of(source, {}, "", one.info);
    if (place.empty()) place = place_of(source, kKinds, name, nullptr);
    const std::string first = mjs_getString(one.name1), second = mjs_getString(one.name2);
    const bool coupling = one.type == mjEQ_JOINT && !second.empty();
    draft.note(
        placed("equality", name, place), coupling ? "the joint is fixed" : "left out",
        coupling ? fmt::format("joint '{}' follows '{}', and couplings are not simulated", first, second)
                 : fmt::format("'{}'{}: closed chains and held places are not simulated, so what it holds together is "
                               "open",
                               first, second.empty() ? std::string() : fmt::format(" and '{}'", second)));
  }
}

void note_tendons(mjSpec& spec, const MjcfSource& source, Draft& draft) {
  for (mjsElement* at = mjs_firstElement(&spec, mjOBJ_TENDON); at != nullptr; at = mjs_nextElement(&spec, at)) {
    const std::string name = name_of(at);
    draft.note(placed("tendon", name, place_of(source, {"fixed", "spatial"}, name, mjs_asTendon(at)->info)), "left out",
               "tendons are not simulated: its joints are not coupled");
  }
}

std::string law_of(const mjModel& model, int actuator) {
  const double* bias = model.actuator_biasprm + mjNBIAS * actuator;
  const double gain = model.actuator_gainprm[mjNGAIN * actuator];
  if (is_motor(model, actuator)) return fmt::format("a motor of gain {:g}", gain);
  if (model.actuator_gaintype[actuator] == mjGAIN_FIXED && model.actuator_biastype[actuator] == mjBIAS_AFFINE)
    return bias[1] != 0.0 ? fmt::format("a position servo of kp {:g}, kv {:g}", -bias[1], -bias[2])
                          : fmt::format("a velocity servo of kv {:g}", -bias[2]);
  return "a law of its own";
}

void note_actuators(const mjModel& model, mjSpec& spec, const MjcfSource& source, Draft& draft) {
  static const std::vector<std::string> kKinds = {"general",     "motor",   "position", "velocity",
                                                  "intvelocity", "damper",  "cylinder", "muscle",
                                                  "adhesion",    "dcmotor", "pid",      "orientation"};
  for (mjsElement* at = mjs_firstElement(&spec, mjOBJ_ACTUATOR); at != nullptr; at = mjs_nextElement(&spec, at)) {
    const int id = mjs_getId(at);
    if (id < 0 || id >= model.nu) continue;
    const std::string name = name_of(at);
    const std::string key = placed("actuator", name, place_of(source, kKinds, name, mjs_asActuator(at)->info));
    const int type = model.actuator_trntype[id];
    const bool of_joint = type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT;
    const double force =
        force_of(model, id) * (of_joint ? std::abs(model.actuator_gear[6 * model.actuator_outadr[id]]) : 0.0);
    const char* joint = of_joint ? mj_id2name(&model, mjOBJ_JOINT, model.actuator_trnid[2 * id]) : nullptr;
    const std::string whose = joint != nullptr ? fmt::format(" of joint '{}'", joint) : std::string();
    if (!of_joint) {
      draft.note(key, "left out", law_of(model, id) + " on something that is no joint");
    } else if (force > 0.0) {
      draft.note(key, fmt::format("effort {:.6g}{}", force, whose),
                 law_of(model, id) + ": its gains are left out, as the device file has the controller's");
    } else {
      draft.note(key, "left out", law_of(model, id) + " without a limit of force" + whose);
    }
  }
}

void note_keyframes(const mjModel& model, const MjcfSource& source, Draft& draft) {
  for (int key = 0; key < model.nkey; ++key) {
    const char* text = mj_id2name(&model, mjOBJ_KEY, key);
    const std::string name = text != nullptr ? text : "";
    const std::string taken = draft.home;
    if (taken == fmt::format("keyframe '{}'", name) || (key == 0 && taken == "the first keyframe")) continue;
    draft.note(placed("keyframe", name, name.empty() ? std::string() : source.place("key", name)), "left out",
               fmt::format("an arm has one home: {}", taken));
  }
}

}  // namespace

JointDrive drive_of(const mjModel& model, int joint) {
  JointDrive drive;
  for (int i = 0; i < model.nu; ++i) {
    if (!drives(model, i, joint)) continue;
    drive.effort += force_of(model, i) * std::abs(model.actuator_gear[6 * model.actuator_outadr[i]]);
    drive.velocity = std::max(drive.velocity, speed_of(model, i));
  }
  if (model.jnt_actfrclimited[joint] != 0) {
    const double most = larger_end(model.jnt_actfrcrange + 2 * joint);
    drive.effort = drive.effort > 0.0 ? std::min(drive.effort, most) : most;
  }
  return drive;
}

Diagnostic mujoco_diagnostic(const std::string& text) {
  /// Texts of MuJoCo 4.0: what they contain, what that is.
  struct Row {
    const char* words;
    Code code;
    const char* hint;
  };
  static constexpr Row kRows[] = {
      {"Error opening file", Code::kNotFound, "Name a file that is there; meshdir and assetdir say where meshes are"},
      {"already included", Code::kDuplicate, "Include each file once; a file must not include itself"},
      {"unknown default", Code::kUnknownName, "Name a class of <default>"},
      {"unrecognized attribute", Code::kUnknownKey, "Remove it, or see MuJoCo's reference of the format"},
      {"unrecognized element", Code::kUnknownKey, "Remove it, or see MuJoCo's reference of the format"},
      {"repeated name", Code::kDuplicate, "Give each its own name"},
      {"required", Code::kMissing, "Add it"},
      {"not found", Code::kUnknownName, "Name something that is there"},
      {"unknown", Code::kUnknownName, "Name something that is there"},
  };
  Diagnostic diagnostic;
  diagnostic.code = Code::kInvalidModel;
  diagnostic.hint = "Change it until MuJoCo loads it";
  for (const Row& row : kRows) {
    if (text.find(row.words) == text.npos) continue;
    diagnostic.code = row.code;
    diagnostic.hint = row.hint;
    break;
  }
  std::string line = text;
  std::ranges::replace(line, '\n', ' ');
  while (!line.empty() && line.back() == ' ') line.pop_back();
  diagnostic.message = line;
  return diagnostic;
}

void note_unused(const mjModel& model, mjSpec& spec, const MjcfSource& source, Draft& draft) {
  note_actuators(model, spec, source, draft);
  note_equalities(spec, source, draft);
  note_tendons(spec, source, draft);
  note_keyframes(model, source, draft);
  for (const auto& [what, unread] : source.unread())
    draft.note("left out", fmt::format("{} {}", unread.count, what),
               fmt::format("nothing here reads it; first in {}", unread.first));
  for (int i = 0; i < mjs_numWarnings(&spec); ++i) draft.note("MuJoCo", "a warning", mjs_getWarning(&spec, i));
}

}  // namespace takt::tools
