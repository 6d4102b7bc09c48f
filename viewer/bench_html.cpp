#include "foreview/viewer/bench_html.h"

namespace foreview {

std::string report_html(const BenchReport& report) {
  std::string html = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>foreview bench: " +
                     html_escaped(report.title) + "</title></head><body>\n<h1>" + html_escaped(report.title) +
                     "</h1>\n<pre>" + html_escaped(machine_text(report.machine)) + "</pre>\n";
  for (const BenchTable& table : report.tables) html += table_html(table);
  for (const std::string& finding : report.findings) html += "<p>" + html_escaped(finding) + "</p>\n";
  return html + "</body></html>\n";
}

}  // namespace foreview
