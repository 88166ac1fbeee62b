#include "core/operations/measure_step.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/command_activity.h"
#include "core/base/object_reader.h"
#include "core/base/read_parts.h"
#include "core/command/actions/device_commands.h"
#include "core/command/actions/tare.h"
#include "core/operations/parameter_table.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"
#include "core/world/pose_fit.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

template <class Map>
std::vector<std::string> keys_of(const Map& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

/// A step that does its work at once, without a net.
class ImmediateRun final : public StepRun {
 public:
  explicit ImmediateRun(std::function<bool(Context&, Diagnostics&)> work) : work_(std::move(work)) {}
  Progress advance(Context& context, Diagnostics& diagnostics) override {
    return work_(context, diagnostics) ? Progress::kDone : Progress::kFailed;
  }

 private:
  std::function<bool(Context&, Diagnostics&)> work_;
};

// -- tare ----------------------------------------------------------------------------------------------------------

struct TareParameters : OperationHead {
  std::string sensor;
  std::int64_t cycles = 500;
};

const ParameterTable<TareParameters>& tare_parameters() {
  static const auto table = [] {
    ParameterTable<TareParameters> tare;
    tare.name("sensor", NameOf::kSensor, &TareParameters::sensor, "Force/torque sensor, at rest and without contact.")
        .integer("cycles", &TareParameters::cycles, {.low = 1, .high = 100'000}, "Samples that are averaged.");
    return tare;
  }();
  return table;
}

class TareRun final : public ScheduledRun {
 public:
  TareRun(std::string sensor, std::int64_t cycles) : sensor_(std::move(sensor)), cycles_(cycles) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context&) override {
    return command_activity("tare " + sensor_, {},
                            [sensor = sensor_, cycles = cycles_](const PlanningContext& planning) {
                              return command::tare_command(sensor, cycles, planning.cell);
                            });
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    if (cancelled()) return Progress::kDone;
    const auto bias = run()->value<net::Wrench>(command::observed::kBias);
    if (!bias) {
      diagnostics.error(Code::kSensorSilent, "/sensor", fmt::format("'{}' did not answer while it was tared", sensor_),
                        "check its power and its wiring; \"try\" with \"retry\" tares again");
      return Progress::kFailed;
    }
    context.variables.biases[sensor_] = *bias;
    return Progress::kDone;
  }

  std::string sensor_;
  std::int64_t cycles_;
};

class TareStep final : public Step {
 public:
  explicit TareStep(const TareParameters& tare) : sensor_(tare.sensor), cycles_(tare.cycles) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.duration += 1e-3 * static_cast<double>(cycles_);
    const auto command = command::tare_command(sensor_, cycles_, rehearsal.cell);
    rehearse_command(command, "tare " + sensor_, rehearsal, pointer, diagnostics);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<TareRun>(sensor_, cycles_); }

 private:
  std::string sensor_;
  std::int64_t cycles_;
};

// -- record_contact ------------------------------------------------------------------------------------------------

struct RecordContactParameters : OperationHead {
  std::string arm, as;
};

const ParameterTable<RecordContactParameters>& record_contact_parameters() {
  static const auto table = [] {
    ParameterTable<RecordContactParameters> record;
    record.name("arm", NameOf::kArm, &RecordContactParameters::arm, "Arm whose last motion ended with the contact.")
        .text("as", &RecordContactParameters::as, "Name under which the contact is kept.")
        .required();
    return record;
  }();
  return table;
}

class RecordContactStep final : public Step {
 public:
  explicit RecordContactStep(const RecordContactParameters& record) : arm_(record.arm), name_(record.as) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    if (!rehearsal.touched[arm_]) {
      diagnostics.error(Code::kRequires, pointer,
                        fmt::format("the last motion of '{}' was not guarded, so there is no contact", arm_),
                        "a motion with \"until\" directly before");
    }
    if (rehearsal.contacts.contains(name_)) {
      diagnostics.warning(Code::kDuplicate, pointer + "/as",
                          fmt::format("contact '{}' is recorded again; the later one counts", name_));
    }
    rehearsal.contacts[name_] = arm_;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>([this](Context& context, Diagnostics& diagnostics) {
      const auto touch = context.variables.touches.find(arm_);
      if (touch == context.variables.touches.end()) {
        diagnostics.error(Code::kNoContact, {}, fmt::format("the last motion of '{}' ended without a contact", arm_),
                          "known(touch('...')) asks before");
        return false;
      }
      context.variables.contacts[name_] = {name_, touch->second.p_W, touch->second.radius};
      return true;
    });
  }

 private:
  std::string arm_, name_;
};

// -- fit_pose ------------------------------------------------------------------------------------------------------

struct FitRequest : OperationHead {
  std::string object, as;
  std::vector<std::string> contacts;
  std::vector<world::Coordinate> free;
  double max_residual = 1e-3;  ///< m
};

/// The fit of an object may replace what the file says of this object, and of nothing else.
void check_estimate(FitRequest& request, const ReadContext& from) {
  if (request.as == request.object || !from.cell.frames.contains(request.as)) return;
  from.reader.diagnostics().error(Code::kInvalidName, from.reader.at("as"),
                                  fmt::format("'{}' cannot be the name of an estimate", request.as),
                                  fmt::format("a new name, or '{}'", request.object));
}

const std::vector<std::string>& coordinate_names() {
  static const std::vector<std::string> names{"x", "y", "z", "roll", "pitch", "yaw"};
  return names;
}

void read_coordinates(const ParameterInfo& row, const ReadContext& from, FitRequest& request) {
  const auto free = from.reader.texts(row.key);
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto found = std::ranges::find(coordinate_names(), free[i]);
    if (found == coordinate_names().end()) {
      from.reader.diagnostics().error(Code::kUnknownName, from.reader.at(row.key) + pointer_segment(i),
                                      fmt::format("unknown coordinate '{}'", free[i]),
                                      nearest_choice(free[i], coordinate_names()));
    } else {
      request.free.push_back(static_cast<world::Coordinate>(found - coordinate_names().begin()));
    }
  }
}

void write_coordinates(const ParameterInfo& row, const FitRequest& request, ParameterWriter& to) {
  std::vector<std::string> names;
  for (const world::Coordinate one : request.free)
    names.push_back(coordinate_names().at(static_cast<std::size_t>(one)));
  to.texts(row.key, names);
}

const ParameterTable<FitRequest>& fit_pose_parameters() {
  static const auto table = [] {
    ParameterInfo free{.key = "free", .type = ParameterInfo::Type::kTexts, .required = true};
    free.doc = "Coordinates that are fitted: x, y, z, roll, pitch, yaw of the object.";
    ParameterTable<FitRequest> fit;
    fit.name("object", NameOf::kObject, &FitRequest::object, "Object that was touched.")
        .required()
        .text("as", &FitRequest::as, "Name of the frame that gets the fitted pose.")
        .required()
        .texts("contacts", &FitRequest::contacts, "Names of recorded contacts.")
        .object(std::move(free), read_coordinates, write_coordinates)
        .number("max_residual_m", "m", &FitRequest::max_residual, kPositive, "Largest residual (rms) of a good fit.")
        .rule(check_estimate);
    return fit;
  }();
  return table;
}

class FitPoseStep final : public Step {
 public:
  explicit FitPoseStep(FitRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    for (std::size_t i = 0; i < request_.contacts.size(); ++i) {
      const std::string& name = request_.contacts[i];
      if (rehearsal.contacts.contains(name)) continue;
      diagnostics.error(Code::kUnknownName, pointer + "/contacts" + pointer_segment(i),
                        fmt::format("no contact '{}' is recorded before this", name),
                        nearest_choice(name, keys_of(rehearsal.contacts)));
    }
    if (request_.contacts.size() < request_.free.size()) {
      diagnostics.error(
          Code::kWrongSize, pointer + "/contacts",
          fmt::format("{} contacts for {} free coordinates", request_.contacts.size(), request_.free.size()),
          "at least one contact a coordinate");
    }
    const auto X_WO = rehearsal.cell.frames.pose(request_.object);
    if (X_WO) diagnostics.append(rehearsal.cell.frames.set(request_.as, "world", *X_WO), pointer + "/as");
    rehearsal.estimates.insert(request_.as);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>(
        [this](Context& context, Diagnostics& diagnostics) { return fit(context, diagnostics); });
  }

 private:
  /// The fit is done in the axes of the object's nominal frame, so that "x" in the file is the object's own x.
  bool fit(Context& context, Diagnostics& diagnostics) const {
    const Eigen::Isometry3d X_WN = *context.cell.frames.pose(request_.object);
    std::vector<world::Contact> contacts;
    for (const std::string& name : request_.contacts) {
      const auto found = context.variables.contacts.find(name);
      if (found == context.variables.contacts.end()) {
        diagnostics.error(Code::kNoContact, "/contacts", fmt::format("contact '{}' was not recorded", name),
                          nearest_choice(name, keys_of(context.variables.contacts)));
        continue;
      }
      contacts.push_back(found->second);
      contacts.back().p_R = X_WN.inverse() * found->second.p_R;
    }
    if (diagnostics.has_errors()) return false;
    const world::Object& object = context.cell.objects.find(request_.object)->second;
    const auto fit =
        world::fit_pose(object, contacts, Eigen::Isometry3d::Identity(), request_.free, request_.max_residual);
    if (!fit) {
      diagnostics.append(fit.error());
      return false;
    }
    const Eigen::Isometry3d X_WO = X_WN * fit->X_RO;
    context.variables.estimates[request_.as] = X_WO;
    context.variables.residuals[request_.as] = fit->rms_residual;
    diagnostics.append(context.cell.frames.set(request_.as, "world", X_WO), "/as");
    const Eigen::Vector3d step = fit->X_RO.translation() * 1e3;
    context.event(
        "program", "estimate",
        fmt::format("{}: ({:+.3f}, {:+.3f}, {:+.3f}) mm off nominal", request_.as, step.x(), step.y(), step.z()));
    return !diagnostics.has_errors();
  }

  FitRequest request_;
};

}  // namespace

const std::vector<ParameterInfo>& tare_parameter_list() { return tare_parameters().list(); }
const std::vector<ParameterInfo>& record_contact_parameter_list() { return record_contact_parameters().list(); }
const std::vector<ParameterInfo>& fit_pose_parameter_list() { return fit_pose_parameters().list(); }

std::unique_ptr<Step> parse_tare(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<TareStep>(tare_parameters().read(reader, cell));
}

std::unique_ptr<Step> parse_record_contact(const Json& json, const std::string& pointer, const command::Cell& cell,
                                           Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<RecordContactStep>(record_contact_parameters().read(reader, cell));
}

std::unique_ptr<Step> parse_fit_pose(const Json& json, const std::string& pointer, const command::Cell& cell,
                                     Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<FitPoseStep>(fit_pose_parameters().read(reader, cell));
}

}  // namespace takt::activity
