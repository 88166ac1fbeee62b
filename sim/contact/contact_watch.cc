#include "sim/contact/contact_watch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include <mujoco/mujoco.h>
#include <Eigen/Core>

namespace takt::sim {
namespace {

std::string body_name(const mjModel& model, int body) {
  const char* name = mj_id2name(&model, mjOBJ_BODY, body);
  return name ? name : "";
}

/// Force of a contact in the world, that the first body exerts on the second, N.
Eigen::Vector3d force_in_world(const mjModel_& model, const mjData_& data, int number) {
  std::array<double, 6> force{};
  mj_contactForce(&model, &data, number, force.data());
  // Rows of the contact frame are its axes in the world, the normal first.
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data.contact[number].frame);
  return axes.transpose() * Eigen::Map<const Eigen::Vector3d>(force.data());
}

/// Where two bodies are in a list that their numbers sort, or would be.
template <class Pairs>
auto place_of(Pairs& pairs, int a, int b) {
  return std::ranges::lower_bound(pairs, std::pair(a, b), {}, [](const auto& one) { return std::pair(one.a, one.b); });
}

}  // namespace

double pressing_force(std::span<const Eigen::Vector3d> forces) {
  // The best subset is the one in front of some plane, and its resultant is that plane's normal: from each force as a
  // normal to the resultant of all that do not push against it, until nothing changes.
  const auto pushing = [&](const Eigen::Vector3d& way) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& force : forces)
      if (force.dot(way) >= 0.0) sum += force;
    return sum;
  };
  constexpr int kRounds = 8;
  double greatest = 0.0;
  const auto climb = [&](Eigen::Vector3d way) {
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::Vector3d sum = pushing(way);
      if (sum == way) break;
      way = sum;
    }
    greatest = std::max(greatest, way.norm());
  };
  Eigen::Vector3d all = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& force : forces) all += force;
  greatest = all.norm();
  climb(all);
  for (const Eigen::Vector3d& force : forces) climb(force);
  return greatest;
}

std::vector<bool> bodies_of(const mjModel_& model, const std::string& name) {
  std::vector<bool> side(static_cast<std::size_t>(model.nbody), false);
  for (int body = 1; body < static_cast<int>(model.nbody); ++body) {
    const std::string candidate = body_name(model, body);
    side[static_cast<std::size_t>(body)] = candidate == name || candidate.starts_with(name + "/");
  }
  return side;
}

std::vector<std::string> side_names(const mjModel_& model) {
  std::vector<std::string> names;
  for (int body = 1; body < static_cast<int>(model.nbody); ++body) {
    const std::string name = body_name(model, body);
    const std::string robot = name.substr(0, name.find('/'));
    if (std::ranges::find(names, robot) == names.end()) names.push_back(robot);
    if (robot != name) names.push_back(name);
  }
  return names;
}

ContactList::ContactList(std::vector<bool> bodies) : bodies_(std::move(bodies)) {
  constexpr std::size_t kUsual = 256;  // pairs
  step_.reserve(kUsual);
  resting_.reserve(kUsual);
  list_.reserve(kUsual);
}

void ContactList::update(const mjModel_& model, const mjData_& data) {
  if (taken_) list_.clear();
  taken_ = false;
  step_.clear();
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const int first = model.geom_bodyid[contact.geom[0]], second = model.geom_bodyid[contact.geom[1]];
    if (!bodies_[static_cast<std::size_t>(first)] && !bodies_[static_cast<std::size_t>(second)]) continue;
    const Eigen::Vector3d force_W = force_in_world(model, data, i);
    const Eigen::Map<const Eigen::Vector3d> point_W(contact.pos);
    first < second ? add(first, second, force_W, point_W) : add(second, first, -force_W, point_W);
  }
  for (const Sum& sum : step_) keep(sum);
  std::erase_if(resting_, [&](const Sum& sum) { return !Rest::both_rest(model, data, sum.a, sum.b); });
  for (const Sum& sum : resting_) keep(sum);
}

void ContactList::keep_resting(const mjModel_& model, const mjData_&, const Rest& rest) {
  for (const Sum& sum : step_) {
    if (rest.both_settle(model, sum.a, sum.b)) resting_.push_back(sum);
  }
}

void ContactList::save(std::vector<std::uint64_t>& words) const {
  words.push_back(resting_.size());
  for (const Sum& sum : resting_) {
    words.push_back((static_cast<std::uint64_t>(sum.a) << 32) | static_cast<std::uint64_t>(sum.b));
    for (const Eigen::Vector3d& vector : {sum.force_W, sum.weighted_W})
      for (const double part : vector) words.push_back(std::bit_cast<std::uint64_t>(part));
    words.push_back(std::bit_cast<std::uint64_t>(sum.weight));
  }
}

bool ContactList::fits(std::span<const std::uint64_t> words) {
  return !words.empty() && words.size() % kWordsOfPair == 1 && words[0] == words.size() / kWordsOfPair;
}

bool ContactList::restore(std::span<const std::uint64_t> words) {
  if (!fits(words)) return false;
  resting_.clear();
  for (std::size_t begin = 1; begin < words.size(); begin += kWordsOfPair) {
    const auto pair = words.subspan(begin, kWordsOfPair);
    Sum sum{.a = static_cast<int>(pair[0] >> 32), .b = static_cast<int>(pair[0] & 0xffffffff)};
    for (int i = 0; i < 3; ++i) {
      sum.force_W[i] = std::bit_cast<double>(pair[1 + static_cast<std::size_t>(i)]);
      sum.weighted_W[i] = std::bit_cast<double>(pair[4 + static_cast<std::size_t>(i)]);
    }
    sum.weight = std::bit_cast<double>(pair[7]);
    resting_.push_back(sum);
  }
  return true;
}

void ContactList::add(int a, int b, const Eigen::Vector3d& force_W, const Eigen::Vector3d& point_W) {
  constexpr double kLittle = 1e-9;  // N: what only just touches has a point, too
  const double weight = force_W.norm() + kLittle;
  auto known = place_of(step_, a, b);
  if (known == step_.end() || known->a != a || known->b != b) known = step_.insert(known, {.a = a, .b = b});
  known->force_W += force_W;
  known->weighted_W += weight * point_W;
  known->weight += weight;
}

void ContactList::keep(const Sum& sum) {
  BodyContact contact{sum.a, sum.b, sum.force_W.norm(), sum.force_W, sum.weighted_W / sum.weight, sum.weight};
  const auto known = place_of(list_, sum.a, sum.b);
  if (known == list_.end() || known->a != sum.a || known->b != sum.b) {
    list_.insert(known, contact);
    return;
  }
  contact.magnitude = std::max(contact.magnitude, known->magnitude);
  known->magnitude = contact.magnitude;
  if (known->force < contact.force) *known = contact;
}

std::span<const BodyContact> ContactList::take() {
  if (taken_) list_.clear();
  taken_ = true;
  return list_;
}

void list_touching(const mjModel_& model, const mjData_& data, std::vector<TouchingBodies>& touching) {
  touching.clear();
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const int body1 = model.geom_bodyid[contact.geom[0]], body2 = model.geom_bodyid[contact.geom[1]];
    TouchingBodies* last = touching.empty() ? nullptr : &touching.back();
    if (last && last->body1 == body1 && last->body2 == body2 && last->end == i)
      ++last->end;
    else
      touching.push_back({body1, body2, i, i + 1});
  }
}

ContactWatch::ContactWatch(const std::vector<bool>& side_a, const std::vector<bool>& side_b) : sides_(side_a.size()) {
  constexpr std::size_t kUsual = 64;
  touches_W_.reserve(kUsual);
  for (std::size_t body = 0; body < sides_.size(); ++body)
    sides_[body] = static_cast<std::uint8_t>((side_a[body] ? kSideA : 0) | (side_b[body] ? kSideB : 0));
}

template <class Wanted, class Visit>
void ContactWatch::each(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching,
                        const Wanted& wanted, const Visit& visit) const {
  for (const auto& [body1, body2, begin, end] : touching) {
    const std::uint8_t first = sides_[static_cast<std::size_t>(body1)],
                       second = sides_[static_cast<std::size_t>(body2)];
    const bool straight = (first & kSideA) && (second & kSideB);
    if (!straight && !((first & kSideB) && (second & kSideA))) continue;
    if (!wanted(body1, body2)) continue;
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector3d force_W = force_in_world(model, data, i);
      visit(body1, body2, straight ? force_W : Eigen::Vector3d(-force_W));
    }
  }
}

void ContactWatch::update(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching) {
  touches_W_.clear();
  reading_.contacts = 0;
  const auto all = [](int, int) { return true; };
  each(model, data, touching, all, [&](int, int, const Eigen::Vector3d& force_W) {
    touches_W_.push_back(force_W);
    ++reading_.contacts;
  });
  bool some_woke = false;
  for (Resting& pair : resting_) {
    if (pair.contacts == 0) break;
    const int body1 = static_cast<int>(pair.body1), body2 = static_cast<int>(pair.body2);
    if (!Rest::both_rest(model, data, body1, body2)) {
      pair = {};
      some_woke = true;
      continue;
    }
    touches_W_.push_back(pair.force_W);
    reading_.contacts += static_cast<int>(pair.contacts);
  }
  if (some_woke) std::ranges::fill(std::ranges::remove(resting_, 0, &Resting::contacts), Resting{});
  judge_touches();
}

void ContactWatch::judge_touches() {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& force_W : touches_W_) sum += force_W;
  reading_.force_W = sum;
  reading_.force = sum.norm();
  reading_.max_force = std::max(reading_.max_force, reading_.force);
  reading_.pressing = pressing_force(touches_W_);
  reading_.max_pressing = std::max(reading_.max_pressing, reading_.pressing);
}

void ContactWatch::keep_resting(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching,
                                const Rest& rest) {
  constexpr double kSameWay = 0.5;  // cosine
  const auto settles = [&](int body1, int body2) { return rest.both_settle(model, body1, body2); };
  each(model, data, touching, settles, [&](int body1, int body2, const Eigen::Vector3d& force_W) {
    for (Resting& pair : resting_) {
      if (pair.contacts == 0) pair = {.body1 = body1, .body2 = body2};
      if (pair.body1 != body1 || pair.body2 != body2) continue;
      if (pair.force_W.dot(force_W) < kSameWay * pair.force_W.norm() * force_W.norm()) continue;
      ++pair.contacts;
      pair.force_W += force_W;
      return;
    }
  });
}

void ContactWatch::save(std::vector<std::uint64_t>& words) const {
  words.push_back(std::bit_cast<std::uint64_t>(reading_.force));
  words.push_back(std::bit_cast<std::uint64_t>(reading_.max_force));
  words.push_back(std::bit_cast<std::uint64_t>(reading_.pressing));
  words.push_back(std::bit_cast<std::uint64_t>(reading_.max_pressing));
  words.push_back(static_cast<std::uint64_t>(reading_.contacts));
  for (const double part : reading_.force_W) words.push_back(std::bit_cast<std::uint64_t>(part));
  for (const Resting& pair : resting_) {
    for (const std::int64_t number : {pair.body1, pair.body2, pair.contacts})
      words.push_back(static_cast<std::uint64_t>(number));
    for (const double part : pair.force_W) words.push_back(std::bit_cast<std::uint64_t>(part));
  }
}

void ContactWatch::restore(std::span<const std::uint64_t> words) {
  reading_.force = std::bit_cast<double>(words[0]);
  reading_.max_force = std::bit_cast<double>(words[1]);
  reading_.pressing = std::bit_cast<double>(words[2]);
  reading_.max_pressing = std::bit_cast<double>(words[3]);
  reading_.contacts = static_cast<int>(words[4]);
  for (std::size_t i = 0; i < 3; ++i) reading_.force_W[static_cast<int>(i)] = std::bit_cast<double>(words[5 + i]);
  for (std::size_t k = 0; k < kResting; ++k) {
    const auto word = [&](std::size_t i) { return words[8 + 6 * k + i]; };
    Resting& pair = resting_[k];
    pair.body1 = static_cast<std::int64_t>(word(0));
    pair.body2 = static_cast<std::int64_t>(word(1));
    pair.contacts = static_cast<std::int64_t>(word(2));
    for (std::size_t i = 0; i < 3; ++i) pair.force_W[static_cast<int>(i)] = std::bit_cast<double>(word(3 + i));
  }
}

}  // namespace takt::sim
