#include "foreview/viewer/bench_table.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

namespace foreview {
namespace {

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace

BenchCell BenchCell::printed(double value) {
  return single(value);
}

BenchCell BenchCell::measured(const Quantiles& quantiles, int decimals) {
  if (quantiles.count == 0) return note("-");
  BenchCell cell = single(quantiles.median, decimals);
  cell.lower = quantiles.lower;
  cell.upper = quantiles.upper;
  cell.count = quantiles.count;
  return cell;
}

BenchCell BenchCell::single(double value, int decimals) {
  BenchCell cell;
  cell.value = value;
  cell.decimals = decimals;
  return cell;
}

BenchCell BenchCell::note(std::string text) {
  BenchCell cell;
  cell.text = std::move(text);
  return cell;
}

std::string cell_text(const BenchCell& cell) {
  if (!cell.value) return cell.text;
  std::string text = number(*cell.value, cell.decimals);
  if (cell.lower && cell.upper) {
    text += " [" + number(*cell.lower, cell.decimals) + " " + number(*cell.upper, cell.decimals) + "]";
  }
  if (cell.shows_count) text += " n=" + std::to_string(cell.count);
  return text;
}

std::string table_text(const BenchTable& table) {
  std::vector<std::vector<std::string>> lines{table.columns};
  for (const BenchTable::Row& row : table.rows) {
    std::vector<std::string> line{row.label};
    for (const BenchCell& cell : row.cells) line.push_back(cell_text(cell));
    lines.push_back(std::move(line));
  }
  std::vector<std::size_t> widths(table.columns.size());
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size() && c < widths.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::size_t total = 0;
  for (const std::size_t width : widths) total += width + 2;
  const std::string rule = "  " + std::string(total - 2, '-') + "\n";
  std::string text = (table.id.empty() ? "" : table.id + "  ") + table.title;
  if (!table.unit.empty()) text += " (" + table.unit + ")";
  text += "\n";
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (l == 1 || (l > 1 && table.rows[l - 1].is_sum && !table.rows[l - 2].is_sum)) text += rule;
    std::string line;
    for (std::size_t c = 0; c < lines[l].size() && c < widths.size(); ++c) {
      const std::string padding(widths[c] - lines[l][c].size(), ' ');
      line += "  " + (c == 0 ? lines[l][c] + padding : padding + lines[l][c]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  for (const std::string& note : table.notes) text += "  " + note + "\n";
  return text;
}

std::string table_html(const BenchTable& table) {
  std::string html = "<h3>" + html_escaped((table.id.empty() ? "" : table.id + " ") + table.title) +
                     (table.unit.empty() ? "" : " <small>" + html_escaped(table.unit) + "</small>") +
                     "</h3>\n<div class=\"scroll\"><table><thead><tr>";
  for (const std::string& column : table.columns) html += "<th>" + html_escaped(column) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const BenchTable::Row& row : table.rows) {
    html += std::string("<tr") + (row.is_sum ? " class=\"sum\"" : "") + "><th>" + html_escaped(row.label) + "</th>";
    for (const BenchCell& cell : row.cells) {
      html += "<td>";
      if (cell.value) {
        html += number(*cell.value, cell.decimals);
        if (cell.lower && cell.upper) {
          html +=
              " <small>" + number(*cell.lower, cell.decimals) + " – " + number(*cell.upper, cell.decimals) + "</small>";
        }
        if (cell.shows_count) html += " <small>n=" + std::to_string(cell.count) + "</small>";
      } else {
        html += html_escaped(cell.text);
      }
      html += "</td>";
    }
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  for (const std::string& note : table.notes) html += "<p class=\"note\">" + html_escaped(note) + "</p>\n";
  return html;
}

nlohmann::ordered_json table_json(const BenchTable& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BenchTable::Row& row : table.rows) {
    nlohmann::ordered_json cells = nlohmann::ordered_json::array();
    for (const BenchCell& cell : row.cells) {
      if (!cell.value) {
        cells.push_back(nullptr);
      } else if (cell.lower && cell.upper) {
        cells.push_back({{"median", *cell.value},
                         {"lower_quartile", *cell.lower},
                         {"upper_quartile", *cell.upper},
                         {"count", cell.count}});
      } else {
        cells.push_back(*cell.value);
      }
    }
    rows.push_back({{"label", row.label}, {"cells", std::move(cells)}});
  }
  return {{"id", table.id},           {"title", table.title},    {"unit", table.unit},
          {"columns", table.columns}, {"rows", std::move(rows)}, {"notes", table.notes}};
}

std::string html_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

}  // namespace foreview
