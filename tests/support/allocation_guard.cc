#include "tests/support/allocation_guard.h"

#include <cerrno>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TAKT_ALLOCATOR_HAS_HOOKS 1
#else
#define TAKT_ALLOCATOR_HAS_HOOKS 0
#endif

namespace {

thread_local std::size_t allocations = 0;

}  // namespace

#if TAKT_ALLOCATOR_HAS_HOOKS
// Of the sanitizer's runtime; GCC's packages do not bring the header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));
namespace {

void count_allocation(const volatile void*, std::size_t) { ++allocations; }
void ignore_release(const volatile void*) {}
const bool kHooked = __sanitizer_install_malloc_and_free_hooks(count_allocation, ignore_release) != 0;

}  // namespace
#else
// The program's own malloc goes before glibc's, which stays reachable under these names.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++allocations;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}
#endif

namespace takt::test {

AllocationGuard::AllocationGuard() : before_(allocations) {}
std::size_t AllocationGuard::count() const { return allocations - before_; }

}  // namespace takt::test
