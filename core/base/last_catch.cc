#include "core/base/last_catch.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <new>

namespace takt {
namespace {

constexpr std::size_t kTextBytes = 512, kTaskBytes = 256;

/// Appends to a buffer of fixed size; what does not fit is left out.
class Line {
 public:
  void add(std::string_view text) {
    const std::size_t size = std::min(text.size(), bytes_.size() - size_);
    std::memcpy(bytes_.data() + size_, text.data(), size);
    size_ += size;
  }
  void write_to(int stream) const { (void)!::write(stream, bytes_.data(), size_); }

 private:
  std::array<char, kTextBytes + kTaskBytes + 64> bytes_;
  std::size_t size_ = 0;
};

}  // namespace

const char* exception_text() noexcept {
  thread_local std::array<char, kTextBytes> text{};
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& error) {
    std::strncpy(text.data(), error.what(), text.size() - 1);
    return text.data();
  } catch (...) {
    return "an exception of unknown type";
  }
}

void report_exception(std::string_view task) noexcept {
  Line line;
  line.add("takt: error: internal: ");
  line.add(exception_text());
  line.add("; while doing: ");
  line.add(task.substr(0, kTaskBytes));
  line.add("\n");
  line.write_to(STDERR_FILENO);
}

}  // namespace takt
