#include "core/base/unfinished.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace takt {
namespace {

constexpr std::size_t kMostEntries = 256;  // more are not removed

/// Fixed, so that a handler can read it whatever the heap is doing.
struct Entry {
  std::atomic<bool> taken = false, valid = false;
  std::array<char, 1024> path{};
  pid_t writer = 0;
};
std::array<Entry, kMostEntries> entries;

/// In a fork: the files are those of the process that it came from. They stay taken for the copies of their owners.
void forget_all() {
  for (Entry& entry : entries) entry.valid = false;
}

/// What getdents64 gives for each name in a folder.
struct FolderEntry {
  std::uint64_t inode;
  std::int64_t offset;
  std::uint16_t length;
  std::uint8_t type;
  char name[1];
};

bool is_dots(const char* name) { return std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0; }

/// readdir() allocates, which a handler must not.
void remove_below(int parent, const char* name, int depth) {
  constexpr int kDeepest = 32;
  if (::unlinkat(parent, name, 0) == 0 || depth == kDeepest) return;
  const int folder = ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return;
  alignas(FolderEntry) std::array<char, 4096> buffer;
  for (bool found = true; found;) {
    found = false;
    const long size = ::syscall(SYS_getdents64, folder, buffer.data(), buffer.size());
    for (long at = 0; at < size;) {
      const auto* one = reinterpret_cast<const FolderEntry*>(buffer.data() + at);
      if (!is_dots(one->name)) remove_below(folder, one->name, depth + 1), found = true;
      at += one->length;
    }
  }
  ::close(folder);
  ::unlinkat(parent, name, AT_REMOVEDIR);
}

}  // namespace

Unfinished::Unfinished(const std::filesystem::path& path, pid_t writer) {
  [[maybe_unused]] static const int forgets = ::pthread_atfork(nullptr, nullptr, forget_all);
  const std::string text = path.string();
  for (std::size_t i = 0; i < entries.size() && text.size() < entries[i].path.size(); ++i) {
    if (entries[i].taken.exchange(true)) continue;
    entries[i].path.fill('\0');
    std::memcpy(entries[i].path.data(), text.data(), text.size());
    entries[i].writer = writer;
    entries[i].valid = true;
    slot_ = i;
    return;
  }
}

Unfinished::~Unfinished() {
  if (slot_ == kNone) return;
  entries[slot_].valid = false;
  entries[slot_].taken = false;
}

Unfinished::Unfinished(Unfinished&& other) noexcept : slot_(std::exchange(other.slot_, kNone)) {}

Unfinished& Unfinished::operator=(Unfinished&& other) noexcept {
  std::swap(slot_, other.slot_);
  return *this;
}

void remove_unfinished() noexcept {
  for (const Entry& entry : entries) {
    if (!entry.valid) continue;
    if (entry.writer > 0 && ::kill(entry.writer, SIGKILL) == 0) ::waitpid(entry.writer, nullptr, 0);
    remove_below(AT_FDCWD, entry.path.data(), 0);
  }
}

}  // namespace takt
