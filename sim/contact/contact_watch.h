#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/contact/contact_reading.h"
#include "sim/contact/rest.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// Which bodies a name means: one body ("ROBOT/LINK", "OBJECT") or all links of a robot; all false if it means none.
[[nodiscard]] std::vector<bool> bodies_of(const mjModel_& model, const std::string& name);
/// All names that bodies_of knows, for error texts.
[[nodiscard]] std::vector<std::string> side_names(const mjModel_& model);

/// Contacts of the same two bodies that follow each other in MuJoCo's list: numbers from `begin` to before `end`.
struct TouchingBodies {
  int body1 = 0, body2 = 0, begin = 0, end = 0;
};
/// All of them; what bodies touch is asked by many watches. Realtime: cyclic; allocates only where more bodies touch
/// than ever before.
void list_touching(const mjModel_& model, const mjData_& data, std::vector<TouchingBodies>& touching);

/// Adds up the forces between two sets of bodies after each physics step. Realtime: cyclic but for construction, save
/// and restore.
class ContactWatch {
  static constexpr std::size_t kResting = 32;  ///< touches that push one way each; the forces of more are not kept

 public:
  static constexpr std::size_t kWords = 8 + 6 * kResting;  ///< of its state

  ContactWatch(const std::vector<bool>& side_a, const std::vector<bool>& side_b);

  /// Call while contact list and solver result belong together: after the solver, before the next collision pass.
  void update(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching);
  /// After update(): the forces between what falls asleep now count on until it is woken, as it has no contacts any
  /// more.
  void keep_resting(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching,
                    const Rest& rest);
  [[nodiscard]] const ContactReading& reading() const { return reading_; }
  void save(std::vector<std::uint64_t>& words) const;
  void restore(std::span<const std::uint64_t> words);

 private:
  struct Resting {
    std::int64_t body1 = 0, body2 = 0, contacts = 0;  ///< 0: free
    Eigen::Vector3d force_W = Eigen::Vector3d::Zero();
  };
  void judge_touches();
  /// Of the contacts between the sides, those of two bodies that `wanted` wants: visit(body1, body2, force on side B).
  template <class Wanted, class Visit>
  void each(const mjModel_& model, const mjData_& data, std::span<const TouchingBodies> touching, const Wanted& wanted,
            const Visit& visit) const;

  static constexpr std::uint8_t kSideA = 1, kSideB = 2;
  std::vector<std::uint8_t> sides_;  ///< of each body
  ContactReading reading_;
  std::array<Resting, kResting> resting_{};
  std::vector<Eigen::Vector3d> touches_W_;  ///< N, of the last physics step
};

/// The greatest resultant that any of these forces have together: those that push against each other do not cancel.
/// Never less than the length of their sum. Realtime: cyclic.
[[nodiscard]] double pressing_force(std::span<const Eigen::Vector3d> forces);

/// Lists what some bodies touch, from one look to the next. Realtime: cyclic but for construction, save and restore;
/// allocates only where more bodies touch than ever before.
class ContactList {
 public:
  /// @param bodies  by number: contacts in which one of them takes part
  explicit ContactList(std::vector<bool> bodies);

  /// As ContactWatch::update() and keep_resting().
  void update(const mjModel_& model, const mjData_& data);
  void keep_resting(const mjModel_& model, const mjData_& data, const Rest& rest);
  /// What touched since the last call, in the order of the bodies' numbers. Valid until the next update().
  [[nodiscard]] std::span<const BodyContact> take();
  /// What it keeps beyond a look: the number of resting pairs, then each of them.
  void save(std::vector<std::uint64_t>& words) const;
  /// @return false, and nothing changed: the words are not those of save()
  [[nodiscard]] bool restore(std::span<const std::uint64_t> words);
  [[nodiscard]] static bool fits(std::span<const std::uint64_t> words);

 private:
  static constexpr std::size_t kWordsOfPair = 8;

  struct Sum {
    int a = 0, b = 0;
    Eigen::Vector3d force_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d weighted_W = Eigen::Vector3d::Zero();  ///< sum of points times forces, m N
    double weight = 0.0;                                   ///< sum of forces, N
  };
  void add(int a, int b, const Eigen::Vector3d& force_W, const Eigen::Vector3d& point_W);
  void keep(const Sum& sum);

  std::vector<bool> bodies_;
  std::vector<Sum> step_;     ///< of one physics step, by numbers of the bodies
  std::vector<Sum> resting_;  ///< of what sleeps
  std::vector<BodyContact> list_;
  bool taken_ = false;
};

}  // namespace takt::sim
