#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "record/golden_data.h"
#include "record/recording.h"

namespace takt::record {

/// Makes the columns of a golden, topic by topic: what was commanded comes first, so that what was measured can follow
/// it. Realtime: setup.
class GoldenWriter {
 public:
  /// @param share  of the tolerance that a golden's columns may be off the run
  GoldenWriter(Golden& golden, double share) : golden_(golden), share_(share) {}
  /// @param tolerances  of its columns; those that are only reported are left out
  void add(const Table& table, const std::vector<Tolerance>& tolerances);

 private:
  using Key = std::pair<std::string, std::string>;
  void add_points(const Table& table, std::size_t column, GoldenColumn golden);
  [[nodiscard]] std::optional<GoldenCurve> curve_of(const Table& table, std::size_t column, double thinning) const;
  [[nodiscard]] std::optional<GoldenCurve> following(const Table& table, std::size_t column, double thinning) const;
  bool add_with_rate(const Table& table, std::size_t column, const std::vector<Tolerance>& tolerances);
  void put(GoldenColumn column, std::vector<double> values);

  Golden& golden_;
  double share_;
  std::map<Key, std::vector<double>> values_;  ///< of columns that others may follow, as the golden has them
};

/// The columns of a golden as curves, in the order of the golden. Realtime: setup.
class GoldenReader {
 public:
  explicit GoldenReader(const Golden& golden) : golden_(golden) {}

  struct Curve {
    std::vector<Nanoseconds> time;
    std::vector<double> value;
  };
  /// Nothing: its pieces do not fit its grid, or it follows what is not before it.
  [[nodiscard]] std::optional<Curve> read(const GoldenColumn& column);

 private:
  [[nodiscard]] std::optional<std::vector<double>> values(const GoldenColumn& column);

  const Golden& golden_;
  std::map<std::pair<std::string, std::string>, std::vector<double>> known_;
};

/// The topics that others follow; only their curves are kept while a golden is read.
[[nodiscard]] bool is_followed(const Golden& golden, const GoldenColumn& column);

}  // namespace takt::record
