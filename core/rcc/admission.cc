#include "core/rcc/admission.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>

#include "core/net/primitive.h"

namespace takt::rcc {
namespace {

/// What nets are made of: a virtual call that reads two slots and writes a third.
class Adder final : public net::Primitive {
 public:
  void bind(const net::Slot<double>* a, net::Slot<double>* out) {
    a_ = net::In<double>(a);
    out_ = net::Out<double>(out);
  }
  void update(const net::Cycle& cycle) override {
    if (a_.null()) return out_.set_null();
    out_.set(*a_ + cycle.dt);
  }

 private:
  net::In<double> a_;
  net::Out<double> out_;
};

constexpr std::size_t kAdders = 500;
constexpr double kReference_ns = 1'100.0;  // fastest round on the reference machine: docs/benchmarks.md, "The cycle"

double fastest_round_ns() {
  std::array<Adder, kAdders> adders;
  std::array<net::Slot<double>, kAdders + 1> slots;
  std::array<net::Primitive*, kAdders> order{};
  net::Out<double>(&slots[0]).set(0.0);
  for (std::size_t i = 0; i < kAdders; ++i) {
    adders[i].bind(&slots[i], &slots[i + 1]);
    order[i] = &adders[i];
  }
  double fastest = 1e12;
  for (int round = 0; round < 200; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (net::Primitive* primitive : order) primitive->update({});
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
    fastest = std::min(fastest, took.count());
  }
  return fastest;
}

}  // namespace

double machine_factor() {
  static const double kFactor = fastest_round_ns() / kReference_ns;
  return kFactor;
}

}  // namespace takt::rcc
