#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cell/build/built_cell.h"

namespace takt::cell {

/// Tells when two devices, objects, or one of them and the floor begin and cease to touch, with the greatest force, and
/// which contact was the hardest before a fault. Objects that stand on each other or on the floor when the run begins
/// have not begun to touch: they count once they have parted. An arm may touch itself; fingers of a gripper and parts
/// of an object do not count among themselves. The truth of the simulation: for people, never for a program (row D6).
/// Thread: the program's. Realtime: setup.
class ContactLog {
 public:
  /// @param name  "contact" or "parted"
  using Note = std::function<void(std::string_view name, const std::string& text)>;

  /// The cell must outlive it.
  explicit ContactLog(BuiltCell& built);

  /// After a cycle, or several. @param contacts  what World::take_contacts() gave
  void look(std::span<const sim::BodyContact> contacts, const Note& note);

  using Owners = std::pair<std::string, std::string>;  ///< two devices or objects, in the order of the alphabet
  /// What was between two of them in the whole run.
  struct Summary {
    Nanoseconds first = 0;
    double force = 0.0;  ///< N, the greatest
  };
  using Summaries = std::map<Owners, Summary>;
  [[nodiscard]] const Summaries& summaries() const { return summaries_; }
  /// Pairs that stand on each other since the run has begun.
  [[nodiscard]] std::size_t standing() const { return standing_.size(); }

  /// A contact of something that an arm or a base carries, or of itself.
  struct Hardest {
    std::string ours, other;  ///< names of the bodies
    double force = 0.0;       ///< N
    Nanoseconds time = 0;
  };
  /// The hardest of the last quarter of a second; nothing: there was none.
  [[nodiscard]] std::optional<Hardest> hardest_on(std::string_view device) const;

 private:
  struct Touch {
    Nanoseconds begin = 0, last = 0;
    double force = 0.0;            ///< N, the greatest so far
    Nanoseconds recent_time = 0;   ///< of the greatest lately
    double recent_force = 0.0;     ///< N
    std::pair<int, int> recent{};  ///< bodies
    bool lasts = false;
  };

  [[nodiscard]] std::string name(int body) const;
  [[nodiscard]] bool rides(int body, std::string_view device) const;
  [[nodiscard]] bool lies_about(const std::string& owner) const;
  [[nodiscard]] bool stands(const Owners& owners);
  void note_contact(const sim::BodyContact& contact, const Note& note);

  BuiltCell& built_;
  std::vector<std::string> names_;  ///< of the bodies
  std::map<Owners, Touch> touches_;
  std::map<Owners, Nanoseconds> standing_;  ///< when they touched last
  Summaries summaries_;
};

}  // namespace takt::cell
