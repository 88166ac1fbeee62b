#pragma once

#include <cstddef>

namespace takt::test {

/// Counts what this thread allocates from the heap while the guard lives: malloc and its kin, so also new, Eigen and
/// the standard library. Under AddressSanitizer and ThreadSanitizer, which own the allocator, it counts through their
/// hooks.
///
///   AllocationGuard guard;
///   net.evaluate(cycle);
///   EXPECT_EQ(guard.count(), 0u);
class AllocationGuard {
 public:
  AllocationGuard();
  [[nodiscard]] std::size_t count() const;

 private:
  std::size_t before_;
};

}  // namespace takt::test
