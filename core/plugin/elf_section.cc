#include "core/plugin/elf_section.h"

#include <elf.h>

#include <cstring>
#include <fstream>

#include <fmt/format.h>

namespace takt::plugin {
namespace {

/// Larger sections are not for us.
constexpr std::size_t kLargestSection = 1 << 20;

#if defined(__x86_64__)
constexpr Elf64_Half kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr Elf64_Half kMachine = EM_AARCH64;
#else
#error "which EM_ number has this processor?"
#endif

/// Reads from a file at a place; what does not lie in it is not read.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& path) : stream_(path, std::ios::binary) {
    stream_.seekg(0, std::ios::end);
    const auto end = stream_.tellg();
    size_ = end < 0 ? 0 : static_cast<std::uint64_t>(end);
  }

  bool read(std::uint64_t offset, void* to, std::uint64_t count) {
    if (offset > size_ || count > size_ - offset) return false;
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
    return static_cast<bool>(stream_);
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

std::string wrong_header(const Elf64_Ehdr& header) {
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "is not a shared object";
  if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_machine != kMachine) return "is built for another processor";
  if (header.e_type != ET_DYN || header.e_shentsize != sizeof(Elf64_Shdr)) return "is not a shared object";
  return {};
}

}  // namespace

Result<std::string> read_elf_section(const std::filesystem::path& file, std::string_view section) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return failure(Code::kNotFound, "", "there is no such file");
  if (!std::filesystem::is_regular_file(file, error)) return failure(Code::kFileNotReadable, "", "is not a file");
  Bytes bytes(file);
  Elf64_Ehdr header{};
  if (!bytes.read(0, &header, sizeof header)) return failure(Code::kFileNotReadable, "", "is not a shared object");
  if (const std::string wrong = wrong_header(header); !wrong.empty()) return failure(Code::kIncompatible, "", wrong);

  const auto cut_off = [] { return failure(Code::kSyntax, "", "is a shared object, but not whole"); };
  const auto read_entry = [&](std::uint64_t index, Elf64_Shdr& entry) {
    return index < header.e_shnum && bytes.read(header.e_shoff + index * sizeof entry, &entry, sizeof entry);
  };
  Elf64_Shdr names{};
  if (!read_entry(header.e_shstrndx, names)) return cut_off();
  std::string wanted(section.size() + 1, '\0');
  for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
    Elf64_Shdr entry{};
    if (!read_entry(i, entry)) return cut_off();
    if (!bytes.read(names.sh_offset + entry.sh_name, wanted.data(), wanted.size())) continue;
    if (wanted != std::string(section) + '\0') continue;
    if (entry.sh_size > kLargestSection) return cut_off();
    std::string content(entry.sh_size, '\0');
    if (!bytes.read(entry.sh_offset, content.data(), content.size())) return cut_off();
    return content;
  }
  return std::string();
}

}  // namespace takt::plugin
