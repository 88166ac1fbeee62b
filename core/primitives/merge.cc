// Family "selection": the way by which several fragments drive one input (row O4).
#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr std::size_t kMostInputs = 16;

template <class T>
class Merge final : public Primitive {
 public:
  explicit Merge(Setup& setup) {
    for (std::size_t i = 0; i < kMostInputs; ++i) {
      PortSpec spec = free_spec<T>("of one fragment; null while it rests", OnNull::kMayPass);
      spec.optional = i >= 2;
      const In<T> input = setup.in<T>(fmt::format("input_{}", i + 1), spec);
      // What the net leaves open costs nothing in the cycle.
      if (input.bound()) inputs_[count_++] = {input, static_cast<int>(i) + 1};
    }
    value_ = setup.out<T>("value", free_spec<T>("the input that is not null"));
    id_ = setup.id();
    setup.is_merge();
  }

  void update(const Cycle& cycle) override {
    const Entry* found = nullptr;
    for (std::size_t i = 0; i < count_; ++i) {
      if (inputs_[i].port.null()) continue;
      if (found != nullptr) return fail(cycle, found->number, inputs_[i].number);
      found = &inputs_[i];
    }
    if (found == nullptr) return value_.set_null();
    value_.set(*found->port);
  }

 private:
  struct Entry {
    In<T> port{};
    int number = 0;
  };

  void fail(const Cycle& cycle, int one, int other) {
    value_.set_null();
    std::array<char, 63> text;
    const auto end = fmt::format_to_n(text.data(), text.size(), "input_{} and input_{} at once: {}", one, other, id_);
    cycle.signals->fail_with(Cause::Code::kConflict, {text.data(), std::min(end.size, text.size())}, cycle.index);
  }

  std::array<Entry, kMostInputs> inputs_;
  std::size_t count_ = 0;
  Out<T> value_;
  std::string id_;
};

TAKT_PRIMITIVE_FOR_ALL(
    Merge, "selection",
    "Hands on the one input that is not null, so that fragments which take turns can drive one input. "
    "LOAD tries to prove that they exclude each other. Two inputs at a time fail the net: its devices "
    "stop.");

}  // namespace
}  // namespace takt::primitives
