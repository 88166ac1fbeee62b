#include "tests/support/error_sites.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace takt::test {
namespace {

/// Words by which the layers say that something is wrong.
constexpr const char* kCalls = R"(\b(error|failure|wrong|fail|broken|fault_of|throw_diagnostic|errors\.\w+_back)\()";

/// A text between quotes; `at` goes from its first quote to behind its last. Pieces that stand side by side are one.
std::string read_text(const std::string& source, std::size_t& at) {
  std::string text;
  while (at < source.size() && source[at] == '"') {
    for (++at; source[at] != '"'; ++at) {
      if (source[at] == '\\') ++at;
      text += source[at];
    }
    const std::size_t next = source.find_first_not_of(" \n", at + 1);
    ++at;
    if (next == std::string::npos || source[next] != '"') break;
    at = next;
  }
  return text;
}

/// What is said, as opposed to keys, rule ids and pointers.
bool is_message(const std::string& text) {
  return text.find(' ') != std::string::npos && !text.starts_with('/') && text != "{}: {}" && text != ", ";
}

/// The messages of a call: its first text with words, and, of "condition ? text : text", the second one too.
std::vector<std::string> messages_of(const std::string& source, std::size_t open) {
  std::vector<std::string> found;
  int depth = 0;
  for (std::size_t at = open; at < source.size();) {
    const char c = source[at];
    if (c == '"') {
      const std::string text = read_text(source, at);
      if (!is_message(text)) continue;
      found.push_back(text);
      const std::size_t next = source.find_first_not_of(" \n", at);
      if (source[next] != ':') return found;
      continue;
    }
    if (c == '(' || c == '{') ++depth;
    if ((c == ')' || c == '}') && --depth == 0) return found;
    ++at;
  }
  return found;
}

std::string without_comments(const std::string& source) {
  static const std::regex kComment("//[^\n]*");
  return std::regex_replace(source, kComment, "");
}

/// The pieces of a message between what is put in.
std::vector<std::string> pieces_of(const std::string& message) {
  std::vector<std::string> pieces(1);
  bool inside = false;
  for (const char c : message) {
    if (c == '{') pieces.emplace_back();
    inside = (inside || c == '{') && c != '}';
    if (!inside && c != '}') pieces.back() += c;
  }
  return pieces;
}

std::optional<Code> code_in(const std::string& call) {
  static const std::regex kCode(R"(Code::k(\w+))");
  std::smatch match;
  if (!std::regex_search(call, match, kCode)) return std::nullopt;
  // kUnknownName is "unknown-name".
  std::string name;
  for (const char c : match[1].str()) {
    if (std::isupper(static_cast<unsigned char>(c)) != 0 && !name.empty()) name += '-';
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return code_named(name);
}

/// From the opening bracket to the closing one.
std::string call_at(const std::string& source, std::size_t open) {
  int depth = 0;
  std::size_t at = open;
  while (at < source.size()) {
    if (source[at] == '"') {
      (void)read_text(source, at);
      continue;
    }
    if (source[at] == '(') ++depth;
    if (source[at] == ')' && --depth == 0) break;
    ++at;
  }
  return source.substr(open, at - open);
}

}  // namespace

std::vector<ErrorSite> error_sites(const std::string& folder) {
  static const std::regex kCall(kCalls);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".cc") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  std::vector<ErrorSite> sites;
  for (const auto& file : files) {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    const std::string source = without_comments(text.str());
    for (std::sregex_iterator call(source.begin(), source.end(), kCall), end; call != end; ++call) {
      const auto at = static_cast<std::size_t>(call->position() + call->length()) - 1;
      const auto line = static_cast<int>(1 + std::count(source.begin(), source.begin() + call->position(), '\n'));
      const std::optional<Code> code = code_in(call_at(source, at));
      for (const std::string& message : messages_of(source, at)) sites.push_back({file.string(), line, message, code});
    }
  }
  return sites;
}

bool says(const ErrorSite& site, std::string_view text) {
  std::size_t at = 0;
  for (const std::string& piece : pieces_of(site.message)) {
    at = text.find(piece, at);
    if (at == std::string_view::npos) return false;
    at += piece.size();
  }
  return true;
}

std::vector<std::string> unsaid(const std::vector<ErrorSite>& sites, const std::set<std::string>& said,
                                const std::vector<Excuse>& excuses) {
  std::vector<std::string> problems;
  std::vector<bool> used(excuses.size());
  for (const ErrorSite& site : sites) {
    if (std::ranges::any_of(said, [&](const std::string& text) { return says(site, text); })) continue;
    bool excused = false;
    for (std::size_t i = 0; i < excuses.size(); ++i) {
      if (!site.file.ends_with(excuses[i].file) || site.code != excuses[i].code) continue;
      excused = used[i] = true;
    }
    if (!excused)
      problems.push_back(site.file + ":" + std::to_string(site.line) + ": no case reports \"" + site.message + "\"");
  }
  for (std::size_t i = 0; i < excuses.size(); ++i)
    if (!used[i]) problems.push_back("the excuse for " + excuses[i].file + " is not needed: " + excuses[i].why);
  return problems;
}

}  // namespace takt::test
