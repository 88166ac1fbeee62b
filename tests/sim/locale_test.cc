// A host program may write its numbers with a decimal comma; files keep their point.
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <locale>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/output_file.h"
#include "tests/sim/cell.h"

namespace takt::sim {
namespace {

/// Makes the locale of Germany the process's, from its description; the one before comes back.
class DecimalComma {
 public:
  DecimalComma() : folder_(*TemporaryFolder::create()), before_(std::setlocale(LC_ALL, nullptr)) {
    const std::string name = "de_DE.UTF-8";
    const std::string make = "localedef -i de_DE -f UTF-8 '" + (folder_.path() / name).string() + "' >/dev/null 2>&1";
    (void)!std::system(make.c_str());
    setenv("LOCPATH", folder_.path().c_str(), 1);
    try {
      std::locale::global(std::locale(name));
    } catch (const std::runtime_error&) {
      // Told by the test: the package 'locales' is missing.
    }
  }
  ~DecimalComma() {
    std::locale::global(std::locale::classic());
    std::setlocale(LC_ALL, before_.c_str());
    unsetenv("LOCPATH");
  }
  [[nodiscard]] static bool is_on() { return std::localeconv()->decimal_point == std::string(","); }

 private:
  TemporaryFolder folder_;
  std::string before_;
};

TEST(Locale, AWorldWithMeshesIsTheSameUnderADecimalComma) {
  const auto size_of = [] {
    WorldDescription description;
    description.robots.push_back(test::lwr());
    const auto world = World::create(description);
    if (!world) return std::make_pair(world.error().to_string(), 0.0);
    double sum = 0.0;
    for (int i = 0; i < 3 * world->model()->nmeshvert; ++i) sum += std::abs(world->model()->mesh_vert[i]);
    return std::make_pair(std::string(), sum);
  };
  const auto plain = size_of();
  EXPECT_EQ(plain.first, "");
  EXPECT_GT(plain.second, 0.0);
  const DecimalComma comma;
  ASSERT_TRUE(comma.is_on()) << "third_party/debian.txt has the package of locales";
  EXPECT_EQ(size_of(), plain);
}

}  // namespace
}  // namespace takt::sim
