#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "foreview/viewer/bench_statistics.h"

namespace foreview {

/// One figure of a table, with its spread where it has one.
struct BenchCell {
  std::optional<double> value;         ///< a median where there is a spread
  std::optional<double> lower, upper;  ///< quartiles
  std::size_t count = 0;               ///< figures behind it; 0: a printed value of 2005, or not measured here
  bool shows_count = false;            ///< because it differs from that of the table's other figures
  int decimals = 1;
  std::string text;  ///< shown instead where there is no value: "-"

  BenchCell() = default;
  static BenchCell printed(double value);                                   ///< as 2005 printed it
  static BenchCell measured(const Quantiles& quantiles, int decimals = 1);  ///< '-' where nothing was measured
  static BenchCell single(double value, int decimals = 1);
  static BenchCell note(std::string text);
};

struct BenchTable {
  std::string id;  ///< "7.1"
  std::string title, unit;
  std::vector<std::string> columns;  ///< headings; the first is that of the rows' labels
  struct Row {
    std::string label;
    std::vector<BenchCell> cells;  ///< one per column after the first
    bool is_sum = false;           ///< set off from the rows above
  };
  std::vector<Row> rows;
  std::vector<std::string> notes;
};

/// "12.3 [11.9 13.0]": the median and the quartiles.
[[nodiscard]] std::string cell_text(const BenchCell& cell);
[[nodiscard]] std::string table_text(const BenchTable& table);
[[nodiscard]] std::string table_html(const BenchTable& table);
[[nodiscard]] nlohmann::ordered_json table_json(const BenchTable& table);

/// For text between tags and in attributes.
[[nodiscard]] std::string html_escaped(const std::string& text);

}  // namespace foreview
