#include "sim/world/world.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/contact/body_force.h"
#include "sim/contact/contact_law.h"
#include "sim/contact/contact_watch.h"
#include "sim/contact/free_motion.h"
#include "sim/contact/islands.h"
#include "sim/contact/rest.h"
#include "sim/contact/sweep.h"
#include "sim/contact/thread_law.h"
#include "sim/machines/arm_plant.h"
#include "sim/model/description_check.h"
#include "sim/model/mujoco_errors.h"
#include "sim/model/solids.h"
#include "sim/world/model_compiler.h"

namespace takt::sim {
namespace {

/// All of MuJoCo's state that a step reads: nothing else is ever set (no activations, no mocap bodies, no applied
/// Cartesian forces, which would only make the digest longer).
constexpr int kStateParts = mjSTATE_TIME | mjSTATE_QPOS | mjSTATE_QVEL | mjSTATE_QFRC_APPLIED | mjSTATE_WARMSTART;

Nanoseconds wall_clock() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

struct World::Impl {
  Owned<mjModel_> model;  // of the physics
  Owned<mjData_> data;
  Owned<mjModel_> picture_model;
  Owned<mjData_> picture_data;
  std::optional<ContactLaw> contacts;
  Solids solids;
  ThreadLaw threads;
  Rest rest;
  FreeMotion free_motion;
  Sweep sweep;
  Physics physics;
  Nanoseconds now = 0;
  // In the order of the description, kind after kind: inputs after what they read; last the devices of
  // other kinds.
  struct NamedDevice {
    std::string name;
    std::unique_ptr<SimDevice> device;
  };
  std::vector<NamedDevice> named;
  std::vector<SimDevice*> devices;  // the same
  std::vector<ContactWatch> watches;
  std::vector<TouchingBodies> touching;  // of the last physics step
  std::optional<ContactList> contact_list;
  std::vector<std::string> lamps;         // the wires that light something, by name
  std::vector<const double*> lamp_wires;  // the same
  std::vector<double> plant_state;
  std::vector<std::uint64_t> words;  // the state as a digest sees it
  struct Push {
    int body = 0;
    Eigen::Vector3d force, torque;
  };
  std::vector<Push> pushes;  // one of a body
  bool profiling = false;
  StepTimes times;

  [[nodiscard]] Diagnostics add_arms(const WorldDescription& description);
  void add_sensors(const WorldDescription& description);
  void add_grippers(const WorldDescription& description);
  void add_tool_changers(const WorldDescription& description);
  void add_signals(const WorldDescription& description);
  void add(std::string name, std::unique_ptr<SimDevice> device) {
    devices.push_back(device.get());
    named.push_back({std::move(name), std::move(device)});
  }
  template <class Device>
  [[nodiscard]] Device* find(std::string_view name) const {
    for (const auto& one : named) {
      if (one.name != name) continue;
      if (auto* device = dynamic_cast<Device*>(one.device.get())) return device;
    }
    return nullptr;
  }
  [[nodiscard]] Diagnostics add_others(const WorldDescription& description);
  void set_start(const WorldDescription& description);
  void step();
  /// What is applied to bodies begins with what push() says; devices add to it.
  void begin_forces();
  void physics_step(Nanoseconds end);
  void look();
  void forward();
  /// @return the number of words
  std::size_t stream(StateStream::Mode mode, std::span<std::uint64_t> state);
  [[nodiscard]] bool diverged() const;
  /// Number of the body whose state MuJoCo has warned of; -1: none.
  [[nodiscard]] int diverged_body() const;
};

Diagnostics World::Impl::add_arms(const WorldDescription& description) {
  Diagnostics diagnostics;
  for (const auto& arm : description.arms) {
    auto plant = arm_plant(*model, *data, description, arm);
    if (!plant) {
      diagnostics.append(plant.error());
      continue;
    }
    const int root = plant->root;
    add(arm.name, std::make_unique<SimArm>(arm, std::move(*plant), description.seed));
    if (arm.drive) rest.add_driven(*model, root, *devices.back());
  }
  return diagnostics;
}

void World::Impl::add_sensors(const WorldDescription& description) {
  for (const auto& sensor : description.force_torque_sensors) {
    const auto address = [&](std::string_view suffix) {
      return model->sensor_adr[mj_name2id(model.get(), mjOBJ_SENSOR, fmt::format("{}{}", sensor.name, suffix).c_str())];
    };
    add(sensor.name, std::make_unique<SimForceTorque>(sensor, address("/force"), address("/torque"),
                                                      description.physics, description.seed));
  }
}

void World::Impl::add_grippers(const WorldDescription& description) {
  for (const auto& gripper : description.grippers) {
    SimGripper::Plant plant;
    for (std::size_t i = 0; i < gripper.fingers.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, (gripper.robot + "/" + gripper.fingers[i]).c_str());
      plant.position_address[i] = model->jnt_qposadr[id];
      plant.velocity_address[i] = model->jnt_dofadr[id];
    }
    add(gripper.name, std::make_unique<SimGripper>(gripper, plant));
  }
}

void World::Impl::add_tool_changers(const WorldDescription& description) {
  for (const auto& changer : description.tool_changers)
    add(changer.name, std::make_unique<SimToolChanger>(changer, description, *model));
}

void World::Impl::add_signals(const WorldDescription& description) {
  for (const auto& output : description.outputs) add(output.name, std::make_unique<SimOutput>(output));
  for (const auto& beam : description.beams) {
    const int body = mj_name2id(model.get(), mjOBJ_BODY, beam.body.c_str());
    add(beam.name, std::make_unique<SimBeam>(beam, *model, body, description.seed));
  }
  for (const auto& input : description.inputs) {
    const SimOutput* output = find<SimOutput>(input.source);
    const SimBeam* beam = find<SimBeam>(input.source);
    const double* wire = output ? output->wire() : beam ? beam->wire() : nullptr;
    add(input.name, std::make_unique<SimInput>(input, wire, description.seed));
  }
  lamps = takt::sim::lamp_wires(description);
  for (const std::string& lamp : lamps) {
    const SimOutput* output = find<SimOutput>(lamp);
    lamp_wires.push_back(output ? output->wire() : find<SimBeam>(lamp)->wire());
  }
}

Diagnostics World::Impl::add_others(const WorldDescription& description) {
  Diagnostics diagnostics;
  for (const auto& one : description.devices) {
    auto device = one.make(*model, description);
    if (!device) {
      diagnostics.append(device.error(), place(one.pointer, "devices", one.name));
      continue;
    }
    add(one.name, std::move(*device));
  }
  return diagnostics;
}

void World::Impl::set_start(const WorldDescription& description) {
  for (const auto& robot : description.robots) {
    const auto joints = movable_joints(*robot.model);
    for (std::size_t i = 0; i < robot.q.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, (robot.name + "/" + joints[i]->name).c_str());
      data->qpos[model->jnt_qposadr[id]] = robot.q[i];
    }
  }
  forward();
}

void World::Impl::physics_step(Nanoseconds end) {
  mjModel* m = model.get();
  mjData* d = data.get();
  // The state's poses and velocities are known from the end of the last step, so that poses always belong to time().
  if (m->opt.integrator == mjINT_RK4) {
    mj_step(m, d);
  } else {
    contacts->prepare(*m, *d, solids);
    free_motion.prepare(*m, *d);
    if (threads.empty()) {
      copy_rows_to_islands(*m, *d);
      mj_step2(m, d);
    } else {
      threads.finish_step(*m, *d);
    }
    free_motion.finish(*m, *d);
  }
  if (!watches.empty()) list_touching(*m, *d, touching);
  for (auto& watch : watches) watch.update(*m, *d, touching);
  if (contact_list) contact_list->update(*m, *d);
  const bool settles = rest.settle(*m, *d);
  if (settles) {
    for (auto& watch : watches) watch.keep_resting(*m, *d, touching, rest);
    if (contact_list) contact_list->keep_resting(*m, *d, rest);
  }
  sweep.stop(*m, *d);
  look();
  if (!threads.empty() && threads.watch(*m, *d, solids, end)) look();
  if (!settles) return;
  rest.fall_asleep(*m, *d);
  look();
}

/// Positions and velocities of all bodies, and what touches: the calls of mj_step1 for what our models have. Contacts
/// have to be there before constraints are made of them, and who sleeps has to be known.
void World::Impl::look() {
  mjModel* m = model.get();
  mjData* d = data.get();
  mj_checkPos(m, d);
  mj_checkVel(m, d);
  d->flg_energypos = 0;
  do {
    mj_fwdKinematics(m, d);
    rest.woken(*d);
    mj_makeM(m, d);
    mj_factorM(m, d);
    solids.search(*m, *d);
  } while (rest.wake_touched(*m, *d));
  mj_makeConstraint(m, d);
  mj_island(m, d);
  mj_projectConstraint(m, d);
  mj_transmission(m, d);
  mj_sensorPos(m, d);
  mj_fwdVelocity(m, d);
  mj_sensorVel(m, d);
}

/// As mj_forward, with the contact law.
void World::Impl::forward() {
  look();
  contacts->prepare(*model, *data, solids);
  copy_rows_to_islands(*model, *data);
  mj_fwdActuation(model.get(), data.get());
  mj_fwdAcceleration(model.get(), data.get());
  mj_fwdConstraint(model.get(), data.get());
  data->flg_rnepost = 0;  // as mj_forward does: forces in joints are computed anew
  mj_sensorAcc(model.get(), data.get());
}

bool World::Impl::diverged() const {
  const auto& w = data->warning;
  return w[mjWARN_BADQPOS].number + w[mjWARN_BADQVEL].number + w[mjWARN_BADQACC].number > 0;
}

int World::Impl::diverged_body() const {
  const auto& w = data->warning;
  for (int joint = 0; joint < static_cast<int>(model->njnt); ++joint) {
    const int next = joint + 1;
    const bool last = next == static_cast<int>(model->njnt);
    const auto within = [](int number, int begin, int end) { return number >= begin && number < end; };
    const int positions_end = last ? static_cast<int>(model->nq) : model->jnt_qposadr[next];
    const int axes_end = last ? static_cast<int>(model->nv) : model->jnt_dofadr[next];
    if (w[mjWARN_BADQPOS].number > 0) {
      if (within(w[mjWARN_BADQPOS].lastinfo, model->jnt_qposadr[joint], positions_end)) return model->jnt_bodyid[joint];
      continue;
    }
    const auto& bad = w[mjWARN_BADQVEL].number > 0 ? w[mjWARN_BADQVEL] : w[mjWARN_BADQACC];
    if (bad.number > 0 && within(bad.lastinfo, model->jnt_dofadr[joint], axes_end)) return model->jnt_bodyid[joint];
  }
  return -1;
}

std::size_t World::Impl::stream(StateStream::Mode mode, std::span<std::uint64_t> state) {
  StateStream stream(mode, state);
  if (mode == StateStream::Mode::kWrite) mj_getState(model.get(), data.get(), plant_state.data(), kStateParts);
  stream.vector(plant_state);
  if (mode == StateStream::Mode::kRead) mj_setState(model.get(), data.get(), plant_state.data(), kStateParts);
  contacts->stream(stream);
  threads.stream(stream);
  rest.stream(stream, *data);
  stream(now);
  for (SimDevice* device : devices) device->stream(stream);
  return stream.position();
}

World::World(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

Result<World> World::create(const WorldDescription& description, const SpecHook& hook) {
  Diagnostics diagnostics = check(description);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  auto impl = std::make_unique<Impl>();
  for (const bool visuals : {true, false}) {
    auto built = mujoco_call("", [&] { return compile_model(description, visuals, hook); });
    if (!built) return std::unexpected(std::move(built.error()));
    if (!*built) return std::unexpected(std::move(built->error()));
    (visuals ? impl->picture_model : impl->model) = std::move(**built);
  }
  impl->rest = Rest(*impl->model, description);
  impl->pushes.reserve(static_cast<std::size_t>(impl->model->nbody));
  diagnostics = make_data(*impl->model, impl->data);
  diagnostics.append(make_data(*impl->picture_model, impl->picture_data));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  impl->physics = description.physics;
  install_solid_contacts();
  impl->solids = Solids(*impl->model, description);
  impl->threads = ThreadLaw(*impl->model, description, impl->solids);
  impl->contacts.emplace(*impl->model, description);
  impl->free_motion = FreeMotion(*impl->model);
  std::vector<bool> open(static_cast<std::size_t>(impl->model->ngeom));
  for (int geom = 0; geom < static_cast<int>(impl->model->ngeom); ++geom) {
    const Solid* solid = impl->solids.find(geom);
    open[static_cast<std::size_t>(geom)] = solid != nullptr && !solid->bores.empty();
  }
  impl->sweep = Sweep(*impl->model, std::move(open));
  impl->set_start(description);
  diagnostics = impl->add_arms(description);
  impl->add_sensors(description);
  impl->add_grippers(description);
  impl->add_tool_changers(description);
  impl->add_signals(description);
  diagnostics.append(impl->add_others(description));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  impl->plant_state.resize(static_cast<std::size_t>(mj_stateSize(impl->model.get(), kStateParts)));

  // The arms hold their start positions, so that the first samples are those of a robot at rest.
  for (SimDevice* device : impl->devices) {
    device->start(*impl->data);
    device->actuate(*impl->data, {.length = description.physics.timestep, .duration = impl->model->opt.timestep});
  }
  impl->forward();
  for (SimDevice* device : impl->devices) device->measure(*impl->data, 0);
  impl->words.resize(impl->stream(StateStream::Mode::kCount, {}));
  (void)impl->stream(StateStream::Mode::kWrite, impl->words);
  return World(std::move(impl));
}

void World::Impl::begin_forces() {
  std::fill_n(data->xfrc_applied, 6 * model->nbody, 0.0);
  for (const Push& push : pushes) add_wrench(*data, push.body, push.force, push.torque);
}

void World::Impl::step() {
  const Nanoseconds length = physics.timestep;
  for (Substep step{.length = length, .duration = to_seconds(length)}; step.number * length < physics.period;
       ++step.number) {
    const Nanoseconds begin = profiling ? wall_clock() : 0;
    begin_forces();
    for (SimDevice* device : devices) device->actuate(*data, step);
    if (rest.pushed(*model, *data)) look();  // what is pushed wakes before the step, and keeps all of the impulse
    const Nanoseconds actuated = profiling ? wall_clock() : 0;
    physics_step(now + length * (step.number + 1));
    if (!profiling) continue;
    times.devices += actuated - begin;
    times.physics += wall_clock() - actuated;
  }
  const Nanoseconds begin = profiling ? wall_clock() : 0;
  now += physics.period;
  for (SimDevice* device : devices) device->measure(*data, now);
  (void)stream(StateStream::Mode::kWrite, words);
  if (profiling) times.devices += wall_clock() - begin;
}

bool World::step() {
  try {
    impl_->step();
  } catch (const MujocoError&) {  // out of memory for contacts, and the like: no state to go on with
    return false;
  }
  return !impl_->diverged();
}

std::string World::divergence() const {
  const int body = impl_->diverged_body();
  const char* name = body > 0 ? mj_id2name(impl_->model.get(), mjOBJ_BODY, body) : nullptr;
  return fmt::format("the physics{} diverged at {:.3f} s", name != nullptr ? fmt::format(" of '{}'", name) : "",
                     to_seconds(impl_->now));
}

Nanoseconds World::time() const { return impl_->now; }

SimArm* World::arm(std::string_view name) { return impl_->find<SimArm>(name); }
SimForceTorque* World::force_torque(std::string_view name) { return impl_->find<SimForceTorque>(name); }
SimGripper* World::gripper(std::string_view name) { return impl_->find<SimGripper>(name); }
SimToolChanger* World::tool_changer(std::string_view name) { return impl_->find<SimToolChanger>(name); }
SimOutput* World::output(std::string_view name) { return impl_->find<SimOutput>(name); }
SimReading* World::input(std::string_view name) { return impl_->find<SimReading>(name); }

SimDevice* World::device(std::string_view name) { return impl_->find<SimDevice>(name); }

std::span<const std::byte> World::state_bytes() const { return std::as_bytes(std::span(impl_->words)); }

std::string World::state_word_name(std::size_t word) const {
  struct Part {
    int part;
    const char* name;
  };
  static constexpr Part kParts[] = {{mjSTATE_TIME, "time"},
                                    {mjSTATE_QPOS, "position"},
                                    {mjSTATE_QVEL, "velocity"},
                                    {mjSTATE_QFRC_APPLIED, "applied force"},
                                    {mjSTATE_WARMSTART, "acceleration of the solver's start"}};
  std::size_t begin = 0;
  for (const Part& part : kParts) {
    const auto size = static_cast<std::size_t>(mj_stateSize(impl_->model.get(), part.part));
    if (word < begin + size) {
      const std::size_t i = word - begin;
      return part.part == mjSTATE_QPOS ? "position of " + position_names()[i] : fmt::format("{} {}", part.name, i);
    }
    begin += size;
  }
  StateStream remembered(StateStream::Mode::kCount, {});
  impl_->contacts->stream(remembered);
  if (word < begin + remembered.position()) return fmt::format("friction of contacts, value {}", word - begin);
  begin += remembered.position();
  StateStream threads(StateStream::Mode::kCount, {});
  impl_->threads.stream(threads);
  if (word < begin + threads.position()) return fmt::format("screws in their threads, value {}", word - begin);
  begin += threads.position();
  StateStream resting(StateStream::Mode::kCount, {});
  impl_->rest.stream(resting, *impl_->data);
  if (word < begin + resting.position()) return fmt::format("parts at rest, value {}", word - begin);
  begin += resting.position();
  if (word == begin) return "time of the devices";
  ++begin;
  for (std::size_t device = 0; device < impl_->devices.size(); ++device) {
    StateStream count(StateStream::Mode::kCount, {});
    impl_->devices[device]->stream(count);
    if (word < begin + count.position()) return fmt::format("device {}, value {}", device, word - begin);
    begin += count.position();
  }
  return fmt::format("word {}", word);
}

Snapshot World::save() const {
  Snapshot snapshot(impl_->words.size());
  (void)impl_->stream(StateStream::Mode::kWrite, snapshot);
  for (auto& watch : impl_->watches) watch.save(snapshot);
  if (impl_->contact_list) impl_->contact_list->save(snapshot);
  return snapshot;
}

bool World::restore(const Snapshot& snapshot) {
  Impl& w = *impl_;
  const std::size_t size = w.words.size(), watched = ContactWatch::kWords * w.watches.size();
  const auto listed = std::span(snapshot).subspan(std::min(snapshot.size(), size + watched));
  if (w.contact_list ? !ContactList::fits(listed) : snapshot.size() != size + watched) return false;
  w.words.assign(snapshot.begin(), snapshot.begin() + static_cast<std::ptrdiff_t>(size));
  (void)w.stream(StateStream::Mode::kRead, w.words);
  for (std::size_t i = 0; i < w.watches.size(); ++i) {
    w.watches[i].restore(std::span(snapshot).subspan(size + ContactWatch::kWords * i, ContactWatch::kWords));
  }
  if (w.contact_list) (void)w.contact_list->restore(listed);
  w.threads.resume(*w.model, *w.data, w.solids);
  for (SimDevice* device : w.devices) device->resume(*w.data);
  w.rest.wake_all(*w.model, *w.data);
  w.look();
  w.rest.fall_asleep(*w.model, *w.data);
  w.look();
  return true;
}

std::span<const double> World::positions() const {
  return {impl_->data->qpos, static_cast<std::size_t>(impl_->model->nq)};
}

std::vector<std::string> World::position_names() const {
  const mjModel& m = *impl_->model;
  std::vector<std::string> names;
  for (int joint = 0; joint < static_cast<int>(m.njnt); ++joint) {
    const char* given = mj_id2name(&m, mjOBJ_JOINT, joint);  // null where a hook added a joint without a name
    const std::string name = given ? given : fmt::format("joint{}", joint);
    if (m.jnt_type[joint] != mjJNT_FREE) {
      names.push_back(name);
      continue;
    }
    for (const char* part : {"x", "y", "z", "qw", "qx", "qy", "qz"}) names.push_back(name + "/" + part);
  }
  return names;
}

int World::body(std::string_view name) const {
  return mj_name2id(impl_->model.get(), mjOBJ_BODY, std::string(name).c_str());
}

Pose World::body_pose(int body) const {
  const mjData& d = *impl_->data;
  Pose X_WB = Pose::Identity();
  X_WB.translation() = Eigen::Map<const Eigen::Vector3d>(d.xpos + 3 * body);
  X_WB.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d.xmat + 9 * body);
  return X_WB;
}

void World::push(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  std::erase_if(impl_->pushes, [body](const Impl::Push& push) { return push.body == body; });
  if (!force.isZero(0.0) || !torque.isZero(0.0)) impl_->pushes.push_back({body, force, torque});
}

double World::energy() const {
  mj_energyPos(impl_->model.get(), impl_->data.get());
  mj_energyVel(impl_->model.get(), impl_->data.get());
  return impl_->data->energy[0] + impl_->data->energy[1];
}

Result<std::size_t> World::watch_contact(const std::string& side_a, const std::string& side_b) {
  Diagnostics diagnostics;
  std::vector<std::vector<bool>> sides;
  for (const std::string& side : {side_a, side_b}) {
    sides.push_back(bodies_of(*impl_->model, side));
    if (std::ranges::find(sides.back(), true) != sides.back().end()) continue;
    diagnostics.error(Code::kUnknownName, "", fmt::format("no body or robot '{}'", side),
                      nearest_choice(side, side_names(*impl_->model)));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  impl_->watches.emplace_back(sides[0], sides[1]);
  constexpr std::size_t kPairs = 256;  // of bodies that touch; more are a rare case
  impl_->touching.reserve(kPairs);
  return impl_->watches.size() - 1;
}

const ThreadLaw& World::threads() const { return impl_->threads; }

const ContactLaw& World::contact_law() const { return *impl_->contacts; }

const ContactReading& World::contact(std::size_t watch) const { return impl_->watches.at(watch).reading(); }

void World::list_contacts_of(std::vector<bool> bodies) { impl_->contact_list.emplace(std::move(bodies)); }

std::span<const BodyContact> World::take_contacts() {
  return impl_->contact_list ? impl_->contact_list->take() : std::span<const BodyContact>();
}

std::vector<std::string> World::body_names() const {
  std::vector<std::string> names;
  for (int body = 0; body < static_cast<int>(impl_->model->nbody); ++body) {
    const char* name = body > 0 ? mj_id2name(impl_->model.get(), mjOBJ_BODY, body) : nullptr;
    names.emplace_back(name != nullptr ? name : "");
  }
  return names;
}

const mjModel_* World::model() const { return impl_->picture_model.get(); }

const mjData_* World::data() const {
  mjData* pictured = impl_->picture_data.get();
  pictured->time = impl_->data->time;
  std::copy_n(impl_->data->qpos, impl_->model->nq, pictured->qpos);
  for (std::size_t i = 0; i < impl_->lamp_wires.size(); ++i) pictured->userdata[i] = *impl_->lamp_wires[i];
  return pictured;
}

const std::vector<std::string>& World::lamps() const { return impl_->lamps; }

const mjModel_* World::physics_model() const { return impl_->model.get(); }
const mjData_* World::physics_data() const { return impl_->data.get(); }
void World::set_profiling(bool on) { impl_->profiling = on; }
StepTimes World::times() const { return impl_->times; }

}  // namespace takt::sim
